"""``clock=same`` for files whose times each count from their own start."""

import re

import dialects
import numpy as np
import pytest
from test_dialects import RATE_HZ, assert_same, made, quietly

from mobility_imu.errors import InputError
from mobility_imu.readers.actigraph import read_actigraph
from mobility_imu.readers.recordings import understand
from mobility_imu.readers.sensor_logger import read_sensor_logger
from mobility_imu.readers.streams import Asked
from mobility_imu.recording import Recording

LATE_S = 2.0


def of(recording, name, begin=0):
    """One sensor from some sample on, its times from 0."""
    imu = recording.sensor(name)
    rows = slice(begin, None)
    return Recording(
        recording.time_s[: len(recording) - begin],
        {name: type(imu)(imu.acc_mps2[rows], imu.gyr_radps[rows])},
        source=name,
    )


def changed(file, old, new):
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new))


def phones(recording, folder):
    for k, name in enumerate(recording.sensors):
        (folder / name).mkdir()
        phone = dialects.sensor_logger(of(recording, name, 200 * k), folder / name)
        for file in phone.glob("*.csv") if k else ():
            lines = file.read_text().split("\n")
            rows = [line.split(",") for line in lines[1:]]
            if lines[0].startswith("time,"):
                rows = [[str(int(row[0]) + int(LATE_S * 1e9)), *row[1:]] for row in rows]
                file.write_text("\n".join([lines[0], *map(",".join, rows)]))
        yield f"{name}={phone}"


def actigraphs(recording, folder):
    for k, name in enumerate(recording.sensors):
        (folder / name).mkdir()
        file = dialects.actigraph(of(recording, name, 200 * k), folder / name)
        if k:
            head, *rows = re.split(r"^(?=2019-)", file.read_text(), flags=re.MULTILINE)
            cells = [row.partition(",") for row in rows]
            later = [
                np.datetime64(stamp, "ns") + np.timedelta64(int(LATE_S * 1e9))
                for stamp, *_ in cells
            ]
            rows = [f"{stamp},{rest}" for stamp, (_, _, rest) in zip(later, cells, strict=True)]
            file.write_text(head + "".join(rows))
        yield f"{name}={file}"


def experiment(recording, folder, late_s=0.0):
    phone = dialects.phyphox(recording, folder)
    (phone / "meta" / "time.csv").write_text(
        f'"event","experiment time","system time"\n"START",0,{1715100946.5 + late_s}\n'
    )
    return phone


def experiments(recording, folder):
    for k, name in enumerate(recording.sensors):
        (folder / name).mkdir()
        yield f"{name}={experiment(of(recording, name, 200 * k), folder / name, LATE_S * k)}"


@pytest.mark.parametrize("write", [phones, actigraphs, experiments])
def test_times_of_day_in_the_files_say_which_began_later(tmp_path, write):
    recording = made(("lever", "body"), count=1000)
    found = understand([*write(recording, tmp_path), "clock=same"])
    assert any("lever +0.000 s, body +2.000 s" in w for w in found.warnings)
    lever, body = (found.recording.sensor(n).acc_mps2 for n in ("lever", "body"))
    count = len(lever)
    assert count == pytest.approx(800, abs=2)
    np.testing.assert_allclose(lever, recording.sensor("lever").acc_mps2[200:][:count], atol=2e-3)
    np.testing.assert_allclose(body, recording.sensor("body").acc_mps2[200:][:count], atol=2e-3)


@pytest.mark.parametrize("write", [phones, actigraphs, experiments])
def test_files_that_a_trigger_began_whose_clocks_on_the_wall_differ(tmp_path, write):
    """The first samples are of one moment, whatever the time of day in the files."""
    recording = made(("lever", "body"), count=1000)
    parts = list(write(recording, tmp_path))
    found = understand([*parts, "clock=start"])
    (said,) = [w for w in found.warnings if "one moment" in w]
    assert (
        said == "clock=start: the first samples of the files of lever, body are taken as one moment"
    )
    lever, body = (found.recording.sensor(n).acc_mps2 for n in ("lever", "body"))
    count = len(lever)
    assert count == pytest.approx(800, abs=2)
    np.testing.assert_allclose(lever, recording.sensor("lever").acc_mps2[:count], atol=2e-3)
    np.testing.assert_allclose(body, recording.sensor("body").acc_mps2[200:][:count], atol=2e-3)
    assert found.lags == {}


