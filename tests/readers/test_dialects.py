"""One simulated recording in every dialect gives the same recording; traps are told."""

import gzip
import warnings
import zipfile

import dialects
import numpy as np
import pandas as pd
import pytest

from mobility_imu.errors import InputError
from mobility_imu.frames import STANDARD_GRAVITY_MPS2 as G
from mobility_imu.readers.recordings import read_recording, recording_files, understand
from mobility_imu.recording import Imu, Recording

RATE_HZ, COUNT = 100, 400
DEVICES = {
    "walker": ("frame",),
    "scooter": ("lever", "body"),
    "wheelchair": ("frame", "left_wheel", "right_wheel"),
}


def made(sensors=("frame",), count=COUNT, seed=3):
    rng = np.random.default_rng(seed)
    time_s = np.arange(count) / RATE_HZ
    slow = np.sin(2 * np.pi * 0.7 * time_s)[:, None]
    imus = {}
    for k, name in enumerate(sensors):
        acc = [0.3, -0.2 * k, G] + slow * [0.5, 0.2, 0.1] + rng.normal(0, 0.02, (count, 3))
        gyr = slow * [0.1, 0.4 + k, -0.2] + rng.normal(0, 0.002, (count, 3))
        imus[name] = Imu(acc, gyr)
    return Recording(time_s, imus, source="made")


def quietly(*arguments, **options):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return read_recording(*arguments, **options)


def assert_same(found, recording, tolerance=1e-6, names=None):
    count = len(found)
    np.testing.assert_allclose(found.time_s - found.time_s[0], recording.time_s[:count], atol=1e-6)
    for ours, theirs in (names or {n: n for n in recording.sensors}).items():
        for quantity in ("acc_mps2", "gyr_radps"):
            np.testing.assert_allclose(
                getattr(found.sensor(theirs), quantity),
                getattr(recording.sensor(ours), quantity)[:count],
                atol=tolerance,
                err_msg=f"{ours} {quantity}",
            )


OF_ONE = [
    dialects.canonical, dialects.excel_german, dialects.excel_sep_line, dialects.utf16,
    dialects.pandas_index, dialects.quoted_with_extras, dialects.r_table, dialects.xsens_mt,
    dialects.xsens_dot, dialects.lpms, dialects.ngimu, dialects.ximu3, dialects.apdm,
    dialects.apdm_format_7, dialects.shimmer, dialects.movesense, dialects.actigraph,
    dialects.sensor_logger, dialects.phyphox, dialects.androsensor, dialects.physics_toolbox,
]  # fmt: skip


@pytest.mark.parametrize("write", OF_ONE, ids=lambda w: w.__name__)
def test_one_sensor_in_every_dialect(tmp_path, write):
    recording = made()
    found = quietly(write(recording, tmp_path), expected=("frame",))
    assert list(found.sensors) == ["frame"]
    assert len(found) >= COUNT - 8  # Movesense's last block may be cut
    assert_same(found, recording)


OF_SEVERAL = [
    (device, write)
    for device in ("scooter", "wheelchair")
    for write in (
        dialects.canonical,
        dialects.excel_german,
        dialects.lpms,
        dialects.ngimu,
        dialects.xsens_mt,
    )
    # Numbers do not tell which sensor of a chair is which: the next test.
    if (device, write) != ("wheelchair", dialects.lpms)
]


@pytest.mark.parametrize(
    ("device", "write"), OF_SEVERAL, ids=lambda v: v if isinstance(v, str) else v.__name__
)
def test_several_sensors_in_dialects_that_hold_them(tmp_path, write, device):
    recording = made(DEVICES[device])
    found = quietly(write(recording, tmp_path), expected=DEVICES[device])
    assert_same(found, recording)


def test_numbers_do_not_tell_which_sensor_of_a_chair_is_which(tmp_path):
    recording = made(DEVICES["wheelchair"])
    path = dialects.lpms(recording, tmp_path)
    with pytest.raises(InputError, match=r"which sensor is '1' .*frame=FILE#LABEL"):
        quietly(path, expected=DEVICES["wheelchair"])
    named = ",".join(f"{name}={path}#{k + 1}" for k, name in enumerate(recording.sensors))
    assert_same(quietly(named), recording)
    assert recording_files(named) == [path] * 3


def test_files_of_different_vendors_may_be_named_one_by_one(tmp_path):
    both = made(("lever", "body"))
    parts = {}
    for sensor, write in (("lever", dialects.ximu3), ("body", dialects.xsens_dot)):
        one = Recording(both.time_s, {"frame": both.sensor(sensor)}, source=sensor)
        parts[sensor] = write(one, tmp_path)
    named = ",".join(f"{sensor}={path}" for sensor, path in parts.items())
    # Two clocks with no start in common, and four seconds do not show how they lie to each other.
    with pytest.raises(InputError, match=r"lever: a recording of 3\.99 s.*add clock=same"):
        quietly(named)


