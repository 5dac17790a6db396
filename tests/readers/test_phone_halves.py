"""A phone's accelerations and rates come in two files: holes, ends, pauses, signs."""

import dialects
import numpy as np
import pytest
from test_dialects import assert_same, made, quietly

from mobility_imu.errors import InputError
from mobility_imu.frames import STANDARD_GRAVITY_MPS2 as G
from mobility_imu.readers.halves import Half, join_halves
from mobility_imu.readers.recordings import understand

WRITERS = pytest.mark.parametrize("write", [dialects.sensor_logger, dialects.phyphox])


def drop(file, first, last):
    head, *rows = file.read_text().rstrip().split("\n")
    file.write_text("\n".join([head, *rows[:first], *rows[last:]]))


# Holes and ends


@WRITERS
@pytest.mark.parametrize("name", ["Gyroscope", "acc"])
def test_a_hole_in_the_rates_is_a_gap_as_one_in_the_accelerations(tmp_path, write, name):
    folder = write(made(count=2000), tmp_path)
    if name == "acc":
        name = next(n for n in ("TotalAcceleration", "Accelerometer")
                    if (folder / f"{n}.csv").exists())  # fmt: skip
    drop(folder / f"{name}.csv", 500, 900)
    with pytest.raises(InputError, match=r"gap of 4\.01 s after 4\.99 s .*--fill-gaps-s"):
        quietly(folder)
    found = understand(folder, fill_gaps_s=5.0)
    assert any("bridged by straight lines, the longest of 4.01 s" in w for w in found.warnings)


@WRITERS
def test_the_message_says_that_the_rates_have_the_hole(tmp_path, write):
    folder = write(made(count=2000), tmp_path)
    drop(folder / "Gyroscope.csv", 500, 900)
    says = (
        r"gap of 4\.01 s after 4\.99 s .*: gap of 4\.01 s in the rates \(.*Gyroscope\.csv\); give"
    )
    with pytest.raises(InputError, match=says):
        quietly(folder)


@WRITERS
def test_a_gap_elsewhere_in_the_rates_is_not_named_as_the_cause(tmp_path, write):
    """Neither one that is short enough to be bridged, nor a long one at another place."""
    folder = write(made(count=2000), tmp_path)
    acc = next(n for n in ("TotalAcceleration", "Accelerometer")
               if (folder / f"{n}.csv").exists())  # fmt: skip
    drop(folder / "Gyroscope.csv", 1500, 1505)
    drop(folder / f"{acc}.csv", 500, 900)
    with pytest.raises(
        InputError, match=r"gap of 4\.01 s after 4\.99 s \(1 [^:]*\); give"
    ) as error:
        quietly(folder)
    assert "in the rates" not in str(error.value)
    drop(folder / "Gyroscope.csv", 1200, 1300)
    with pytest.raises(InputError, match=r"gap of 4\.01 s after 4\.99 s \(2 [^:]*\); give"):
        quietly(folder)
    with pytest.raises(InputError, match=r"gap of 4\.01 s .* \(2 [^:]*\); give"):
        quietly([f"lever={folder}", "clock=own"])


def test_the_cause_moves_with_the_times(tmp_path):
    """Files that are joined may be shifted; the cause stays with its samples."""
    for name in ("lever", "body"):
        (tmp_path / name).mkdir()
        dialects.sensor_logger(made(count=2000), tmp_path / name)
    drop(tmp_path / "body" / "Gyroscope.csv", 500, 900)
    parts = [f"{name}={tmp_path}/{name}" for name in ("lever", "body")]
    for clock in ("same", "start"):
        with pytest.raises(InputError, match=r"body: gap of 4\.01 s .*in the rates \(body/Gyr"):
            quietly([*parts, f"clock={clock}"])


@WRITERS
def test_a_short_hole_in_the_rates_is_told(tmp_path, write):
    folder = write(made(count=2000), tmp_path)
    drop(folder / "Gyroscope.csv", 500, 505)
    found = understand(folder)
    assert any("1 gap(s) in the rates, the longest of 0.06 s after 4.99 s" in w
               for w in found.warnings)  # fmt: skip
    assert len(found.recording) == 2000


