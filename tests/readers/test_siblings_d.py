"""Sessions, phones and neighbours: columns that are there twice, zones, short rows, pipes."""

import os
import signal
import zipfile

import dialects
import numpy as np
import pandas as pd
import pytest
from test_dialects import assert_same, made, quietly
from test_names_of_files import CHAIR, exports

from mobility_imu.errors import InputError
from mobility_imu.readers.androsensor import read_androsensor
from mobility_imu.readers.prefixes import exports_in
from mobility_imu.readers.recordings import recording_files, understand
from mobility_imu.readers.streams import Asked

# Archives


def archive_of(path, name="a.csv"):
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr(name, "x\n1\n")
    return path.read_bytes()


def test_a_name_in_an_archive_that_is_not_in_the_encoding_it_states(tmp_path):
    path = tmp_path / "s.zip"
    path.write_bytes(archive_of(path, "é.csv").replace("é".encode(), b"\xe9a"))
    with pytest.raises(InputError, match=r"s\.zip: cannot be opened .*not in UTF-8.*unpack it"):
        understand(path)


def test_a_damaged_archive_is_refused(tmp_path):
    rng, whole = np.random.default_rng(7), archive_of(tmp_path / "s.zip")
    for _ in range(200):
        raw = bytearray(whole)
        for place in rng.integers(0, len(raw), 3):
            raw[place] = rng.integers(256)
        (tmp_path / "s.zip").write_bytes(raw)
        with pytest.raises(InputError):
            understand(tmp_path / "s.zip")


# Columns that are there twice


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("Time since start in ms", "column Time since start in ms is there twice"),
        ("Time since start in ms ", "column Time since start in ms is there twice"),
        ("YYYY-MO-DD HH-MI-SS_SSS", "column YYYY-MO-DD HH-MI-SS_SSS is there twice"),
        ("ACCELEROMETER X (m/s²)", "column ACCELEROMETER X is there twice"),
        ("ACCELEROMETER X (m/s²) ", "column ACCELEROMETER X is there twice"),
        ("ACCELEROMETER X (m/s^2)", "column ACCELEROMETER X is there twice"),
        ("GYROSCOPE Z (rad/s)", "column GYROSCOPE Z is there twice"),
    ],
)
@pytest.mark.parametrize("separator", [",", ";"])
def test_columns_of_androsensor_that_are_there_twice(tmp_path, name, says, separator):
    path = dialects.androsensor(made(), tmp_path)
    head, *rows = path.read_text().rstrip().replace(",", separator).split("\n")
    lines = [f"{head}{separator}{name}", *(f"{row}{separator}1" for row in rows)]
    path.write_text("\n".join(lines) + "\n")
    with pytest.raises(InputError, match=says):
        quietly(path)


def test_other_columns_of_androsensor_may_be_there_twice(tmp_path):
    recording = made()
    path = dialects.androsensor(recording, tmp_path)
    head, *rows = path.read_text().rstrip().split("\n")
    path.write_text("\n".join([f"{head},LIGHT,LIGHT", *(f"{row},1,2" for row in rows)]) + "\n")
    assert len(quietly(path)) == len(recording)


@pytest.mark.parametrize(
    ("file", "name", "says"),
    [
        ("Gyroscope", "x", r"Gyroscope\.csv: column x is there twice"),
        ("Gyroscope", "seconds_elapsed", r"Gyroscope\.csv: column seconds_elapsed .* twice"),
        ("Metadata", "platform", r"Metadata\.csv: column platform is there twice"),
    ],
)
def test_columns_of_sensor_logger_that_are_there_twice(tmp_path, file, name, says):
    path = dialects.sensor_logger(made(), tmp_path) / f"{file}.csv"
    head, *rows = path.read_text().split("\n")
    path.write_text("\n".join([f"{head},{name}", *(f"{row},ios" for row in rows)]))
    if file != "Metadata":
        path.write_text(path.read_text().replace("ios", "1"))
    with pytest.raises(InputError, match=says):
        quietly(tmp_path)


@pytest.mark.parametrize("name", ["time", "gFx", "wz"])
def test_columns_of_physics_toolbox_that_are_there_twice(tmp_path, name):
    path = dialects.physics_toolbox(made(), tmp_path)
    head, *rows = path.read_text().strip().split("\n")
    path.write_text("\n".join([f"{head}{name}", *(f"{row}1" for row in rows)]) + "\n")
    with pytest.raises(InputError, match=f"column {name.lower()} .* twice"):
        quietly(path)


def test_sensors_whose_names_differ_in_case_only(tmp_path):
    path = dialects.canonical(made(), tmp_path)
    path.write_text(path.read_text().replace("frame_acc_y", "Frame_acc_y", 1))
    says = r"own\.csv: the sensors frame and Frame differ only in upper and lower case; .* rename"
    with pytest.raises(InputError, match=says):
        understand(path)
    plain = dialects.canonical(made(), tmp_path)
    with pytest.raises(InputError, match="body and Body differ only in upper and lower case"):
        understand(f"body={plain},Body={plain},clock=same")