def test_a_common_clock_is_believed(tmp_path):
    both = made(("lever", "body"))
    parts = []
    for sensor in both.sensors:
        one = Recording(both.time_s, {sensor: both.sensor(sensor)}, source=sensor)
        (tmp_path / sensor).mkdir()
        parts.append(f"{sensor}={dialects.canonical(one, tmp_path / sensor)}")
    assert_same(quietly([*parts, "clock=same"]), both)
    assert_same(quietly(",".join([*parts, "clock=same"])), both)
    assert len(recording_files([*parts, "clock=same"])) == 2
    for wrong, says in (
        ([*parts, "clock=mine"], "clock=mine: expected clock=same, clock=own or clock=start"),
        ([*parts, *parts], "named twice"),
        (["clock=same", "clock=own"], "named twice"),
        (["a.csv"] * 13, "13 files, expected at most 12"),
        (["a.csv", "clock=own"], r"a\.csv: no such file"),
        ("a.csv,clock=own", r"a\.csv: no such file"),
        (",clock=own", "the name of a file is empty"),
    ):
        with pytest.raises(InputError, match=says):
            quietly(wrong)


def test_exports_of_one_receiver_are_joined_on_their_counter(tmp_path):
    recording = made(DEVICES["wheelchair"])
    dialects.xsens_mt(recording, tmp_path)
    left = tmp_path / "MT-LeftWheel.txt"
    lines = left.read_text().split("\n")
    left.write_text("\n".join([*lines[:3], *lines[53:]]))  # it starts half a second later
    names = {"frame": "Frame", "left_wheel": "LeftWheel", "right_wheel": "RightWheel"}
    found = quietly([f"{sensor}={tmp_path}/MT-{name}.txt" for sensor, name in names.items()])
    assert len(found) == COUNT - 50
    for sensor, imu in found.sensors.items():
        np.testing.assert_allclose(imu.acc_mps2, recording.sensor(sensor).acc_mps2[50:], atol=1e-9)
    unnamed = quietly([tmp_path / f"MT-{name}.txt" for name in names.values()])
    assert sorted(unnamed.sensors) == sorted(names)


@pytest.mark.parametrize("write", [dialects.sensor_logger, dialects.ngimu, dialects.phyphox])
def test_archives_are_read_like_folders(tmp_path, write):
    recording = made()
    (tmp_path / "session").mkdir()
    folder = write(recording, tmp_path / "session")
    with zipfile.ZipFile(tmp_path / "session.zip", "w") as archive:
        for file in sorted(folder.rglob("*.csv")):
            archive.write(file, file.relative_to(folder))
    assert_same(quietly(tmp_path / "session.zip", expected=("frame",)), recording)


# Traps: corrected with a word, or refused with one.


def test_ios_reads_gravity_with_the_other_sign(tmp_path):
    recording = made()
    folder = dialects.sensor_logger(recording, tmp_path, platform="ios")
    found = understand(folder)
    assert any("signs of the accelerations reversed" in w for w in found.warnings)
    assert_same(found.recording, recording)
    (tmp_path / "Metadata.csv").unlink()
    with pytest.raises(InputError, match=r"no Metadata\.csv, which states the platform"):
        understand(folder)


def test_a_phone_without_gravity_is_refused(tmp_path):
    dialects.sensor_logger(made(), tmp_path)
    (tmp_path / "TotalAcceleration.csv").unlink()
    with pytest.raises(InputError, match="no accelerations with gravity; record TotalAcceleration"):
        understand(tmp_path)
    table = "Time (s),Linear Acceleration x (m/s^2),Linear Acceleration y (m/s^2)," \
        "Linear Acceleration z (m/s^2)\n0,0,0,0\n0.01,0,0,0\n"  # fmt: skip
    (tmp_path / "linear.csv").write_text(table)
    with pytest.raises(InputError, match="accelerations without gravity; record 'Acceleration"):
        understand(tmp_path / "linear.csv")


def test_lost_packets_of_an_xsens_sensor(tmp_path):
    recording = made()
    prefix = dialects.xsens_mt(recording, tmp_path)
    path = tmp_path / "MT-Frame.txt"
    lines = path.read_text().split("\n")
    cells = lines[100].split("\t")
    lines[100] = "\t".join([cells[0], *[""] * 6])
    path.write_text("\n".join(lines))
    with pytest.raises(InputError, match=r"gap of 0\.02 s"):
        quietly(prefix)
    with pytest.warns(UserWarning, match="1 gap.* filled in with 1 interpolated"):
        found = understand(prefix, fill_gaps_s=0.05)
    assert any("1 lost packet(s), rows without readings" in w for w in found.warnings)
    assert len(found.recording) == COUNT


