"""Several files given together: their names, their clocks, and what is said of both."""

import warnings
import zipfile

import dialects
import numpy as np
import pytest
from test_dialects import DEVICES, assert_same, made, quietly
from test_lags import write_apart

from mobility_imu.data import recordings_folder
from mobility_imu.errors import InputError
from mobility_imu.readers import xsens_mt
from mobility_imu.readers.recordings import read_recording, recording_files, understand
from mobility_imu.recording import Recording

CHAIR = DEVICES["wheelchair"]
NAMES = {"frame": "Frame", "left_wheel": "LeftWheel", "right_wheel": "RightWheel"}
XSENS = recordings_folder() / "vendor" / "wheelchair"


def one_of(recording, name, time_s=None, sensor=None):
    imu = recording.sensor(name)
    time_s = recording.time_s if time_s is None else time_s
    return Recording(time_s, {sensor or name: imu}, source=name)


def apart(recording, folder, changed=(), sensors=None):
    """Canonical files, one for each sensor."""
    files = []
    for name in recording.sensors:
        files.append(folder / f"{name}.csv")
        time_s = recording.time_s + dict(changed).get(name, 0.0)
        one = one_of(recording, name, time_s, dict(sensors or {}).get(name))
        one.to_frame().to_csv(files[-1], index=False)
    return files


def late_exports(folder, late=50):
    """Exports of one receiver, of which the left wheel's starts half a second later."""
    recording = made(CHAIR)
    dialects.xsens_mt(recording, folder)
    left = folder / "MT-LeftWheel.txt"
    lines = left.read_text().split("\n")
    left.write_text("\n".join([*lines[:3], *lines[3 + late :]]))
    return recording, [f"{sensor}={folder}/MT-{name}.txt" for sensor, name in NAMES.items()]


# Xsens exports


@pytest.mark.parametrize("clock", [[], ["clock=same"]], ids=["", "same"])
def test_the_counter_of_exports_is_their_common_clock(tmp_path, clock):
    recording, parts = late_exports(tmp_path)
    found = understand([*parts, *clock])
    assert len(found.recording) == len(recording) - 50
    for sensor, imu in found.recording.sensors.items():
        expected = recording.sensor(sensor).acc_mps2[50:]
        np.testing.assert_allclose(imu.acc_mps2, expected, atol=1e-9)
    (said,) = [w for w in found.warnings if "packet counter" in w]
    assert "joined on the packet counter that the files share" in said
    assert said.endswith("clock=own if they are of different receivers")


def test_the_counter_also_holds_beside_a_file_of_another_maker(tmp_path):
    recording, parts = late_exports(tmp_path)
    one_of(recording, "frame").to_frame().to_csv(tmp_path / "frame.csv", index=False)
    given = understand([f"frame={tmp_path}/frame.csv", *parts[1:], "clock=same"])
    found = given.recording
    count = len(found)
    for sensor, imu in found.sensors.items():
        expected = recording.sensor(sensor).acc_mps2[50:][:count]
        np.testing.assert_allclose(imu.acc_mps2, expected, atol=1e-6)
    assert any("from the first packet that any of them has" in said for said in given.warnings)


def test_exports_that_share_no_counter_begin_together_only_if_that_is_said(tmp_path):
    recording = made(CHAIR[:2])
    dialects.xsens_mt(recording, tmp_path)
    left = tmp_path / "MT-LeftWheel.txt"
    lines = left.read_text().rstrip().split("\n")
    at = next(k for k, line in enumerate(lines) if line.startswith("PacketCounter"))
    moved = [f"{k}\t" + line.split("\t", 1)[1] for k, line in enumerate(lines[at + 1 :], 20_000)]
    left.write_text("\n".join([*lines[: at + 1], *moved, ""]))
    parts = [f"frame={tmp_path}/MT-Frame.txt", f"left_wheel={left}"]
    with pytest.raises(InputError, match="clock=same"):
        quietly(parts)
    found = understand([*parts, "clock=same"])
    assert_same(found.recording, recording)
    told = [w for w in found.warnings if "from its own first packet" in w]
    assert len(told) == 2 and "MT-LeftWheel.txt" in told[1]