def test_stamps_of_any_kind_begin_at_one_moment(tmp_path):
    """Seconds since switching on, packets of one receiver; sensors of one file stay together."""
    recording = made(("frame", "left_wheel"))
    frame = dialects.ximu3(of(recording, "frame"), tmp_path)
    both = dialects.lpms(recording, tmp_path)
    parts = [f"frame={frame}", f"left_wheel={both}#2", "clock=start"]
    assert_same(quietly(parts), recording, tolerance=1e-5)
    dialects.xsens_mt(recording, tmp_path)
    left = tmp_path / "MT-LeftWheel.txt"
    lines = left.read_text().split("\n")
    left.write_text("\n".join([*lines[:3], *lines[53:]]))
    found = quietly([tmp_path / "MT-Frame.txt", left, "clock=start"], sampling_rate_hz=RATE_HZ)
    assert len(found) == pytest.approx(len(recording) - 50, abs=1)
    for name, begin in (("frame", 0), ("left_wheel", 50)):
        expected = recording.sensor(name).acc_mps2[begin:][: len(found)]
        np.testing.assert_allclose(found.sensor(name).acc_mps2, expected, atol=1e-6)
    lines = both.read_text().rstrip().split("\n")
    moved = [
        line for line in lines[1:] if line.split(",")[0] == "1" or float(line.split(",")[1]) >= 1
    ]
    both.write_text("\n".join([lines[0], *moved, ""]))
    names = [f"frame={both}#1", f"left_wheel={both}#2", "clock=start"]
    found = understand(names)
    assert len(found.recording) == pytest.approx(len(recording) - 100, abs=1)
    assert not any("one moment" in text for text in found.warnings)
    (said,) = [text for text in found.warnings if "has no effect" in text]
    assert said.endswith("one file, session or beginning of names has frame, left_wheel")
    for names in ([tmp_path / "MT", "clock=start"], [both, "clock=start"]):
        warned = understand(names, sampling_rate_hz=RATE_HZ).warnings
        assert sum("clock=start has no effect" in text for text in warned) == 1


def test_files_of_different_hours_share_no_time(tmp_path):
    parts = list(actigraphs(made(("lever", "body"), count=1000), tmp_path))
    changed(tmp_path / "body" / "actigraph.csv", "T08:58:", "T09:30:")
    moved = r"share no time \(.*\); clock=same: begins by .*: lever \+0\.000 s, body \+1922\.000 s;"
    with pytest.raises(InputError, match=moved):
        quietly([*parts, "clock=same"])


@pytest.mark.parametrize("write", [dialects.sensor_logger, experiment])
def test_local_time_is_not_taken_for_utc(tmp_path, write):
    """ActiGraph writes the time on the wall, phones count from 1970 in UTC: hours apart."""
    recording = made(("lever", "body"))
    (tmp_path / "body").mkdir()
    body = write(of(recording, "body"), tmp_path / "body")
    lever = dialects.actigraph(of(recording, "lever"), tmp_path)
    found = understand([f"lever={lever}", f"body={body}", "clock=same"])
    (said,) = [w for w in found.warnings if w.startswith("clock=same: ")]
    assert "the time of day in UTC (body) and local time (lever), so it is not used" in said
    assert said.endswith("count from their file's start; did the files begin together?")
    assert len(found.recording) == len(recording)


def test_the_head_tells_the_start_where_no_row_does(tmp_path):
    file = dialects.actigraph(made(), tmp_path)
    (stream,) = read_actigraph(file.read_text(), "a.csv", Asked())
    assert stream.epoch_s == 1550134680  # 2019-02-14 08:58:00
    head, rest = file.read_text().split("Timestamp,")
    table = "\n".join(row.partition(",")[2] for row in rest.split("\n"))
    table = "Accelerometer X,Accelerometer Y,Accelerometer Z\n" + "\n".join(
        ",".join(row.split(",")[:3]) for row in table.split("\n")[1:] if row
    )
    for order, date, epoch_s in (
        ("M/d/yyyy", "2/14/2019", 1550134680),
        ("dd.MM.yyyy", "14.02.2019", 1550134680),
        ("yyyy-MM-dd", "2019-02-14", 1550134680),
        ("M/d/yyyy", "14/2/2019", None),
        ("unknown", "2/14/2019", None),
    ):
        text = head.replace("M/d/yyyy", order).replace("2/14/2019", date) + table
        (stream,) = read_actigraph(text, "a.csv", Asked())
        assert stream.epoch_s == epoch_s


def test_a_time_of_day_that_a_spreadsheet_rounded_is_none(tmp_path):
    folder = dialects.sensor_logger(made(), tmp_path)
    files = {file.stem: file.read_text() for file in folder.glob("*.csv") if file.read_text()}
    (stream,) = read_sensor_logger(files, "phone", Asked())
    assert stream.epoch_s == pytest.approx(1_713_800_421, abs=1e-3)
    rows = files["TotalAcceleration"].split("\n")
    rounded = ["1.7138E+18," + row.partition(",")[2] for row in rows[1:]]
    files["TotalAcceleration"] = "\n".join([rows[0], *rounded])
    assert read_sensor_logger(files, "phone", Asked())[0].epoch_s is None
    files["TotalAcceleration"] = files["TotalAcceleration"].replace("1.7138E+18", "x")
    assert read_sensor_logger(files, "phone", Asked())[0].epoch_s is None


def test_files_from_their_own_start_are_named_where_not_all_tell_the_time_of_day(tmp_path):
    recording = made(("lever", "body"))
    lever = dialects.canonical(of(recording, "lever"), tmp_path)
    (tmp_path / "body").mkdir()
    body = dialects.sensor_logger(of(recording, "body"), tmp_path / "body")
    found = understand([f"lever={lever}", f"body={body}", "clock=same"])
    (said,) = [w for w in found.warnings if "began" in w or "begin" in w]
    assert said.startswith("clock=same: times of lever, body count from their file's start; did")


def test_two_sensors_of_one_file_began_together(tmp_path):
    path = dialects.lpms(made(("lever", "body")), tmp_path)
    found = understand([f"lever={path}#1", f"body={path}#2", "clock=same"])
    assert not any("begin" in w for w in found.warnings)
    assert RATE_HZ == pytest.approx(found.recording.sampling_rate_hz)
