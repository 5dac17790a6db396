"""Readers of vendors' formats that give one sensor on its own clock, and joining such sensors."""

import io
import json

import numpy as np
import pandas as pd
import pytest
from scipy.io import savemat

from mobility_imu.errors import InputError
from mobility_imu.frames import STANDARD_GRAVITY_MPS2
from mobility_imu.readers.androsensor import read_androsensor
from mobility_imu.readers.clocks import join_streams
from mobility_imu.readers.json_samples import read_json_samples
from mobility_imu.readers.matlab import parse_matlab
from mobility_imu.readers.optitrack import parse_optitrack
from mobility_imu.readers.segments import parse_segments
from mobility_imu.readers.streams import Asked, Stream
from mobility_imu.readers.xio import read_xio
from mobility_imu.readers.xsens_dot import read_xsens_dot

G = STANDARD_GRAVITY_MPS2
XIO_AXES = ",".join(
    [f"Gyroscope {a} (deg/s)" for a in "XYZ"] + [f"Accelerometer {a} (g)" for a in "XYZ"]
)


def stream(time_s, values=None, **given):
    values = np.arange(len(time_s)) * 0.1 if values is None else np.asarray(values, float)
    acc = np.column_stack([values, 0 * values, 0 * values + G])
    return Stream(time_s, acc, np.tile(values[:, None], 3), **given)


class TestStream:
    def test_a_clock_may_repeat_and_leave_gaps(self):
        found = stream(np.array([0.0, 0.1, 0.1, 5.0]))
        assert len(found) == 4
        with pytest.raises(ValueError, match="read-only"):
            found.time_s[0] = 1

    @pytest.mark.parametrize(
        ("time_s", "says"), [([], "no usable sample"), ([0.0, np.nan], "expected a finite number")]
    )
    def test_what_is_no_stream(self, time_s, says):
        with pytest.raises(InputError, match=f"a.csv: .*{says}"):
            stream(np.array(time_s), source="a.csv")

    def test_numbers_are_checked(self):
        with pytest.raises(InputError, match=r"a\.csv: acc_mps2: not a finite number at row 1"):
            Stream([0, 1], [[0, 0, G], [np.inf, 0, G]], np.zeros((2, 3)), source="a.csv")


class TestJoinStreams:
    def test_last_start_to_first_end_by_straight_lines(self):
        early, late = np.arange(0, 3, 0.08), np.arange(0.53, 2.5, 0.07)
        recording, said = join_streams(
            {"frame": stream(early, 2 * early), "left_wheel": stream(late, 2 * late)}, 20.0
        )
        assert said == ()
        assert recording.time_s[0] == 0 and recording.sampling_rate_hz == pytest.approx(20)
        for sensor in recording.sensors:
            rate = recording.gyroscope(sensor)[:, 1]
            np.testing.assert_allclose(rate, 2 * (recording.time_s + 0.53), atol=1e-12)

    def test_a_constant_between_two_clocks(self):
        clock = np.arange(0, 2, 0.01)
        streams = {"frame": stream(clock, clock), "right_wheel": stream(clock - 132.71, clock)}
        with pytest.raises(InputError, match="share no time"):
            join_streams(streams, 100.0)
        recording, _ = join_streams(streams, 100.0, offsets_s={"right_wheel": 132.71})
        np.testing.assert_allclose(
            recording.gyroscope("frame"), recording.gyroscope("right_wheel"), atol=1e-9
        )

    def test_doubled_and_late_samples_and_gaps_are_told(self):
        clock = np.r_[0, 0.01, 0.01, 0.02, 0.015, 0.03, 0.5, 0.51]
        recording, said = join_streams({"frame": stream(clock, clock)}, 100.0, source="a")
        np.testing.assert_allclose(recording.gyroscope("frame")[:, 0], recording.time_s, atol=1e-12)
        assert "a, frame: 2 sample(s) left out whose stamps repeat or run backwards" in said
        assert "a, frame: 1 gap(s) bridged by straight lines, the longest of 0.47 s" in said[1]

    def test_warnings_of_the_reader_are_kept(self):
        clock = np.arange(0, 1, 0.01)
        _, said = join_streams({"frame": stream(clock, warnings=("b: odd",))}, 100.0)
        assert said == ("b: odd",)

    def test_offsets_of_no_sensor_and_no_sensor(self):
        clock = np.arange(0, 1, 0.01)
        with pytest.raises(InputError, match="no sensor wheel"):
            join_streams({"frame": stream(clock)}, 100.0, offsets_s={"wheel": 1.0})
        with pytest.raises(InputError, match="no sensor at all"):
            join_streams({}, 100.0)
        with pytest.raises(InputError, match="sampling rate of 0"):
            join_streams({"frame": stream(clock)}, 0.0)