@WRITERS
def test_rates_that_were_copied_in_part_are_told(tmp_path, write):
    folder = write(made(count=2000), tmp_path)
    drop(folder / "Gyroscope.csv", 500, 2000)
    found = understand(folder)
    assert len(found.recording) == 500
    (said,) = [w for w in found.warnings if "left out" in w]
    assert "the last 15.00 s (rates only until 4.99 s) of 19.99 s left out" in said


def test_rates_whose_clock_jumps_back_are_refused():
    time_s = np.arange(1000) / 100
    values = np.tile([0.0, 0.0, G], (1000, 1))
    back = np.r_[time_s[:600], time_s[600:] - 3]
    with pytest.raises(InputError, match=r"g\.csv: the clock jumps back by 2\.99 s at sample 601"):
        join_halves(Half(time_s, values, "a.csv"), Half(back, 0 * values, "g.csv"), "folder")


def test_rates_of_a_slow_gyroscope_have_no_holes():
    time_s = np.arange(1000) / 100
    values = np.tile([0.0, 0.0, G], (1000, 1))
    slow = np.arange(0, 10.1, 0.2)
    found = join_halves(
        Half(time_s, values, "a.csv"), Half(slow, np.zeros((len(slow), 3)), "g.csv"), "folder"
    )
    assert len(found) == 1000
    assert found.warnings == ("folder: rates interpolated to the accelerations' stamps",)


# Pauses


def paused(folder, rows, separator=","):
    head = separator.join(f'"{n}"' for n in ("event", "experiment time", "system time", "text"))
    lines = [separator.join([f'"{event}"', *map(str, times), '"a"']) for event, *times in rows]
    (folder / "meta" / "time.csv").write_text("\n".join([head, *lines, ""]))


ONE_PAUSE = [
    ("START", 0.0, 1715100946.594),
    ("PAUSE", 8.0, 1715100954.594),
    ("START", 8.0, 1715100984.594),
    ("PAUSE", 20.0, 1715100996.6),
]


@pytest.mark.parametrize("separator", [",", ";", "\t"])
def test_a_pause_is_a_gap(tmp_path, separator):
    folder = dialects.phyphox(made(count=2000), tmp_path, separator)
    paused(folder, ONE_PAUSE, separator)
    says = r"gap of 30 s after 7\.99 s .*: pause of 30 s \(meta/time\.csv\); give --fill-gaps-s"
    with pytest.raises(InputError, match=says):
        quietly(folder)
    found = understand(folder, fill_gaps_s=40)
    assert found.recording.time_s[-1] == pytest.approx(49.99, abs=0.02)
    assert any("a pause is a gap" in w for w in found.warnings)


def moved_rates(folder, by_s):
    """Rates with stamps of their own, as most phones have them."""
    file = folder / "Gyroscope.csv"
    head, *rows = file.read_text().rstrip().split("\n")
    cells = [row.split(",") for row in rows]
    rows = [",".join([f"{float(time) + by_s:.15E}", *values]) for time, *values in cells]
    file.write_text("\n".join([head, *rows]))


@pytest.mark.parametrize("by_s", [0.0, 0.003])
def test_one_pause_is_told_once(tmp_path, by_s):
    """It is no loss of the rates as well."""
    folder = dialects.phyphox(made(count=2000), tmp_path)
    paused(folder, ONE_PAUSE)
    moved_rates(folder, by_s)
    with pytest.raises(InputError, match=r": pause of 30 s \(meta/time\.csv\); give") as error:
        quietly(folder)
    assert str(error.value).count("pause of") == 1 and "in the rates" not in str(error.value)
    found = understand(folder, fill_gaps_s=40)
    assert sum("pause(s)" in w for w in found.warnings) == 1
    assert not any("gap(s) in the rates" in w for w in found.warnings)


