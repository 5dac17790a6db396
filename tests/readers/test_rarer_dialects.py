"""Dresses in which public files of a vendor's format stand, beside the usual one."""

import csv
import io
import json
import re

import dialects
import numpy as np
import pytest
from test_dialects import assert_same, made, quietly

from mobility_imu.errors import InputError
from mobility_imu.readers.recordings import understand


class TestXsensDot:
    """Logs of the PC software: the unit of Gyr depends on the mode of measurement."""

    def log(self, folder, gyr_scale, *, turns=1.0, end=""):
        """A log with the turns during each sample, of which dq is half."""
        recording = made()
        imu = recording.sensor("frame")
        names = ["SampleTimeFine", *(f"dq_{a}" for a in "WXYZ")]
        names += [f"{q}_{a}" for q in ("Acc", "Gyr") for a in "XYZ"]
        lines = ["DeviceTag: a,FirmwareVersion: 3.0.0,OutputRate: 100", ",".join(names)]
        for k, (acc, gyr) in enumerate(zip(imu.acc_mps2, imu.gyr_radps, strict=True)):
            half = np.round(turns * gyr * 0.01 / 2, 4)
            row = [700 + 100 * k, 1.0, *half, *acc, *(gyr * gyr_scale)]
            lines.append(",".join(f"{value:.10g}" for value in row))
        (folder / "log.csv").write_text("\n".join(lines) + "\n" + end)
        return folder / "log.csv", recording

    @pytest.mark.parametrize("scale", [1.0, 180 / np.pi], ids=["rad/s", "deg/s"])
    def test_the_turns_tell_the_unit_of_the_rates(self, tmp_path, scale):
        path, recording = self.log(tmp_path, scale)
        found = understand(path, expected=("frame",))
        assert_same(found.recording, recording)
        assert ("rad/s" in " ".join(found.warnings)) == (scale == 1.0)

    @pytest.mark.parametrize(
        ("scale", "turns", "says"),
        [(7.0, 1.0, r"neither in rad/s nor in deg/s .*--map"), (1.0, 0.0, "dq are zero")],
    )
    def test_rates_that_the_turns_do_not_explain(self, tmp_path, scale, turns, says):
        path, _ = self.log(tmp_path, scale, turns=turns)
        with pytest.raises(InputError, match=says):
            quietly(path)

    def test_stamps_alone_at_the_end_are_left_out(self, tmp_path):
        path, recording = self.log(tmp_path, 1.0, end="40700\n40800\n")
        found = understand(path, expected=("frame",))
        assert_same(found.recording, recording)
        assert len(found.recording) == len(recording)
        assert found.warnings[0].endswith("2 row(s) without readings at the end left out")

    def test_a_last_line_that_may_be_cut_is_told(self, tmp_path):
        path, _ = self.log(tmp_path, 1.0, end="40700\n408")
        with pytest.raises(InputError, match="line 403 has 1 of 11 cells"):
            quietly(path)