class TestXio:
    @pytest.mark.parametrize(
        ("name", "unit"),
        [("Time (s)", 1), ("Timestamp (us)", 1e6)],
    )
    def test_units(self, name, unit):
        rows = f"{name},{XIO_AXES}\n{0.5 * unit},180,0,-90,0,0,1\n{0.52 * unit},0,0,0,0.5,0,1\n"
        (found,) = read_xio(rows, "a.csv", Asked())
        np.testing.assert_allclose(found.time_s, [0.5, 0.52])
        np.testing.assert_allclose(found.gyr_radps[0], [np.pi, 0, -np.pi / 2])
        np.testing.assert_allclose(found.acc_mps2, [[0, 0, G], [G / 2, 0, G]])

    def test_gravity_free_tables_are_refused(self):
        with pytest.raises(InputError, match=r"linear\.csv: no column Accelerometer X \(g\), "):
            read_xio("Time (s),X (g),Y (g),Z (g)\n0,0,0,0\n", "linear.csv", Asked())


ROW = {"acc_x": 0, "acc_y": 1, "acc_z": 0, "gy_x": 90, "gy_y": 0, "gy_z": 0}


class TestJsonSamples:
    def test_numbers_may_be_text(self):
        rows = [ROW | {"timestamp": "1680000000.25"}, ROW | {"timestamp": 1680000000.5}]
        (found,) = read_json_samples(json.dumps(rows), "a.json", Asked())
        np.testing.assert_allclose(np.diff(found.time_s), 0.25)
        np.testing.assert_allclose(found.acc_mps2[0], [0, G, 0])
        np.testing.assert_allclose(found.gyr_radps[0], [np.pi / 2, 0, 0])

    @pytest.mark.parametrize(
        ("text", "says"),
        [
            ('[{"acc_x": 1', "no JSON"),
            ('{"acc_x": 1}', "expected a JSON array"),
            ("[]", "expected a JSON array"),
            ("[3]", "sample 0 is no object"),
            (json.dumps([ROW]), "sample 0: timestamp is None"),
            (json.dumps([ROW | {"timestamp": "noon"}]), "timestamp is 'noon'"),
            (
                json.dumps([ROW | {"timestamp": "nan"}]),
                "column timestamp: expected a number",
            ),
            (json.dumps([ROW | {"timestamp": 10**400}]), "timestamp is 1000"),
            (json.dumps([ROW | {"timestamp": 1, "gy_x": True}]), "gy_x is True"),
            (json.dumps([ROW | {"timestamp": "1_0"}]), "timestamp is '1_0'"),
            ("[" * 100_000, "no JSON"),
        ],
    )
    def test_what_is_no_such_array(self, text, says):
        with pytest.raises(InputError, match=f"a.json: .*{says}"):
            read_json_samples(text, "a.json", Asked())