def export_of(counter):
    counter = np.asarray(counter, float)
    values = np.zeros((len(counter), 3))
    return xsens_mt.Export(counter, None, values, values, 100.0, "made", ())


@pytest.mark.parametrize(
    ("one", "other", "shared"),
    [
        (np.arange(1000), np.arange(1000), True),
        (np.arange(65_400, 66_400), np.arange(20, 700), True),  # it starts after the counter's end
        (np.arange(300, 600), np.arange(0, 3000), False),  # a tenth of the longer one
        (np.arange(0, 50_000), np.arange(21_000, 71_000), False),
        (np.arange(0, 70_000), np.arange(30_000, 100_000), False),
        (np.arange(0, 200_000), np.arange(20_000, 220_000), False),
        (np.arange(0, 200_000), np.arange(900, 199_000), True),
    ],
)
def test_exports_of_one_receiver_share_most_of_their_packets(one, other, shared):
    for pair in ((one, other), (other, one)):
        exports = dict(zip(("frame", "left_wheel"), map(export_of, pair), strict=True))
        assert xsens_mt.share_packets(exports) == shared


def test_trials_that_were_mixed_up_are_not_of_one_receiver():
    mixed = [f"frame={XSENS}/Static-Frame.txt", f"left_wheel={XSENS}/Trial-LeftWheel.txt"]
    with pytest.raises(InputError, match=r"frame: a recording of 2\.98 s, expected 10 to"):
        quietly(mixed)


def test_a_map_holds_for_exports_as_well(tmp_path):
    _, parts = late_exports(tmp_path)
    (tmp_path / "map.toml").write_text(
        "[clock]\nrate_hz = 100\nfirst_row = 3\n[sensors.frame]\n"
        'acc = ["Acc_X", "Acc_Y", "-Acc_Z"]\nacc_unit = "m/s2"\n'
    )
    found = understand([*parts[:2], "clock=same"], map_path=tmp_path / "map.toml")
    assert found.format == "mapped CSV"
    assert np.median(found.recording.sensor("frame").acc_mps2[:, 2]) < -9


# Clocks


def test_stamps_that_are_to_be_believed_must_share_time(tmp_path):
    recording = made(("lever", "body"))
    files = apart(recording, tmp_path, {"body": 1000.0})
    with pytest.raises(InputError, match=r"share no time \(lever 0\.000.*leave out clock=same"):
        quietly([*files, "clock=same"])
    dialects.ngimu(recording, tmp_path / "session")
    late = next((tmp_path / "session").glob("*body*")) / "sensors.csv"
    head, *rows = late.read_text().rstrip().split("\n")
    moved = [f"{100 + k / 100:.2f},{row.split(',', 1)[1]}" for k, row in enumerate(rows)]
    late.write_text("\n".join([head, *moved, ""]))
    with pytest.raises(InputError, match=r"share no time.*leave out clock=same"):
        quietly([tmp_path / "session", "clock=same"])


@pytest.mark.parametrize("clock", ["same", "own"])
def test_a_clock_that_is_said_of_one_sensor_has_no_effect(tmp_path, clock):
    (file,) = apart(made(), tmp_path)
    (said,) = understand([file, f"clock={clock}"]).warnings
    assert f"clock={clock} has no effect: there is one sensor only" in said
    assert understand([file]).warnings == understand(file).warnings == ()


def test_gaps_of_joined_files_are_told(tmp_path):
    court = read_recording(recordings_folder() / "wheelchair_court" / "court.csv.gz")
    files, _ = write_apart(court.trim(8, 28), tmp_path)
    lines = files["left_wheel"].read_text().split("\n")
    files["left_wheel"].write_text("\n".join([*lines[:1000], *lines[1004:]]))
    with pytest.raises(InputError, match=r"gap of 0\.05 s"):
        quietly(files["left_wheel"])
    (said,) = [w for w in understand(list(files.values())).warnings if "bridged" in w]
    assert "left_wheel: 1 gap(s) bridged by straight lines, the longest of 0.05 s" in said