class TestXsensWithoutAHead:
    """A table of a DOT has MT Manager's names, but deg/s and another clock."""

    def headless(self, recording, folder, separator, column):
        path = dialects.xsens_dot(recording, folder)
        names, *rows = path.read_text().partition("PacketCounter")[2].splitlines()
        lines = [f"PacketCounter{names},{column}"] + [f"{row},0.5" for row in rows]
        path.write_text("\n".join(lines).replace(",", separator) + "\n")
        return path

    @pytest.mark.parametrize("separator", [",", ";", "\t"])
    @pytest.mark.parametrize("column", ["Euler_X", "Quat_W"])
    def test_other_columns_tell_a_dot(self, tmp_path, separator, column):
        recording = made()
        path = self.headless(recording, tmp_path, separator, column)
        found = understand(path, expected=("frame",))
        assert found.format == "Xsens DOT"
        assert_same(found.recording, recording)

    @pytest.mark.parametrize("separator", [",", ";", "\t"])
    def test_without_them_the_unit_is_not_known(self, tmp_path, separator):
        path = self.headless(made(), tmp_path, separator, "Mag_X")
        with pytest.raises(InputError, match="can be Xsens MT Manager, Xsens DOT; convert it by a"):
            quietly(path)

    @pytest.mark.parametrize("separator", [",", ";", "\t"])
    def test_other_columns_tell_mt_manager(self, tmp_path, separator):
        recording = made()
        path = dialects.xsens_mt(recording, tmp_path, separator, fine=True)
        path = path.with_name("MT-Frame.txt")
        names, *rows = path.read_text().splitlines()[2:]
        lines = [separator.join([names, "Roll"])] + [separator.join([row, "0.5"]) for row in rows]
        path.write_text("\n".join(lines) + "\n")
        found = understand(path, expected=("frame",))
        assert found.format == "Xsens MT Manager"
        assert_same(found.recording, recording)

    @pytest.mark.parametrize("head", [True, False])
    def test_a_unit_that_nothing_states_is_told(self, tmp_path, head):
        path = dialects.xsens_mt(made(), tmp_path).with_name("MT-Frame.txt")
        if not head:
            path.write_text(path.read_text().partition("Hz\n")[2])
        found = understand(path, sampling_rate_hz=100)
        told = "MT-Frame.txt: has no head of MT Manager; its Gyr is taken in rad/s"
        assert any(said.endswith(told) for said in found.warnings) != head


def test_an_empty_clock_of_mt_manager_is_none(tmp_path):
    """Some versions write 0 for SampleTimeFine in every row."""
    recording = made()
    path = dialects.xsens_mt(recording, tmp_path, head="", fine=True).with_name("MT-Frame.txt")
    lines = path.read_text().splitlines()
    rows = [line.split("\t") for line in lines[2:]]
    zeros = ["\t".join([row[0], "0", *row[2:]]) for row in rows]
    path.write_text("\n".join([*lines[:2], *zeros]) + "\n")
    with pytest.raises(InputError, match="states no sampling rate; give it with"):
        quietly(path)
    assert_same(quietly(path, sampling_rate_hz=100, expected=("frame",)), recording)


@pytest.mark.parametrize("above", ["sep=,\n", "sep=,,,,,\n", ",,,,,,,\n", '"sep=,"\n\n'])
def test_androsensor_below_a_line_of_its_separator(tmp_path, above):
    """As the app writes it, and as a spreadsheet fills it up."""
    recording = made()
    path = dialects.androsensor(recording, tmp_path)
    text = path.read_text()
    path.write_text(above + text)
    assert_same(quietly(path, expected=("frame",)), recording)
    path.write_text(above + text.replace("2019-04-29 17:21:51:650", "noon"))
    with pytest.raises(InputError, match=rf"line {3 + above.count(chr(10))}: 'noon' is no date"):
        quietly(path)


def test_androsensor_of_a_phone_without_a_gyroscope(tmp_path):
    path = dialects.androsensor(made(), tmp_path)
    lines = [line.split(",") for line in path.read_text().splitlines()]
    gyr = {k for k, name in enumerate(lines[0]) if name.startswith("GYRO")}
    path.write_text("\n".join(",".join(c for k, c in enumerate(row) if k not in gyr)
                              for row in lines))  # fmt: skip
    found = quietly(path, expected=("frame",))
    assert found.sensor("frame").gyr_radps is None