# Stamps with a distance to UTC


def stamped(tmp_path, stamp_of):
    """A table of AndroSensor whose rows have such stamps."""
    path = dialects.androsensor(made(), tmp_path)
    column = "YYYY-MO-DD HH-MI-SS_SSS"
    table = pd.read_csv(path)
    begin = pd.Timestamp("2024-03-31 00:59:59", tz="UTC")
    wall = begin + pd.to_timedelta(table["Time since start in ms "], unit="ms").dt.round("ms")
    table[column] = [stamp_of(t) for t in wall]
    return read_androsensor(table.to_csv(index=False), "a.csv", Asked())[0].time_s


def local(mark):
    def stamp_of(t):
        there = t.tz_convert("Europe/Berlin")
        zone = f"{there:%z}"
        return f"{there:%Y-%m-%d %H:%M:%S}{mark}{there.microsecond // 1000:03d}{zone}"

    return stamp_of


@pytest.mark.parametrize("mark", [".", ":"])
def test_a_recording_of_androsensor_in_which_summer_time_begins(tmp_path, mark):
    time_s = stamped(tmp_path, local(mark))
    assert time_s[0] == pytest.approx(2 * 3600 - 1, abs=2e-3)  # 01:59:59 where the phone was
    np.testing.assert_allclose(time_s - time_s[0], made().time_s, atol=2e-3)


@pytest.mark.parametrize("first", [0, 1])
def test_stamps_of_which_some_have_no_zone_are_refused(tmp_path, first):
    stamps = [local("."), lambda t: local(".")(t)[:-5]]
    count = iter(range(10_000))
    with pytest.raises(InputError, match="is no date and time"):
        stamped(tmp_path, lambda t: stamps[(next(count) >= 50) ^ first](t))


# Starts and pauses of phyphox


EVENTS = '"experiment time","event","system time"\n'


@pytest.mark.parametrize("row", ["4", "4.5"])
def test_a_row_of_events_in_another_order(tmp_path, row):
    recording = made()
    folder = dialects.phyphox(recording, tmp_path)
    (folder / "meta" / "time.csv").write_text(f'{EVENTS}0,"START",1700000000\n')
    assert_same(quietly(folder), recording)
    (folder / "meta" / "time.csv").write_text(f'{EVENTS}0,"START",1700000000\n\n{row}\n')
    says = r"meta/time\.csv: line 4 has 1 of 3 cells; was the file cut short"
    with pytest.raises(InputError, match=says):
        quietly(folder)


def test_events_with_an_index(tmp_path):
    folder = dialects.phyphox(made(count=2000), tmp_path)
    (folder / "meta" / "time.csv").write_text(
        ',"event","experiment time","system time"\n0,"START",0,1700000000\n'
        '1,"PAUSE",8,1700000008\n2,"START",8,1700000038\n'
    )
    with pytest.raises(InputError, match=r"pause of 30 s \(meta/time\.csv\)"):
        quietly(folder)


def test_a_column_of_events_that_is_there_twice(tmp_path):
    folder = dialects.phyphox(made(), tmp_path)
    path = folder / "meta" / "time.csv"
    path.write_text('"event","experiment time","event"\n"START",0,"PAUSE"\n')
    with pytest.raises(InputError, match=r"meta/time\.csv: column event .* twice"):
        quietly(folder)


# Neighbours that nobody named


@pytest.fixture
def in_time():
    """Ends a test that waits for a pipe."""

    def end(number, frame):
        raise TimeoutError("waits for a pipe")

    before = signal.signal(signal.SIGALRM, end)
    signal.alarm(60)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


@pytest.mark.usefixtures("in_time")
def test_pipes_folders_and_binary_files_beside_exports(tmp_path):
    exports(tmp_path, ("t-Frame", "t-LeftWheel", "t-RightWheel"))
    os.mkfifo(tmp_path / "t-notes.txt")
    os.mkfifo(tmp_path / "u-Left.txt")
    (tmp_path / "t-link.txt").symlink_to(tmp_path / "t-notes.txt")
    (tmp_path / "t-old.txt").mkdir()
    (tmp_path / "t-photo.txt").write_bytes(b"\x89\0\xff\n")
    (tmp_path / "t-empty.txt").write_text("")
    (tmp_path / "u-Right.txt").write_bytes(b"\x89\0\xff\n")
    assert set(quietly(tmp_path / "t").sensors) == set(CHAIR)
    assert len(recording_files(tmp_path / "t")) == len(CHAIR)
    assert exports_in(tmp_path).endswith(f"as {tmp_path}/t")
    with pytest.raises(InputError, match=f"as {tmp_path}/t"):
        understand(tmp_path)


@pytest.mark.usefixtures("in_time")
def test_pipes_in_the_folder_of_a_session(tmp_path):
    recording = made()
    dialects.sensor_logger(recording, tmp_path)
    os.mkfifo(tmp_path / "Magnetometer.csv")
    (tmp_path / "wheel").mkdir()
    os.mkfifo(tmp_path / "wheel" / "sensors.csv")
    assert len(quietly(tmp_path)) == len(recording)
