"""Small files as people have them, each a kind of trouble: what the commands answer."""

import csv
from pathlib import Path

import pytest

CASES = Path(__file__).resolve().parents[1] / "cases"


def table(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def angles(case, *options):
    return ("scooter", "angles", CASES / case, "--geometry", CASES / "scooter.toml", "-o", "a.csv",
            *options)  # fmt: skip


def walk(case, *options):
    geometry = CASES / "walker_mount.toml"
    return ("walker", "trajectory", CASES / case, "--geometry", geometry, "-o", "p.csv", *options)


def drive(command, trial, static="base_static", straight="base_straight"):
    line = ["wheelchair", command, CASES / f"{trial}.csv.gz"]
    line += ["--static", CASES / f"{static}.csv.gz", "--straight", CASES / f"{straight}.csv.gz"]
    line += ["--geometry", CASES / "chair.toml"]
    return line + (["-o", "v.csv"] if command == "velocity" else [])


def turn_deg(path):
    rows = table(path)
    step = float(rows[1]["time_s"]) - float(rows[0]["time_s"])
    return sum(float(row["yaw_rate_degps"]) for row in rows) * step


def end(path):
    rows = table(path)
    return float(rows[-1]["x_m"]), float(rows[-1]["y_m"])


@pytest.mark.parametrize(
    "case",
    ["c15_lpms_control", "c20_excel_semicolon_comma", "c22_pandas_index", "c24_sep_line"],
)
def test_the_same_ride_in_four_dialects(works, tmp_path, case):
    works(*angles(f"{case}.csv"))
    (row,) = [r for r in table(tmp_path / "a.csv") if float(r["time_s"]) == 4.0]
    assert float(row["steering_deg"]) == pytest.approx(36.67, abs=0.005)
    assert float(row["throttle_deg"]) == pytest.approx(33.03, abs=0.005)


def test_lpms_numbers_and_signs_are_told(works):
    said = works(*angles("c15_lpms_control.csv")).stderr
    assert "sensors taken in their order: '1' as lever, '2' as body" in said
    assert "LPMS reads -1 g on the axis that is up" in said


@pytest.mark.parametrize("options", [(), ("--method", "fusion")])
def test_time_in_milliseconds_is_asked_about(fails, options):
    fails(*angles("c03_time_in_ms.csv", *options), says=["sampling rate of 0.1 Hz", "times in s?"])


@pytest.mark.parametrize("options", [(), ("--method", "fusion")])
def test_one_sensor_given_twice(fails, options):
    says = ["lever and body have the same readings"]
    fails(*angles("c01_same_sensor_twice.csv", *options), says=says)


def test_the_clock_of_an_xsens_file(works, tmp_path):
    said = works(*walk("c04_walk60hz")).stderr
    assert "42.0 s at 60 Hz" in said
    assert end(tmp_path / "p.csv")[0] == pytest.approx(5.27, abs=0.05)


@pytest.mark.parametrize(
    "case", ["MT_c18device01-000.txt", "MT_c18device01", "c19comma", "c19comma-Frame.txt"]
)
def test_names_and_separators_of_xsens_files(works, tmp_path, case):
    works(*walk(case))
    assert end(tmp_path / "p.csv") == pytest.approx((1.77, 0.01), abs=0.01)


def test_lost_packets_are_filled_when_it_is_asked_for(works, fails, tmp_path):
    fails(*walk("c27_blank_packets"), says=["gap of 0.03 s after 3.01 s"])
    said = works(*walk("c27_blank_packets", "--fill-gaps-s", "0.1")).stderr
    assert "3 lost packet(s)" in said
    assert end(tmp_path / "p.csv") == pytest.approx((1.77, 0.01), abs=0.01)


@pytest.mark.parametrize("options", [(), ("--no-smooth",)])
def test_an_acceleration_that_no_sensor_measures(fails, options):
    fails(*walk("c30_acc_garbage.csv.gz", *options), says=["is 1e+30 m/s² at 4.02 s"])


def test_an_ximu3(works, tmp_path):
    assert "6.0 s at 100 Hz" in works(*walk("c35_ximu3_Inertial.csv")).stderr
    assert end(tmp_path / "p.csv") == pytest.approx((0.30, 0.06), abs=0.01)


def test_a_gyroscope_offset_is_taken_off(works, tmp_path):
    trials = ("c06_trial", "c06_static", "c06_straight")
    said = works(*drive("velocity", *trials)).stderr
    assert "the gyroscope of frame has an offset" in said
    assert turn_deg(tmp_path / "v.csv") == pytest.approx(150, abs=5)
    assert "the geometry fits" in works(*drive("check", *trials)).stdout


@pytest.mark.parametrize(
    ("case", "sensor"),
    [("c09_frame_gyro_dies", "frame_gyr"), ("c10_left_wheel_freezes", "left_wheel")],
)
def test_a_sensor_that_dies_is_told(works, case, sensor):
    said = works(*drive("velocity", case)).stderr
    assert f"{sensor} in 2000 samples, first at 10.00 s, repeats its last reading" in said
    assert said.count("replace it there") == 1 and said.count("repeats its last reading") == 1
    found = works(*drive("check", case))
    assert f"{sensor} in 2000 samples" in found.stderr
    assert "the geometry fits" not in found.stdout


def test_a_late_sensor_is_no_camber(works):
    found = works(*drive("check", "c14_frame_late")).stdout
    assert "lag of the wheels           -1.0" in found and "camber of" not in found
    assert "there is no verdict on track, radii and camber" in found
    assert "the geometry fits" not in found


def test_which_sensor_is_late_and_what_it_costs(works):
    said = works(*drive("velocity", "c14_frame_late")).stderr
    assert "frame lags by 1.0" in said and "against the two others" in said
    assert "it moves the" in said


def test_the_other_sensors_stand_in_for_one_that_dies(works, tmp_path):
    """A wheel that freezes after 10 s of 30, and a frame: way and turn as without the fault."""
    for case in ("c09_frame_gyro_dies", "c10_left_wheel_freezes"):
        works(*drive("velocity", case))
        rows = table(tmp_path / "v.csv")
        way_m = sum(float(row["linear_velocity_mps"]) for row in rows) / 100
        assert way_m == pytest.approx(12.8, abs=0.05)
        assert turn_deg(tmp_path / "v.csv") == pytest.approx(150, abs=2)
        assert {row["valid"] for row in rows} == {"1"}


def test_strict_refuses_what_is_told_otherwise(fails):
    line = [*drive("velocity", "c09_frame_gyro_dies"), "--strict"]
    fails(*line, says=["frame_gyr in 2000 samples"])


def test_read_shows_what_is_understood_and_writes_it(works, tmp_path):
    found = works("read", CASES / "c35_ximu3_Inertial.csv", "-o", "own.csv")
    assert "format    x-io" in found.stdout and "100 Hz, from its clock" in found.stdout
    assert "median length 9.789" in found.stdout
    again = works("read", "own.csv").stdout
    assert "format    canonical CSV" in again
    assert list(table(tmp_path / "own.csv")[0])[:2] == ["time_s", "frame_acc_x_mps2"]