@pytest.mark.parametrize(
    ("new", "scale"), [("(m/s^2)", 1.0), ("(m/s2)", 1.0), ("(g)", 1 / 9.80665), ("(m/sÂ²)", 1.0)]
)
def test_androsensor_with_its_unit_in_other_letters(tmp_path, new, scale):
    """A program that takes UTF-8 for another encoding makes Â² of ²."""
    recording = made()
    path = dialects.androsensor(recording, tmp_path)
    names, *rows = path.read_text().splitlines()
    cells = [row.split(",") for row in rows]
    lines = [",".join([*(repr(scale * float(c)) for c in row[:3]), *row[3:]]) for row in cells]
    path.write_text("\n".join([names.replace("(m/s²)", new), *lines]) + "\n")
    assert_same(quietly(path, expected=("frame",)), recording)
    path.write_text(path.read_text().replace(new, "(ft/s²)"))
    with pytest.raises(InputError, match="acceleration in 'ft/s²' is not known"):
        quietly(path)


class TestShimmer:
    @pytest.mark.parametrize("name", ["S_LeftWheel", "RWrist", "imu", "Shimmer_40AC_old"])
    def test_a_sensor_that_the_user_renamed(self, tmp_path, name):
        recording = made()
        path = dialects.shimmer(recording, tmp_path)
        path.write_text(path.read_text().replace("Shimmer_40AC", name))
        found = understand(path, expected=("frame",))
        assert_same(found.recording, recording)
        assert found.labels == {"frame": name.removeprefix("Shimmer_")}

    def test_two_sensors_of_one_file(self, tmp_path):
        path = dialects.shimmer(made(), tmp_path)
        rows = [line.split(";")[:-1] for line in path.read_text().splitlines()[1:]]
        second = [[c.replace("Shimmer_40AC", "LWrist") for c in row] for row in rows]
        lines = [";".join([*a, *b]) for a, b in zip(rows, second, strict=True)]
        path.write_text("\n".join(lines) + "\n")
        assert understand(f"frame={path}#LWrist").recording.sensors.keys() == {"frame"}
        with pytest.raises(InputError, match=r"2 sensors for 'frame' \(40AC, LWrist\)"):
            quietly(f"frame={path}")

    @pytest.mark.parametrize("separator", [",", "\t"])
    @pytest.mark.parametrize("units", ["mSecs m/(sec^2) deg/sec", "ms m/(s^2)* deg/s*"])
    @pytest.mark.parametrize("kind", ["Low Noise Accelerometer", "Accelerometer"])
    def test_three_rows_of_names_of_shimmercapture(self, tmp_path, separator, units, kind):
        recording = made()
        path = self.captured(recording, tmp_path, separator, units.split(), kind)
        found = understand(path, expected=("frame",))
        assert_same(found.recording, recording)
        assert found.labels == {"frame": "4D72"}

    def captured(self, recording, folder, separator, units, kind="Wide Range Accelerometer"):
        imu = recording.sensor("frame")
        titles = ["Timestamp", *(f"{kind} {a}" for a in "XYZ"), *(f"Gyroscope {a}" for a in "XYZ")]
        si = [units[0], *[units[1]] * 3, *[units[2]] * 3]
        head = [["Shimmer_4D72"] * 14, [t for t in titles for _ in "rc"], ["RAW", "CAL"] * 7]
        head.append([cell for unit in si for cell in ("no units", unit)])
        rows = np.c_[1e3 * recording.time_s + 9687.5, imu.acc_mps2, np.rad2deg(imu.gyr_radps)]
        lines = [*head, *([f"{v:.10g}" for value in row for v in (7, value)] for row in rows)]
        (folder / "capture.csv").write_text("\n".join(map(separator.join, lines)) + "\n")
        return folder / "capture.csv"

    @pytest.mark.parametrize(
        ("old", "new", "says"),
        [
            ("mSecs", "no units", "Timestamp_CAL is in 'no units', expected ms"),
            ("deg/sec", "LSB", "angular rate in 'lsb' is not known"),
            (",CAL", ",RAW", "raw counts; export calibrated data"),
            ("7,9707.5", "7,x", "line 7, column Shimmer_4D72_Timestamp_CAL: 'x' is not a number"),
        ],
    )
    def test_what_is_wrong_in_a_file_of_shimmercapture(self, tmp_path, old, new, says):
        path = self.captured(made(), tmp_path, ",", ["mSecs", "m/(sec^2)", "deg/sec"])
        path.write_text(path.read_text().replace(old, new))
        with pytest.raises(InputError, match=says):
            quietly(path)

    def test_a_file_of_shimmercapture_without_rows(self, tmp_path):
        path = self.captured(made(), tmp_path, ",", ["mSecs", "m/(sec^2)", "deg/sec"])
        for count, says in ((2, "four rows above its numbers"), (4, "no rows of data")):
            (tmp_path / "a.csv").write_text("\n".join(path.read_text().split("\n")[:count]))
            with pytest.raises(InputError, match=says):
                quietly(tmp_path / "a.csv")

    def test_dates_in_place_of_a_clock(self, tmp_path):
        path = dialects.shimmer(made(), tmp_path)
        text = path.read_text().replace("Timestamp_Unix", "TimestampSync_FormattedUnix")
        path.write_text(text)
        with pytest.raises(InputError, match="is written as dates; export it as Unix time in ms"):
            quietly(path)