class TestXsensDot:
    HEAD = "PacketCounter,SampleTimeFine,Euler_X,Acc_X,Acc_Y,Acc_Z,Gyr_X,Gyr_Y,Gyr_Z,"

    def text(self, rows, head="sep=,\n"):
        lines = [",".join(map(str, row)) + ", " for row in rows]
        return head + "\n".join([self.HEAD, *lines]) + "\n"

    def test_first_zeros_and_damaged_rows_are_left_out(self):
        rows = [
            (0, 1000, 0, 0, 0, 0, 0, 0, 0),
            (1, 9333, 0, 0, 0, 9.8, 180, 0, 0),
            (2, 17666, 0, "nan", 0, 9.8, 0, 0, 0),
            (3, 25999, 0, 0, 0, 9.8, 0, 1e19, 0),
            (4, 34332, 0, 0, "inf", 9.8, 0, 0, 0),
            (5, 42665, 0, 0, 0, 9.7, 0, 90, 0),
            (6, "", 0, 0, 0, 9.8, 0, 0, 0),
        ]
        (found,) = read_xsens_dot(self.text(rows), "CAR.csv", Asked())
        np.testing.assert_allclose(found.time_s, [0.009333, 0.042665])
        np.testing.assert_allclose(found.gyr_radps, [[np.pi, 0, 0], [0, np.pi / 2, 0]])
        assert found.warnings == (
            "CAR.csv: 1 row(s) of zeros at the beginning left out",
            "CAR.csv: 4 damaged row(s) left out",
        )

    def test_the_clock_goes_on_where_it_starts_again(self):
        rows = [(k, (2**32 - 5000 + 8333 * k) % 2**32, 0, 0, 0, 9.8, 1, 0, 0) for k in range(4)]
        (found,) = read_xsens_dot(self.text(rows, "DeviceTag:,a\n\n"), "a", Asked())
        np.testing.assert_allclose(np.diff(found.time_s), 0.008333, rtol=1e-6)
        assert found.warnings == ()

    @pytest.mark.parametrize(
        ("per_s", "rates_hz"),
        [(1e4, (4, 10, 12, 15, 20, 30, 60, 120)), (1e6, (1, 4, 10, 12, 15, 20, 30, 60, 120))],
        ids=["PC", "app"],
    )
    def test_each_rate_of_a_dot_in_the_units_of_app_and_computer(self, per_s, rates_hz):
        for rate in rates_hz:
            rows = [(k, round(k * per_s / rate), 0, 0, 0, 9.8, 1, 0, 0) for k in range(6)]
            (found,) = read_xsens_dot(self.text(rows), "a.csv", Asked())
            np.testing.assert_allclose(np.diff(found.time_s), 1 / rate, rtol=0.02)

    @pytest.mark.parametrize(
        ("text", "says"),
        [
            ("time,x\n1,2\n", "is it a DOT recording"),
            ("PacketCounter,SampleTimeFine,Quat_W\n1,2,1\n", "no column Acc_X"),
            ("SampleTimeFine,Acc_X,Acc_Y,Acc_Z,Gyr_X,Gyr_Y,Gyr_Z\n1,nan,0,0,0,0,0\n", "no usable"),
        ],
    )
    def test_what_is_no_such_recording(self, text, says):
        with pytest.raises(InputError, match=says):
            read_xsens_dot(text, "a.csv", Asked())


class TestAndrosensor:
    COLUMNS = ",".join(
        [f"ACCELEROMETER {a} (m/s²)" for a in "XYZ"]
        + [f"LINEAR ACCELERATION {a} (m/s²)" for a in "XYZ"]
        + [f"GYROSCOPE {a} (rad/s)" for a in "XYZ"]
        + ["Time since start in ms ", "YYYY-MO-DD HH-MI-SS_SSS"]
    )

    def text(self, unit=1.0, colon=":", late_s=0.2):
        rows = [self.COLUMNS]
        for k in range(200):
            ms = round((late_s + 0.005 * k) * 1000)
            wall = f"2019-06-20 15:08:{57 + ms // 1000:02d}{colon}{ms % 1000:03d}"
            rows.append(f"0,0,9.8,7,7,7,0.1,0,{k},{0.005 * k * unit},{wall}")
        return "\n".join(rows) + "\n"

    @pytest.mark.parametrize("unit", [1.0, 1000.0])
    @pytest.mark.parametrize("colon", [":", "_", "."])
    def test_one_clock_for_several_modules(self, unit, colon):
        """Elapsed time in s or ms, put on the wall clock."""
        (found,) = read_androsensor(self.text(unit, colon), "a.csv", Asked())
        begin = (15 * 60 + 8) * 60 + 57.2
        np.testing.assert_allclose(found.time_s, begin + 0.005 * np.arange(200), atol=1e-9)
        np.testing.assert_array_equal(found.acc_mps2[5], [0, 0, 9.8])  # not the linear one
        np.testing.assert_array_equal(found.gyr_radps[5], [0.1, 0, 5])

    @pytest.mark.parametrize(
        ("change", "says"),
        [
            (("GYROSCOPE Z", "GYRO Z"), "no column GYROSCOPE Z"),
            (("2019-06-20 15:08:57:205", "noon"), "line 3: 'noon' is no date"),
            (("0,0,9.8,7", "0,x,9.8,7"), "line 2, column ACCELEROMETER Y .*'x' is not a finite"),
        ],
    )
    def test_what_is_missing_or_no_number(self, change, says):
        with pytest.raises(InputError, match=says):
            read_androsensor(self.text().replace(*change, 1), "a.csv", Asked())

    def test_clocks_that_do_not_agree(self):
        with pytest.raises(InputError, match="the wall clock over"):
            read_androsensor(self.text(unit=7.0), "a.csv", Asked())