def test_the_rate_of_an_xsens_file_is_its_clock_or_is_asked_for(tmp_path):
    recording = made()
    found = understand(dialects.xsens_mt(recording, tmp_path, head="", fine=True))
    assert found.rate_from == "SampleTimeFine"
    assert_same(found.recording, recording)
    prefix = dialects.xsens_mt(recording, tmp_path, head="")
    with pytest.raises(
        InputError, match="states no sampling rate; give it with --sampling-rate-hz"
    ):
        understand(prefix)
    assert understand(prefix, sampling_rate_hz=100).rate_from == "given"


@pytest.mark.parametrize("separator", [",", ";", " "])
def test_the_separator_is_an_option_of_mt_manager(tmp_path, separator):
    recording = made()
    assert_same(quietly(dialects.xsens_mt(recording, tmp_path, separator)), recording)


def test_empty_cells_between_blanks_do_not_shift_the_columns(tmp_path):
    names = "PacketCounter UTC_Nano UTC_Year Acc_X Acc_Y Acc_Z Gyr_X Gyr_Y Gyr_Z"
    rows = [f"{k}   0.1 0.2 9.8 0.01 0.02 0.03" for k in range(5)]
    (tmp_path / "a.txt").write_text("\n".join(["// Update Rate: 100.0Hz", names, *rows, ""]))
    imu = quietly(tmp_path / "a.txt").sensor("frame")
    assert imu.acc_mps2[0].tolist() == [0.1, 0.2, 9.8]
    assert imu.gyr_radps[0].tolist() == [0.01, 0.02, 0.03]


@pytest.mark.parametrize("row", [100, 350])
def test_one_wrong_counter_is_no_wrap(tmp_path, row):
    prefix = dialects.xsens_mt(made(), tmp_path)
    path = tmp_path / "MT-Frame.txt"
    lines = path.read_text().split("\n")
    lines[row] = "\t".join(["60000", *lines[row].split("\t")[1:]])
    path.write_text("\n".join(lines))
    with pytest.raises(InputError, match="packet counter runs backwards at row"):
        quietly(prefix)