class TestSensorLogger:
    def as_json(self, folder):
        """The app's export as JSON: numbers as text, the rows of each sensor together."""
        records = []
        for path in sorted(folder.glob("*.csv")):
            if text := path.read_text():
                rows = list(csv.DictReader(io.StringIO(text)))
                records += [{"sensor": path.stem} | row for row in rows]
        records.append({"sensor": "Location", "time": "1", "seconds_elapsed": "0"})
        (folder / "export.json").write_text(json.dumps(records, separators=(",", ":")))
        return folder / "export.json", records

    @pytest.mark.parametrize("platform", ["android", "ios"])
    def test_an_export_as_json(self, tmp_path, platform):
        recording = made()
        path, _ = self.as_json(dialects.sensor_logger(recording, tmp_path, platform=platform))
        found = understand(path, expected=("frame",))
        assert found.format == "Sensor Logger"
        assert_same(found.recording, recording)

    @pytest.mark.parametrize(
        ("old", "new", "says"),
        [
            ("Metadata", "Other", "no record of Metadata, which states the platform: .*as .zip"),
            ('"y":"', '"y":"x', r"record 0 \(Accelerometer\): y is 'x.*expected a number"),
            ("]", "", "no JSON .*; is the file complete"),
            ('{"sensor":"Location"', '7,{"sensor":"Location"', "record 1201 is no object"),
        ],
    )
    def test_an_export_as_json_that_is_damaged(self, tmp_path, old, new, says):
        path, _ = self.as_json(dialects.sensor_logger(made(), tmp_path))
        path.write_text(path.read_text().replace(old, new, 1))
        with pytest.raises(InputError, match=says):
            quietly(path)

    def test_a_reading_that_was_left_over_in_the_phone(self, tmp_path):
        recording = made()
        folder = dialects.sensor_logger(recording, tmp_path)
        for name in ("TotalAcceleration", "Gyroscope"):
            names, rows = (folder / f"{name}.csv").read_text().split("\n", 1)
            stale = "1654847621756825900,-328883.4,0,0,0"
            (folder / f"{name}.csv").write_text(f"{names}\n{stale}\n{rows}")
        found = understand(folder)
        assert_same(found.recording, recording)
        assert "2 reading(s) from long before the start left out" in " ".join(found.warnings)

    @pytest.mark.parametrize("platform", ["android", "ios"])
    def test_a_gyroscope_that_was_recorded_uncalibrated_only(self, tmp_path, platform):
        recording = made()
        folder = dialects.sensor_logger(recording, tmp_path, platform=platform)
        (folder / "Gyroscope.csv").rename(folder / "GyroscopeUncalibrated.csv")
        (folder / "Gyroscope.csv").write_text("")
        found = understand(folder)
        assert_same(found.recording, recording)
        assert "rates of GyroscopeUncalibrated.csv, whose offsets" in " ".join(found.warnings)

    def test_a_platform_that_the_user_writes_down(self, tmp_path):
        recording = made()
        folder = dialects.sensor_logger(recording, tmp_path, platform="ios")
        (folder / "Metadata.csv").unlink()
        with pytest.raises(InputError, match="write one of two lines, 'platform' and below it"):
            quietly(folder)
        (folder / "Metadata.csv").write_text("platform\nios\n")
        assert_same(quietly(folder), recording)

    def test_android_of_an_older_app_without_the_total(self, tmp_path):
        """Accelerometer.csv has no gravity; Gravity.csv has it, at the same times."""
        recording = made()
        folder = dialects.sensor_logger(recording, tmp_path)
        names, rows = (folder / "Accelerometer.csv").read_text().split("\n", 1)
        cells = [row.split(",")[:2] for row in rows.split("\n")]
        gravity = "\n".join(",".join([*cell, "9.80665", "0", "0"]) for cell in cells)
        (folder / "Gravity.csv").write_text(f"{names}\n{gravity}")
        (folder / "TotalAcceleration.csv").unlink()
        assert_same(quietly(folder), recording)
        (folder / "Gravity.csv").unlink()
        with pytest.raises(InputError, match="no accelerations with gravity; record"):
            quietly(folder)