class TestOptitrack:
    def text(self, frames, *, units="Meters"):
        head = (
            f"Format Version,1.23,Take Name,t,Rotation Type,Quaternion,Length Units,{units}\n\n"
            ",Type,Rigid Body" + ",Rigid Body" * 15 + "\n"
            ",Name" + ",back" * 8 + ",chair" * 8 + "\n,ID" + ",1" * 8 + ",2" * 8 + "\n"
            ",,Rotation,Rotation,Rotation,Rotation,Position,Position,Position,Mean Marker Error\n"
            "Frame,Time (Seconds)" + ",X,Y,Z,W,X,Y,Z," * 2 + "\n"
        )
        return head + "".join(f"{k},{k / 120:.6f}" + ",9" * 8 + f",{f}\n" for k, f in frames)

    def test_pose_of_one_body_with_holes(self):
        frames = [(0, "0,0,0,1,1,2,3,0.1"), (1, ",,,,,,,"), (2, "0,1,0,0,4,5,6,0.1")]
        poses = parse_optitrack(self.text(frames), "chair", "a.csv")
        np.testing.assert_array_equal(poses.quaternion[0], [0, 0, 0, 1])
        assert np.isnan(poses.quaternion[1]).all() and np.isnan(poses.position_m[1]).all()
        np.testing.assert_array_equal(poses.position_m[2], [4, 5, 6])
        np.testing.assert_allclose(poses.time_s, [0, 1 / 120, 2 / 120], atol=1e-6)

    def test_what_cannot_be_used(self):
        frames = [(0, "0,0,0,1,1,2,3,0.1"), (1, "0,0,0,1,1,2,3,0.1")]
        for text, body, says in (
            (self.text(frames), "sled", "no rigid body sled .*back, chair"),
            (self.text(frames, units="Millimeters"), "chair", "Length Units is 'Millimeters'"),
            ("a,b\n1,2\n", "chair", "no table export of OptiTrack"),
            (self.text(frames[::-1]), "chair", "do not increase"),
            (self.text([(0, "a,0,0,1,1,2,3,0.1")]), "chair", "cannot be read as a table"),
            (self.text([(0, "TRUE,0,0,1,1,2,3,0.1")] * 2), "chair", "cannot be read as a table"),
        ):
            with pytest.raises(InputError, match=says):
                parse_optitrack(text, body, "a.csv")


class TestSegments:
    def test_rate_and_columns(self):
        text = "# sampling frequency: 40\n# units are s\nseg1_acc_x,seg1_acc_y\n1,2\n3,nan\n"
        rate, table = parse_segments(text, "a.csv")
        assert rate == 40
        np.testing.assert_array_equal(table.columns(["seg1_acc_y"])[:, 0], [2, np.nan])

    def test_without_a_rate(self):
        with pytest.raises(InputError, match="no line '# sampling frequency"):
            parse_segments("# units are s\na,b\n1,2\n", "a.csv")
        with pytest.raises(InputError, match="line 4, column b: 'x' is not a number"):
            parse_segments("# sampling frequency: 40\n#\na,b\n1,x\n", "a.csv")


class TestMatlab:
    def test_variables(self):
        buffer = io.BytesIO()
        savemat(buffer, {"ts": [[1, 2, 3]], "imu": np.ones((3, 6)), "text": "abc"})
        found = parse_matlab(buffer.getvalue(), ["ts", "imu"], "a.mat")
        np.testing.assert_array_equal(found["ts"], [1, 2, 3])
        assert found["imu"].shape == (3, 6)
        for names, says in ((["gt"], "no variable gt"), (["text"], "holds no numbers")):
            with pytest.raises(InputError, match=says):
                parse_matlab(buffer.getvalue(), names, "a.mat")

    @pytest.mark.parametrize("size", [0, 10, 130, 200, 300])
    def test_damaged_files_are_one_line(self, size):
        buffer = io.BytesIO()
        savemat(buffer, {"ts": np.arange(100.0)}, do_compression=True)
        with pytest.raises(InputError, match=r"a\.mat: no MATLAB file") as error:
            parse_matlab(buffer.getvalue()[:size], ["ts"], "a.mat")
        assert "\n" not in str(error.value)


def test_a_joined_recording_is_canonical():
    clock = np.arange(0, 1, 0.01)
    recording, _ = join_streams({"frame": stream(clock)}, 100.0)
    assert isinstance(recording.to_frame(), pd.DataFrame)
    assert list(recording.to_frame())[:2] == ["time_s", "frame_acc_x_mps2"]