def test_both_sides_of_what_is_not_clear_are_named(tmp_path):
    """Of three clocks the frame's is of another drive; the refusal names it, and the wheels."""
    from mobility_imu.readers import lags

    said = lags._unclear("a.csv", ["left_wheel"], ["frame", "right_wheel"])
    assert "the clocks of left_wheel and of frame, right_wheel are their own" in said
    court = read_recording(recordings_folder() / "wheelchair_court" / "court.csv.gz")
    files, _ = write_apart(court, tmp_path)
    walk = read_recording(recordings_folder() / "walker_corridor" / "walk.csv.gz")
    walk.to_frame().to_csv(files["frame"], index=False)
    with pytest.raises(InputError, match="movement does not show clearly") as error:
        quietly(list(files.values()))
    assert all(name in str(error.value) for name in files)


# Names


def test_what_a_file_calls_its_only_sensor_comes_before_the_files_name(tmp_path):
    recording = made(("left_hand", "right_hand"))
    files = apart(recording, tmp_path)
    assert list(quietly([*files, "clock=same"]).sensors) == ["left_hand", "right_hand"]
    assert list(quietly([f"lever={files[0]}", files[1], "clock=same"]).sensors) == [
        "lever",
        "right_hand",
    ]


def test_two_sensors_of_one_name_are_told_apart(tmp_path):
    recording = made(("lever", "body"))
    files = apart(recording, tmp_path, sensors={"lever": "frame", "body": "frame"})
    with pytest.raises(InputError) as error:
        quietly([*files, "clock=same"])
    said = str(error.value)
    assert "two sensors are called frame" in said
    assert all(f"in {file}" in said for file in files)
    assert said.endswith("give each its name, as in frame=FILE,left_wheel=FILE")
    with pytest.raises(InputError, match="as in lever=FILE,body=FILE"):
        quietly([*files, "clock=same"], expected=("lever", "body"))


def test_a_label_that_is_not_there_is_told_with_those_that_are(tmp_path):
    path = dialects.lpms(made(("lever", "body")), tmp_path)
    with pytest.raises(InputError, match=r"no sensor '7' for 'body' \(it has: 1, 2\).*body=.*#1"):
        quietly([f"body={path}#7"])
    with pytest.raises(InputError, match=r"2 sensors for 'body' \(1, 2\).*body=.*#1"):
        quietly([f"body={path}"])


def test_labels_are_what_the_files_say(tmp_path):
    recording = made(("lever", "body"))
    path = dialects.lpms(recording, tmp_path)
    labels = understand([f"lever={path}#1", f"body={path}#2", "clock=same"]).labels
    assert labels == {"lever": "1", "body": "2"}
    files = apart(recording, tmp_path)
    given = [f"left_wheel={files[0]}", f"right_wheel={files[1]}", "clock=same"]
    assert understand(given).labels == {"left_wheel": "lever", "right_wheel": "body"}
    assert understand(XSENS / "Trial").labels["left_wheel"] == "Trial-LeftWheel"


def test_a_list_of_one_is_the_file(tmp_path):
    (file,) = apart(made(), tmp_path)
    for one in ([file], (str(file),), [f"frame={file}"]):
        assert_same(quietly(one), made())
        assert recording_files(one) == [file]
    with pytest.raises(InputError, match="no file"):
        read_recording([])


def test_files_without_their_sensors_names_are_to_be_given_with_them(tmp_path):
    files = apart(made(("lever", "body")), tmp_path)
    with pytest.raises(InputError, match=r"no such file.*lever=.*lever\.csv,body=.*body\.csv"):
        quietly(",".join(map(str, files)), expected=("lever", "body"))


def test_an_archive_may_be_one_of_several_files(tmp_path):
    recording = made(("lever", "body"))
    (lever, _) = apart(recording, tmp_path)
    (tmp_path / "phone").mkdir()
    folder = dialects.ngimu(one_of(recording, "body"), tmp_path / "phone")
    with zipfile.ZipFile(tmp_path / "phone.zip", "w") as archive:
        for file in folder.rglob("*.csv"):
            archive.write(file, file.relative_to(folder))
    assert_same(quietly([f"lever={lever}", f"body={tmp_path}/phone.zip", "clock=same"]), recording)


def test_nothing_is_said_of_a_recording_in_order(tmp_path):
    recording = made(("lever", "body"))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        files = apart(recording, tmp_path, {"lever": 100.0, "body": 100.0})
        read_recording([*files, "clock=same"])