class TestPhyphox:
    LINEAR = '"Time (s)","Linear Acceleration x (m/s^2)","Linear Acceleration y (m/s^2)",'

    def linear(self, path):
        path.write_text(f'{self.LINEAR}"Linear Acceleration z (m/s^2)"\n0,0,0,0\n0.01,0,0,0\n')

    def test_a_file_without_gravity_beside_those_with(self, tmp_path):
        """Its name does not tell: the tab of that experiment is called Raw Data, too."""
        recording = made()
        folder = dialects.phyphox(recording, tmp_path)
        self.linear(folder / "Raw Data.csv")
        assert_same(quietly(folder), recording)
        (folder / "Accelerometer.csv").unlink()
        with pytest.raises(InputError, match=r"Raw Data\.csv: accelerations without gravity"):
            quietly(folder)

    def test_all_quantities_in_one_file(self, tmp_path):
        """An experiment of one's own may have accelerations with gravity and without in one tab."""
        recording = made()
        imu = recording.sensor("frame")
        names = ["Time (s)", *(f"Linear Acceleration {a} (m/s^2)" for a in "xyz")]
        names += [f"Acceleration {a} (m/s^2)" for a in "xyz"]
        names += [f"Gyroscope {a} (rad/s)" for a in "xyz"]
        rows = np.c_[recording.time_s, 0 * imu.acc_mps2, imu.acc_mps2, imu.gyr_radps]
        lines = [",".join(f'"{name}"' for name in names)]
        lines += [",".join(f"{value:.12E}" for value in row) for row in rows]
        (tmp_path / "Raw Data.csv").write_text("\n".join(lines))
        found = quietly(tmp_path / "Raw Data.csv", expected=("frame",))
        assert_same(found, recording)

    def test_two_experiments_in_one_folder_are_named(self, tmp_path):
        folder = dialects.phyphox(made(), tmp_path)
        (folder / "Accelerometer_2.csv").write_text((folder / "Accelerometer.csv").read_text())
        says = r"2 files with acc.* \(Accelerometer\.csv, Accelerometer_2\.csv, Gyroscope\.csv\)"
        with pytest.raises(InputError, match=says):
            quietly(folder)

    def test_a_file_without_gravity_by_its_name(self, tmp_path):
        path = dialects.phyphox(made(), tmp_path) / "Linear Accelerometer.csv"
        path.write_text((tmp_path / "Accelerometer.csv").read_text())
        with pytest.raises(InputError, match="without gravity, by its name; give the folder"):
            quietly(path)
        assert "frame" in quietly(tmp_path).sensors

    def test_columns_that_were_renamed(self, tmp_path):
        path = dialects.phyphox(made(), tmp_path) / "Accelerometer.csv"
        path.write_text(re.sub(r'"([XYZ]) \(m', r'"Accel_\1 (m', path.read_text()))
        with pytest.raises(InputError, match=r"under phyphox' names \(it has: .*Accel_X.*--map"):
            quietly(path)