@pytest.mark.parametrize("by_s", [0.0, 0.003])
def test_the_cause_is_that_of_the_longest_gap(tmp_path, by_s):
    """Of a pause of 2 s and a hole of 4 s in the rates, each is named at its place."""
    folder = dialects.phyphox(made(count=2000), tmp_path)
    short = [ONE_PAUSE[0], ONE_PAUSE[1], ("START", 8.0, 1715100956.594)]
    paused(folder, short)
    moved_rates(folder, by_s)
    drop(folder / "Gyroscope.csv", 1200, 1600)
    with pytest.raises(InputError, match=r": gap of 4\.01 s in the rates \([^)]*Gyroscope\.csv\);"):
        quietly(folder)
    with pytest.raises(InputError, match=r"gap of 4\.0\d s after 13\.9\d s .*in the rates"):
        quietly(folder, fill_gaps_s=3.0)
    found = understand(folder, fill_gaps_s=5.0)
    assert any("1 gap(s) in the rates, the longest of 4.01 s" in w for w in found.warnings)
    paused(folder, [*ONE_PAUSE[:2], ("START", 8.0, 1715100964.594)])
    with pytest.raises(InputError, match=r"gap of 10 s after 7\.9\d s .*: pause of 10 s"):
        quietly(folder)


def test_a_pause_in_an_unpacked_folder_is_seen(tmp_path):
    (tmp_path / "unpacked").mkdir()
    paused(dialects.phyphox(made(count=2000), tmp_path / "unpacked"), ONE_PAUSE)
    with pytest.raises(InputError, match=r"gap of 30 s"):
        quietly(tmp_path)


def test_a_pause_before_or_after_the_samples_is_none(tmp_path):
    recording = made(count=2000)
    folder = dialects.phyphox(recording, tmp_path)
    paused(folder, [ONE_PAUSE[0], ("PAUSE", 20.0, 1715100966.6), ("START", 20.0, 1715101000.0)])
    found = understand(folder)
    assert_same(found.recording, recording)
    assert found.warnings == ()


@pytest.mark.parametrize("wrong", [1715100900.0, "x"])
def test_a_pause_of_unknown_length_is_refused(tmp_path, wrong):
    folder = dialects.phyphox(made(count=2000), tmp_path)
    paused(folder, [*ONE_PAUSE[:2], ("START", 8.0, wrong)])
    with pytest.raises(InputError, match=r"meta/time\.csv: a pause after 8\.00 s, whose length"):
        quietly(folder)


def test_other_tables_of_events_are_passed_over(tmp_path):
    recording = made()
    folder = dialects.phyphox(recording, tmp_path)
    for text in ("", '"event"\n', '"kind","when"\n"PAUSE",1\n'):
        (folder / "meta" / "time.csv").write_text(text)
        assert_same(quietly(folder), recording)


# Signs


def standardised(folder, value):
    (folder / "Metadata.csv").write_text(
        f"version,device name,platform,appVersion,standardisation\n3,phone,ios,1.31.4,{value}"
    )


@pytest.mark.parametrize("left", ["Gravity", "AccelerometerUncalibrated"])
def test_ios_with_the_units_and_frames_of_android_is_not_reversed(tmp_path, left):
    """The app's CROSSPLATFORM.md: with the setting on, iOS conforms to Android's definition."""
    recording = made()
    folder = dialects.sensor_logger(recording, tmp_path, platform="ios")
    for name in ("Accelerometer", "Gravity", "AccelerometerUncalibrated"):
        head, *rows = (folder / f"{name}.csv").read_text().split("\n")
        cells = np.array([row.split(",") for row in rows])
        scale = -G if name == "AccelerometerUncalibrated" else -1
        cells[:, 2:] = (scale * cells[:, 2:].astype(float)).astype(str)
        (folder / f"{name}.csv").write_text("\n".join([head, *map(",".join, cells)]))
    (folder / f"{left}.csv").unlink()
    standardised(folder, "true")
    found = understand(folder)
    assert_same(found.recording, recording)
    assert any("signs of the accelerations kept" in w for w in found.warnings)
    standardised(folder, "perhaps")
    with pytest.raises(InputError, match="standardisation 'perhaps', expected true or false"):
        understand(folder)


@pytest.mark.parametrize("value", ["", "false"])
def test_ios_without_the_setting_is_reversed(tmp_path, value):
    recording = made()
    folder = dialects.sensor_logger(recording, tmp_path, platform="ios")
    standardised(folder, value)
    assert_same(quietly(folder), recording)