def test_held_values_and_uneven_stamps_are_told(tmp_path):
    recording = made()
    path = dialects.physics_toolbox(recording, tmp_path)
    table = pd.read_csv(path, skiprows=1, index_col=False).iloc[:, :7]
    table.iloc[:, 1:4] = table.iloc[:, 1:4].to_numpy()[(np.arange(COUNT) // 4) * 4]
    table["time"] += np.where(np.arange(COUNT) % 2, 0.006, 0.0)
    table.to_csv(path, index=False)
    found = understand(path)
    assert any("75 % of the samples repeat the one before" in w for w in found.warnings)
    (stamps,) = [w for w in found.warnings if "interpolated to an even clock of 99.8" in w]
    assert stamps.endswith("for its stamps are not even")


def test_doubled_packets_are_left_out_with_a_word(tmp_path):
    path = dialects.ximu3(made(), tmp_path)
    lines = path.read_text().split("\n")
    path.write_text("\n".join([*lines[:50], lines[49], *lines[50:]]))
    found = understand(path)
    assert any("1 sample(s) left out whose stamps repeat" in w for w in found.warnings)


def test_a_long_gap_is_no_straight_line_unless_it_is_asked_for(tmp_path):
    path = dialects.lpms(made(), tmp_path)
    lines = path.read_text().split("\n")
    path.write_text("\n".join([*lines[:100], *lines[140:]]))
    with pytest.raises(InputError, match=r"gap of 0\.41 s after 0\.98 s.*--fill-gaps-s"):
        understand(path)
    filled = understand(path, fill_gaps_s=0.5)
    assert len(filled.recording) == pytest.approx(COUNT, abs=1)
    assert any("1 gap(s) bridged by straight lines" in w for w in filled.warnings)


def test_units_are_read_and_what_is_no_unit_is_refused(tmp_path):
    path = dialects.lpms(made(), tmp_path)
    path.write_text(path.read_text().replace("AccX (g)", "AccX (furlong)"))
    with pytest.raises(
        InputError, match="acceleration in 'furlong' is not known; expected m/s2, g"
    ):
        understand(path)


def without_rate(folder):
    recording = made(DEVICES["wheelchair"])
    table = {}
    for sensor, name in zip(
        recording.sensors, ("Chassis", "RoueGauche", "RoueDroite"), strict=True
    ):
        table |= dialects.columns(
            recording.sensor(sensor),
            [f"{name}_Acc_{a}" for a in "XYZ"],
            [f"{name}_Gyr_{a}" for a in "XYZ"],
        )
    pd.DataFrame(table).to_csv(folder / "wheelmove.csv", index=False, sep=";")
    names = [*(f"Gyroscope {a} (deg/s)" for a in "XYZ"), *(f"Accelerometer {a} (g)" for a in "XYZ")]
    rows = np.hstack(
        [np.rad2deg(recording.gyroscope("frame")), recording.sensor("frame").acc_mps2 / G]
    )
    table = pd.DataFrame(
        {"Packet number": np.arange(COUNT)} | dict(zip(names, rows.T, strict=True))
    )
    table.to_csv(folder / "CalInertialAndMag.csv", index=False)
    one = Recording(recording.time_s, {"frame": recording.sensor("frame")}, source="made")
    dialects.xsens_mt(one, folder, head="")
    return [folder / name for name in ("wheelmove.csv", "CalInertialAndMag.csv", "MT-Frame.txt")]


def test_a_format_that_states_no_rate_asks_for_it(tmp_path):
    for path in without_rate(tmp_path):
        with pytest.raises(InputError, match=r"states no sampling rate.*--sampling-rate-hz"):
            understand(path)
        found = understand(path, sampling_rate_hz=50)
        assert found.recording.sampling_rate_hz == pytest.approx(50)
        assert found.rate_from == "given"


@pytest.mark.parametrize("write", OF_ONE, ids=lambda w: w.__name__)
def test_a_rate_that_a_file_states_is_not_replaced(tmp_path, write):
    """Every other format has a clock or states its rate, so nothing is asked."""
    found = understand(write(made(), tmp_path), expected=("frame",), sampling_rate_hz=37)
    assert found.rate_from != "given"
    assert found.recording.sampling_rate_hz == pytest.approx(RATE_HZ, rel=0.01)
    assert any("the given 37 Hz are not used" in sentence for sentence in found.warnings)


MAP = """
[clock]
column = "t"
unit = "ms"
[sensors.frame]
acc = ["ax", "ay", "-az"]
acc_unit = "g"
gyr = ["p", "q", "-r"]
gyr_unit = "deg/s"
"""


def mapped(recording, folder):
    imu = recording.sensor("frame")
    table = {"t": recording.time_s * 1e3, "label": "walking"} | dialects.columns(
        imu, ["ax", "ay", "az"], ["p", "q", "r"], 1 / G, 180 / np.pi
    )
    table["az"], table["r"] = -table["az"], -table["r"]
    pd.DataFrame(table).to_csv(folder / "own.csv", index=False)
    (folder / "map.toml").write_text(MAP)
    return folder / "own.csv", folder / "map.toml"


def test_any_other_table_by_a_map(tmp_path):
    recording = made()
    path, plan = mapped(recording, tmp_path)
    with pytest.raises(InputError, match=r"unknown format.*--map"):
        understand(path)
    assert_same(understand(path, map_path=plan).recording, recording)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (('unit = "ms"', ""), r"\[clock\] unit: expected s, ms, us, ns"),
        (('column = "t"', 'colon = "t"'), "colon is unknown"),
        (('"ax", "ay"', '"ax"'), "acc must name three columns"),
        (('acc_unit = "g"', ""), "acc_unit is missing"),
        (('acc_unit = "g"', 'acc_unit = "G-force"'), "acceleration in 'G-force' is not known"),
        (('"ax"', '"a_x"'), "no column a_x"),
        (("[sensors.frame]", "[sensor.frame]"), "sensor is unknown"),
        (("[clock]", "[clock"), "not valid TOML"),
    ],
)
def test_a_map_that_says_too_little_or_too_much(tmp_path, change, message):
    path, plan = mapped(made(), tmp_path)
    plan.write_text(MAP.replace(*change))
    with pytest.raises(InputError, match=message):
        understand(path, map_path=plan)


@pytest.mark.parametrize("name", ["ride.csv", "RIDE.CSV.GZ", "ride.csv.gz"])
def test_a_packed_file_is_known_by_its_content(tmp_path, name):
    """Browsers and people rename what they save."""
    recording = made()
    packed = gzip.compress(dialects.canonical(recording, tmp_path).read_bytes())
    (tmp_path / name).write_bytes(packed)
    assert_same(quietly(tmp_path / name), recording)


def test_an_array_of_objects_is_no_canonical_table(tmp_path):
    (tmp_path / "a.json").write_text(made().to_frame().to_json(orient="records"))
    with pytest.raises(InputError, match=r"unknown format.*--map"):
        understand(tmp_path / "a.json")


def test_what_fits_two_formats_or_none_is_refused(tmp_path):
    (tmp_path / "a.csv").write_text("angle_deg,speed\n1,2\n")
    with pytest.raises(InputError, match="unknown format"):
        understand(tmp_path / "a.csv")
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError, match="without a session that is known"):
        understand(tmp_path / "empty")
    (tmp_path / "no.zip").write_bytes(b"PK\x03\x04 broken")
    with pytest.raises(InputError, match="cannot be opened as an archive"):
        understand(tmp_path / "no.zip")