def test_counts_per_epoch_of_actigraph(tmp_path):
    head = "------------ Data Table File Created By ActiGraph Link ActiLife v6 date format M/d/yyyy"
    (tmp_path / "a.csv").write_text(
        "\n".join([head, *["Serial Number: T"] * 9, "Date,Axis1", "1,2"])
    )
    with pytest.raises(InputError, match="counts per epoch: export the raw data from ActiLife"):
        quietly(tmp_path / "a.csv")


class TestPhysicsToolbox:
    """A setting of the app writes the time of day in place of seconds."""

    def of_day(self, folder, *, separator=",", decimal=".", digits=4, begin_s=86_398.5):
        recording = made()
        path = dialects.physics_toolbox(recording, folder)
        lines = [line.rstrip(",").split(",") for line in path.read_text().split("\n")[1:-1]]
        for row, time_s in zip(lines[1:], recording.time_s, strict=True):
            tenths = round((begin_s + time_s) * 1e4) % 864_000_000
            minutes, fraction = divmod(tenths // 10 ** (4 - digits), 60 * 10**digits)
            seconds, fraction = divmod(fraction, 10**digits)
            row[0] = f"{minutes // 60:02d}:{minutes % 60:02d}:{seconds:02d}:{fraction:0{digits}d}"
            row[1:] = [cell.replace(".", decimal) for cell in row[1:]]
        path.write_text("\n" + "\n".join(separator.join(row) for row in lines) + "\n")
        return path, recording

    @pytest.mark.parametrize("digits", [3, 4])
    @pytest.mark.parametrize("marks", [",.", ";,", "\t."])
    def test_times_of_day_that_go_on_after_midnight(self, tmp_path, digits, marks):
        path, recording = self.of_day(tmp_path, separator=marks[0], decimal=marks[1], digits=digits)
        found = quietly(path, expected=("frame",))
        assert_same(found, recording)

    def test_a_column_of_an_iphone_is_told(self, tmp_path):
        path = dialects.physics_toolbox(made(), tmp_path)
        assert "iPhone" not in " ".join(understand(path).warnings)
        head, *rows = path.read_text().strip().split("\n")
        lines = [f"{head}gFTotal"] + [f"{row}1.0" for row in rows]
        path.write_text("\n".join(lines) + "\n")
        assert "gFz must be +1; if it is -1, read it by a map" in " ".join(
            understand(path).warnings
        )

    def test_a_time_of_day_that_is_none(self, tmp_path):
        path, _ = self.of_day(tmp_path)
        path.write_text(path.read_text().replace("23:59:58:5200", "noon"))
        with pytest.raises(InputError, match="line 5, column time: 'noon' is no time of day"):
            quietly(path)

    def test_a_line_that_is_cut(self, tmp_path):
        path, _ = self.of_day(tmp_path)
        path.write_text(path.read_text().rstrip().rpartition(",")[0])
        with pytest.raises(InputError, match=r"line 402 has 6 of 7 cells"):
            quietly(path)

    def test_fractions_that_may_be_milliseconds(self, tmp_path):
        path, _ = self.of_day(tmp_path, digits=3)
        text = re.sub(r"(?m)^(\d\d:\d\d:\d\d:)(\d\d\d)", r"\g<1>0\2", path.read_text())
        path.write_text(text)
        with pytest.raises(InputError, match="not told from milliseconds; record with elapsed"):
            quietly(path)


class TestLpms:
    """Lines of names that the maker's programs for computer, Android and iOS write."""

    @pytest.mark.parametrize(
        "names",
        [
            "SensorId, TimeStamp (s), {acc}, {gyr}, QuatW, LinAccX (m/s^2), LinAccY (m/s^2)",
            "SensorId, TimeStamp (s), {acc},{gyr}, EulerX(deg) , QuatX, LinAccX(g) ",
            "SensorId,TimeStamp (s),{acc},{gyr},Altitude(m),Temperature(degC),BatteryLevel(%)",
        ],
        ids=["Android", "iOS", "saved again"],
    )
    @pytest.mark.parametrize("units", [("g", "deg/s"), ("m/s^2", "rad/s")])
    def test_other_columns_and_blanks(self, tmp_path, names, units):
        recording = made()
        imu = recording.sensor("frame")
        head = names.format(
            acc=", ".join(f"Acc{a} ({units[0]})" for a in "XYZ"),
            gyr=", ".join(f"Gyro{a} ({units[1]})" for a in "XYZ"),
        )
        scale = {"g": -1 / 9.80665, "m/s^2": -1.0}[units[0]]
        turn = {"deg/s": 180 / np.pi, "rad/s": 1.0}[units[1]]
        rows = np.c_[recording.time_s, scale * imu.acc_mps2, turn * imu.gyr_radps]
        extra = [0.25] * (head.count(",") + 1 - 8)
        lines = [", ".join(["1", *(f"{v:.10g}" for v in [*row, *extra])]) for row in rows]
        (tmp_path / "log.csv").write_text("\r\n".join([head, *lines]) + "\r\n")
        assert_same(quietly(tmp_path / "log.csv", expected=("frame",)), recording)


class TestMovesense:
    """Logs from the sensor's memory, as Movesense's sbem2json converts them."""

    def blocks(self, folder):
        recording = made()
        path = dialects.movesense(recording, folder)
        return recording, json.loads(path.read_text())["Meas"]["IMU9"]

    @pytest.mark.parametrize("indent", [None, 2])
    def test_a_log_that_sbem2json_converted(self, tmp_path, indent):
        recording, blocks = self.blocks(tmp_path)
        samples = [{"TimeDetailed": {"relativeTime": 0, "utcTime": 1712240400000000}}]
        for block in blocks:
            samples += [{"MeasIMU9": block}, {"MeasTemp": {"Timestamp": 0, "Measurement": 306.8}}]
        path = tmp_path / "log.json"
        path.write_text(json.dumps({"Samples": samples}, indent=indent))
        found = understand(path, expected=("frame",))
        assert found.format == "Movesense"
        assert_same(found.recording, recording)

    @pytest.mark.parametrize("converted", [False, True])
    def test_accelerations_and_rates_in_lists_of_their_own(self, tmp_path, converted):
        recording, blocks = self.blocks(tmp_path)
        lists = {
            name: [{"Timestamp": b["Timestamp"], key: b[key]} for b in blocks]
            for name, key in (("Acc", "ArrayAcc"), ("Gyro", "ArrayGyro"))
        }
        pairs = zip(lists["Acc"], lists["Gyro"], strict=True)
        samples = [part for a, g in pairs for part in ({"MeasAcc": a}, {"MeasGyro": g})]
        log = {"Samples": samples} if converted else {"Meas": lists}
        (tmp_path / "log.json").write_text(json.dumps(log))
        assert_same(quietly(tmp_path / "log.json", expected=("frame",)), recording)

    @pytest.mark.parametrize(
        "log", ['{"Samples":[{"MeasAcc":{"Timestamp":1}}]}', '{"Samples":[{"MeasAcc":7},8]}']
    )
    def test_a_converted_log_without_rates(self, tmp_path, log):
        (tmp_path / "log.json").write_text(log)
        with pytest.raises(InputError, match="record acceleration and rate together"):
            quietly(tmp_path / "log.json")
