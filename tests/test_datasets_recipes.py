"""Recipes on small made-up origins in the vendors' formats: what must come out is known."""

import io
import json
import tomllib
from typing import get_args

import numpy as np
import pandas as pd
import pytest
from scipy.io import savemat
from scipy.spatial.transform import Rotation

from mobility_imu.datasets.catalogue import Name, find_dataset
from mobility_imu.datasets.files import Output
from mobility_imu.datasets.obtain import _recipe
from mobility_imu.datasets.series import longest_run, low_pass
from mobility_imu.errors import InputError
from mobility_imu.frames import STANDARD_GRAVITY_MPS2
from mobility_imu.readers import read_recording
from mobility_imu.scooter.geometry import ScooterGeometry
from mobility_imu.walker.geometry import WalkerGeometry
from mobility_imu.wheelchair.geometry import WheelchairGeometry

G = STANDARD_GRAVITY_MPS2
XIO = [f"Gyroscope {a} (deg/s)" for a in "XYZ"] + [f"Accelerometer {a} (g)" for a in "XYZ"]


class Files(dict):
    """Path to content, as an origin gives it; what a recipe does not want is not there."""

    @property
    def names(self):
        return sorted(self)

    def read(self, name):
        return self[name]


class Made:
    """A data set that a recipe made."""

    def __init__(self, folder, note):
        self.folder, self.note = folder, note

    @property
    def files(self):
        found = (p.relative_to(self.folder) for p in self.folder.rglob("*") if p.is_file())
        return sorted(p.as_posix() for p in found)

    def table(self, name):
        return pd.read_csv(self.folder / f"{name}.csv.gz")

    def recording(self, name):
        return read_recording(self.folder / f"{name}.csv.gz")

    def toml(self, name):
        return tomllib.loads((self.folder / name).read_text())


@pytest.fixture
def make(tmp_path):
    def make(name, files):
        folder = tmp_path / name
        folder.mkdir()
        recipe = _recipe(find_dataset(name))
        unread = {p: (c if recipe.wanted(p) else None) for p, c in files.items()}
        return Made(folder, recipe.convert(Files(unread), Output(folder)))

    return make


@pytest.mark.parametrize("name", [n for n in get_args(Name) if n != "wheelmove-id-sample"])
def test_an_origin_without_recordings_is_refused(make, name):
    with pytest.raises(InputError, match=r"the origin (has|lacks)"):
        make(name, {"README.md": b"hello"})


def csv_text(columns, *, head="", end=""):
    """Table as vendors write it."""
    rows = [",".join(map(str, row)) + end for row in zip(*columns.values(), strict=True)]
    return (head + "\n".join([",".join(columns) + end, *rows]) + "\n").encode()


def test_longest_run():
    assert longest_run([False, True, True, False, True, True]) == slice(1, 3)  # the first of two
    assert longest_run([False, False]) == slice(0, 0)


def test_low_pass_keeps_slow_motion_in_place():
    t = np.arange(0, 10, 0.01)
    slow, fast = np.sin(t), np.sin(2 * np.pi * 30 * t)
    found = low_pass(np.column_stack([slow + fast, slow]), 3.0, 100.0)
    np.testing.assert_allclose(found[100:-100], np.column_stack([slow, slow])[100:-100], atol=2e-3)


class TestWheelmoveSample:
    def test_byte_for_byte_without_the_outer_folder(self, make):
        table = "a;b\n1,5;2\n".encode("latin-1")
        files = {
            "S/1 - é/T.csv": table,
            "S/P.txt": b"x",
            "S/logo.png": b"no",
            "__MACOSX/a.csv": b"",
        }
        made = make("wheelmove-id-sample", files)
        assert made.files == ["1 - é/T.csv", "P.txt"]
        assert (made.folder / "1 - é" / "T.csv").read_bytes() == table

    def test_no_table_and_paths_outside(self, make):
        with pytest.raises(InputError, match="holds no table"):
            make("wheelmove-id-sample", {"logo.png": b""})

    @pytest.mark.parametrize("path", ["../T.csv", "/T.csv", "a/../../T.csv"])
    def test_a_path_outside(self, make, path, tmp_path):
        with pytest.raises(InputError, match="a path outside"):
            make("wheelmove-id-sample", {path: b"1"})
        assert not list(tmp_path.rglob("T.csv"))


class TestTerrainChair:
    def module(self, begin_s, rate_hz, yaw_scale):
        t = np.arange(0, 6, 1 / rate_hz)
        columns = {f"ACCELEROMETER {a} (m/s²)": 0 * t + (9.8 if a == "Z" else 0) for a in "XYZ"}
        columns |= {f"GYROSCOPE {a} (rad/s)": 0 * t for a in "XYZ"}
        columns["GYROSCOPE Z (rad/s)"] = yaw_scale * np.sin(t + begin_s)
        columns["Time since start in ms "] = t
        stamps = pd.Timestamp("2019-06-20 15:08:57") + pd.to_timedelta(t + begin_s, unit="s")
        columns["YYYY-MO-DD HH-MI-SS_SSS"] = [
            f"{s:%Y-%m-%d %H:%M:%S}:{s.microsecond // 1000:03d}" for s in stamps
        ]
        return csv_text(columns)

    def test_one_clock_and_wheels_exchanged(self, make):
        folder = "imu_data/set_full/"
        files = {
            f"{folder}Middle_GrassDonut_Module.csv": self.module(0.0, 240, 1),
            f"{folder}Left_GrassDonut_Module.csv": self.module(0.7, 200, 2),
            f"{folder}Right_GrassDonut_Module.csv": self.module(0.3, 200, 3),
            f"{folder}Middle_GrassPowerDonut_Module.csv": b"not read",
            f"{folder}Middle_CarpetStraight_Module.csv": self.module(0, 200, 1),
        }
        made = make("terrain-chair", files)
        assert made.files == ["geometry.toml", "grass_donut.csv.gz"]
        assert any("carpet_straight" in sentence for sentence in made.note.left_out)
        (named,) = [sentence for sentence in made.note.done if "exchanged" in sentence]
        assert "the origin's names are right, and all turns go to the other side" in named
        assert any("+1 g upward" in sentence for sentence in made.note.assumed)
        recording = made.recording("grass_donut")
        assert recording.sampling_rate_hz == 100
        for sensor, scale in (("frame", 1), ("right_wheel", 2), ("left_wheel", 3)):
            rate = recording.gyroscope(sensor)[:, 2] / scale
            np.testing.assert_allclose(rate, np.sin(recording.time_s + 0.7), atol=2e-3)
        geometry = WheelchairGeometry.from_toml(made.folder / "geometry.toml")
        assert geometry.track_m == 0.527


class TestLabelledWalks:
    def samples(self, first, count, start=1_680_000_000.0):
        row = {"acc_x": 0.02, "acc_y": 0.98, "acc_z": 0.14, "gy_x": 90.0, "gy_y": 0, "gy_z": 0}
        stamps = start + (first + np.arange(count)) / 80
        # The sensor's last digit moves, as a working sensor's does.
        rows = [
            row | {"timestamp": f"{s:.4f}", "gy_z": 0.06 * (k % 2)} for k, s in enumerate(stamps)
        ]
        return json.dumps(rows).encode()

    def test_walks_steps_and_mount(self, make):
        folder = "python/manually_cut_data/"
        files = {
            f"{folder}walker_steps/step_cluster_3.json": self.samples(0, 1600),
            f"{folder}walker_steps/step_cluster_8.json": b"a copy of cluster 3: not read",
            f"{folder}extracted_steps/step_1.json": self.samples(800, 160),
            f"{folder}extracted_steps/step_2.json": self.samples(810, 160),  # the same step
            f"{folder}extracted_steps/step_10.json": self.samples(160, 160),
            f"{folder}extracted_steps/step_11.json": self.samples(1550, 160),  # beyond the end
            f"{folder}extracted_steps/fall_1.json": b"not read",
        }
        made = make("labelled-walks", files)
        assert made.files == ["labelled_steps.csv", "mount.toml", "walk_03.csv.gz"]
        steps = pd.read_csv(made.folder / "labelled_steps.csv")
        assert steps.walk.tolist() == ["walk_03"] * 2
        np.testing.assert_allclose(steps.begin_s, [2.0, 10.0])
        np.testing.assert_allclose(steps.end_s, [3.987, 11.987], atol=1e-3)
        recording = made.recording("walk_03")
        assert recording.sampling_rate_hz == 80 and recording.time_s[0] == 0
        np.testing.assert_allclose(recording.gyroscope("frame")[0], [np.pi / 2, 0, 0], atol=1e-6)
        mount = WalkerGeometry.from_toml(made.folder / "mount.toml")
        matrix = np.array(made.toml("mount.toml")["walker"]["mount"]["rotation_imu_to_body"])
        up = matrix @ [0.02, 0.98, 0.14]
        np.testing.assert_allclose(up / np.linalg.norm(up), [0, 0, 1], atol=1e-8)
        assert (matrix @ [0, 0, 1])[0] > 0.9  # the sensor's z is forward
        assert mount.footprint_width_m == 0.55


class TestWorklabNgimu:
    def sensor(self, begin_s, wheel):
        t = begin_s + np.arange(0, 20, 0.0025)
        rate = np.clip(t - 8, 0, 1) * 200 if wheel else 0 * t
        wiggle = 0.05 * (np.arange(len(t)) % 3)
        columns = {"Time (s)": t} | {name: 0 * t for name in XIO}
        columns["Gyroscope Y (deg/s)"] = rate + wiggle
        columns["Accelerometer Z (g)"] = 1.006 + 0 * t
        return csv_text({k: np.r_[v[:100], v[99:]] for k, v in columns.items()})  # a doubled packet

    def test_session_on_one_clock_with_cuts(self, make):
        folder = "docs/chapters/examples/example_data/imu_example_data/NGIMU - "
        files = {
            f"{folder}1 Frame - 00337909/sensors.csv": self.sensor(0.0, False),
            f"{folder}3 Right - 003383F9/sensors.csv": self.sensor(0.006, True),
            f"{folder}5 Left - 00338C0E/sensors.csv": self.sensor(0.002, True),
            f"{folder}1 Frame - 00337909/linear.csv": b"not read",
        }
        made = make("worklab-ngimu", files)
        assert sum("1 sample(s) left out" in said for said in made.note.warnings) == 3
        static, straight = made.recording("coast_static"), made.recording("coast_straight")
        assert static.time_s[-1] < 8 and np.ptp(static.time_s) > 7
        assert straight.time_s[0] > 8.3 and np.ptp(straight.time_s) > 10
        assert made.recording("coast").sampling_rate_hz == 400
        assert WheelchairGeometry.from_toml(made.folder / "coast_geometry.toml").track_m == 0.8

    def test_a_sensor_that_is_missing(self, make):
        path = (
            "docs/chapters/examples/example_data/imu_example_data/NGIMU - 1 Frame - 0/sensors.csv"
        )
        with pytest.raises(InputError, match="the origin has 1 of three sensors"):
            make("worklab-ngimu", {path: self.sensor(0.0, False)})


class TestOneHinge:
    def run(self, lean_rad):
        """A lever that sweeps from 0 to 180 degrees and back, encoder one row ahead."""
        count = 2000
        angle = 90 * (1 - np.cos(np.arange(count + 1) / 100))
        found = {"all_time": 5.0 + 0.01 * np.arange(count), "all_encoder": angle[1:]}
        found["all_time"] = np.repeat(found["all_time"][::2], 2)  # stamps come in doubles
        # About the scooter's x, in its axes: gravity seen by lever (turned back by the angle).
        turn = np.deg2rad(angle[:-1]) + lean_rad
        lever = np.column_stack([0 * turn, np.sin(turn), np.cos(turn)])
        body = np.tile([0.0, 0.0, 1.0], (count, 1))
        back = np.linalg.inv(np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0.0]]))
        for number, acc in ((2, lever), (1, body)):
            for axis, values in zip("xyz", (acc @ back.T).T, strict=True):
                found[f"all_accel_{number}_{axis}"] = values
                found[f"all_gyro_{number}_{axis}"] = 0.06 * (np.arange(count) % 3)
        buffer = io.BytesIO()
        savemat(buffer, found)
        return buffer.getvalue()

    def test_axes_zero_and_truth(self, make):
        made = make("one-hinge", {"MatlabCode/Data/raw_pitch_slow.mat": self.run(0.1)})
        assert made.files == [
            "pitch_slow.csv.gz",
            "pitch_slow_geometry.toml",
            "pitch_slow_truth.csv.gz",
        ]
        recording, truth = made.recording("pitch_slow"), made.table("pitch_slow_truth")
        acc = recording.sensor("lever").acc_mps2
        turn = np.arctan2(acc[:, 1], acc[:, 2]) - 0.1
        np.testing.assert_allclose(
            np.unwrap(turn)[1:], -truth.throttle_rad.to_numpy()[1:], atol=1e-5
        )
        assert np.isnan(truth.throttle_rad[0]) and (truth.steering_rad.dropna() == 0).all()
        assert recording.sampling_rate_hz == pytest.approx(100.1, abs=0.1)
        mount = made.toml("pitch_slow_geometry.toml")["scooter"]["mount"]
        level = np.array(mount["rotation_lever_imu_to_lever"]) @ [0, np.sin(0.1), np.cos(0.1)]
        np.testing.assert_allclose(level, [0, 0, 1], atol=0.03)  # "at zero" is within 1.5 deg
        ScooterGeometry.from_toml(made.folder / "pitch_slow_geometry.toml")

    def test_a_file_without_its_variables(self, make):
        buffer = io.BytesIO()
        savemat(buffer, {"other": 1})
        with pytest.raises(InputError, match="pitch_slow: no variable"):
            make("one-hinge", {"MatlabCode/Data/raw_pitch_slow.mat": buffer.getvalue()})


class TestTwoHinges:
    STEERING, THROTTLE = 0.7, -0.4

    def origin(self, trial, late):
        """A chain that turns as a whole; the IMUs may be one sample late."""
        files = {}
        for name, rate_hz, shift in (
            ("omc", 30, 0),
            ("imu_rigid", 40, late),
            ("imu_nonrigid", 40, 0),
        ):
            t = np.arange(0, 8, 1 / rate_hz) - shift / rate_hz
            steering, throttle = self.STEERING * np.sin(t), self.THROTTLE * np.sin(2 * t)
            base = Rotation.from_euler(
                "xyz", np.column_stack([0.3 * np.sin(t), 0.2 * t, 0.1 + 0 * t])
            )
            middle = base * Rotation.from_rotvec(np.column_stack([0 * t, steering, 0 * t]))
            turns = {
                3: base,
                4: middle,
                5: middle * Rotation.from_rotvec(np.column_stack([0 * t, 0 * t, -throttle])),
            }
            columns = {}
            for segment, turn in turns.items():
                if name == "omc":
                    quaternion = turn.as_quat()
                    quaternion[100:110] = np.nan
                    for k, axis in enumerate("xyzw"):
                        columns[f"seg{segment}_quat_{axis}"] = quaternion[:, k]
                    continue
                acc = turn.inv().apply([0, 0, 9.8])
                for k, axis in enumerate("xyz"):
                    columns[f"seg{segment}_acc_{axis}"] = acc[:, k]
                    columns[f"seg{segment}_gyr_{axis}"] = 0.01 * (k + 1) + 0 * t
            head = f"# sampling frequency: {rate_hz}\n# units are seconds/meters/radians/a.u.\n"
            files[f"data/dataset/trial{trial}/{name}.csv"] = csv_text(columns, head=head)
        return files

    @pytest.mark.parametrize(("trial", "late"), [(1, 0), (2, 1)])
    def test_angles_axes_and_gaps(self, make, trial, late):
        made = make("two-hinges", self.origin(trial, late))
        assert made.files == sorted(
            ["geometry.toml"]
            + [f"trial{trial}_{k}{e}.csv.gz" for k in ("rigid", "foam") for e in ("", "_truth")]
        )
        truth, recording = (
            made.table(f"trial{trial}_rigid_truth"),
            made.recording(f"trial{trial}_rigid"),
        )
        seen = truth.steering_rad.notna().to_numpy()
        t = truth.time_s.to_numpy()[seen] - late / 40
        np.testing.assert_allclose(truth.steering_rad[seen], self.STEERING * np.sin(t), atol=2e-3)
        np.testing.assert_allclose(
            truth.throttle_rad[seen], self.THROTTLE * np.sin(2 * t), atol=2e-3
        )
        lost = truth.time_s[~seen] - late / 40
        inner = lost[(lost > 0.1) & (lost < 7.8)]
        assert 100 / 30 - 0.2 < inner.min() and inner.max() < 110 / 30 + 0.2
        np.testing.assert_allclose(recording.gyroscope("lever")[0], [0.03, 0.01, 0.02], atol=1e-6)
        body = recording.gyroscope("body")[0].copy()
        np.testing.assert_allclose(
            Rotation.from_euler("x", -45, degrees=True).apply(body), [0.03, 0.01, 0.02], atol=1e-6
        )
        ScooterGeometry.from_toml(made.folder / "geometry.toml")

    def test_a_table_that_is_missing(self, make):
        files = self.origin(1, 0)
        del files["data/dataset/trial1/omc.csv"]
        with pytest.raises(InputError, match=r"trial 1: the origin has no omc\.csv"):
            make("two-hinges", files)


class TestFootWalks:
    def walk(self, count=400, gap=False):
        t = 7.0 + 0.005 * np.arange(count)
        t[200:] += 0.004 * gap
        imu = np.column_stack(
            [np.full((count, 3), [0, 0, -9.8]), 0.01 * np.arange(count)[:, None] % 3 * np.ones(3)]
        )
        place = np.column_stack([0.1 + t, 2 * t, 0 * t])
        buffer = io.BytesIO()
        savemat(buffer, {"ts": t[None], "imu": imu, "gt": place, "zv_shoe_opt": (t > 8)[None]})
        return buffer.getvalue()

    def test_order_mirror_and_clock(self, make):
        folder = "data/vicon/processed/"
        files = {
            f"{folder}2018-02-22-10-08-52.mat": self.walk(gap=True),
            f"{folder}2017-11-22-11-22-03.mat": self.walk(300),
            f"{folder}extract_optimal_detectors.m": b"not read",
        }
        made = make("foot-walks", files)
        assert made.files == [
            f"foot_{k}{end}.csv.gz" for k in ("01", "02") for end in ("", "_truth")
        ]
        assert len(made.table("foot_01")) == 300  # the earlier date
        truth = made.table("foot_02_truth")
        np.testing.assert_allclose(truth.y_m, -2 * truth.time_s, atol=1e-6)  # mirrored
        np.testing.assert_allclose(truth.x_m, truth.time_s, atol=1e-6)
        assert truth.time_s[0] == 0 and set(truth.still) == {0, 1}
        with pytest.raises(InputError, match="gap"):
            made.recording("foot_02")  # left as it came
        with pytest.warns(UserWarning, match="1 gap"):
            read_recording(made.folder / "foot_02.csv.gz", fill_gaps_s=0.05)

    def test_series_of_two_lengths(self, make):
        buffer = io.BytesIO()
        t = np.arange(10.0)
        savemat(buffer, {"ts": t, "imu": np.ones((9, 6)), "gt": np.ones((10, 3)), "zv_shoe_opt": t})
        with pytest.raises(InputError, match="foot_01: its variables are no series of one length"):
            make("foot-walks", {"data/vicon/processed/2018-02-22-10-08-52.mat": buffer.getvalue()})


class TestCarWheels:
    RADIUS, TRACK = 0.3, 1.5

    def origin(self, trial, *, gnss_late_s, jump=False):
        """Rest, acceleration, a straight way, turns; the wheels' clocks differ."""
        t = np.arange(0, 100, 1 / 120)
        speed = np.interp(t, [0, 20, 30, 60, 70, 100], [0, 0, 8, 8, 5, 5])
        yaw_rate = np.where(t > 60, 0.25 * np.sin(0.4 * t), 0.0)
        left = (speed - yaw_rate * self.TRACK / 2) / self.RADIUS
        right = (speed + yaw_rate * self.TRACK / 2) / self.RADIUS
        files = {}
        for name, rate, sign, clock in (
            ("CAR", yaw_rate, 1, 848.0),
            ("IMU4", left, 1, 848.0),
            ("IMU2", right, -1, 848.0 - 132.71),
        ):
            columns = {
                "PacketCounter": np.arange(len(t)),
                "SampleTimeFine": np.rint((clock + t) * 1e6),
            }
            columns |= {f"Acc_{a}": 0 * t + 9.8 * (a == "Z") for a in "XYZ"}
            columns |= {f"Gyr_{a}": 0 * t + np.rad2deg(sign * rate) * (a == "Z") for a in "XYZ"}
            files[f"Datasets/{trial}/{name}.csv"] = csv_text(columns, head="sep=,\n", end=",")
        fine = np.arange(0, 90, 0.01)
        heading = np.cumsum(yaw_rate) / 120
        east, north = (np.cumsum(speed * f(heading)) / 120 for f in (np.cos, np.sin))
        held = np.floor(fine / 0.2) * 0.2 + gnss_late_s  # a fix each 0.2 s, repeated in between
        x, y = np.interp(held, t, east), np.interp(held, t, north)
        if jump:
            y[(fine > 80) & (fine < 80.5)] += 30
        columns = {
            "Timestamp": 10 * fine,
            "Lat_GNSS": np.round(32.7 + y / 110_900, 9),
            "Long_GNSS": np.round(35.0 + x / (111_320 * np.cos(np.deg2rad(32.7))), 9),
        }
        files[f"Datasets/{trial}/GNSS.csv"] = csv_text(columns)
        return files

    def test_clocks_geometry_and_truth(self, make):
        files = self.origin("trial02", gnss_late_s=2.0)
        files |= self.origin("trial04", gnss_late_s=5.0, jump=True)
        made = make("car-wheels", files)
        ends = (".csv.gz", "_geometry.toml", "_static.csv.gz", "_straight.csv.gz", "_truth.csv.gz")
        assert made.files == sorted(f"{t}{e}" for t in ("trial02", "trial04") for e in ends)
        assert "trial02: receiver's clock shifted by +2.0" in made.note.fitted[2]
        for trial in ("trial02", "trial04"):
            geometry = WheelchairGeometry.from_toml(made.folder / f"{trial}_geometry.toml")
            assert geometry.wheel_radius_left_m == pytest.approx(self.RADIUS, rel=0.01)
            assert geometry.wheel_radius_right_m == pytest.approx(self.RADIUS, rel=0.01)
            assert geometry.track_m == pytest.approx(self.TRACK, rel=0.05)
        recording, truth = made.recording("trial02"), made.table("trial02_truth")
        left = recording.gyroscope("left_wheel")[:, 2]
        right = -recording.gyroscope("right_wheel")[:, 2]
        still_straight = recording.time_s < 55
        np.testing.assert_allclose(left[still_straight], right[still_straight], atol=0.05)
        wheel = np.interp(truth.time_s, recording.time_s, (left + right) / 2) * self.RADIUS
        inner = (truth.time_s > 10) & (truth.time_s < 85)  # at its ends the low-pass knows less
        assert np.abs(wheel - truth.speed_mps)[inner].max() < 0.1
        assert np.ptp(made.recording("trial02_static").time_s) > 9
        static = made.recording("trial02_static")
        assert np.abs(static.gyroscope("left_wheel")).max() < 0.05
        assert np.abs(made.recording("trial02_straight").gyroscope("frame")).max() < 0.02
        jumped = made.table("trial04_truth")
        left_out = jumped.time_s[jumped.speed_mps.isna()]
        assert 80 + 5 - 2 < left_out.min() and left_out.max() < 80.5 + 5 + 2
        assert any("trial04: speed left out" in said for said in made.note.warnings)

    def test_the_trial_that_gives_the_geometry_is_needed(self, make):
        with pytest.raises(InputError, match="lacks trial02"):
            make("car-wheels", self.origin("trial04", gnss_late_s=1.0))


class TestMocapChair:
    RADIUS, HALF, CAMBER = 0.31, 0.28, np.deg2rad(17)

    def trial(self, *, begin_s=1.3, slip=0.0, seconds=14.0, radius=RADIUS, still=False):
        """Sensors and capture of a drive with a turn on the spot, then a slalom."""
        t = np.arange(0, seconds, 0.02)
        speed = 0 * t if still else np.interp(t, [0, 4, 5, 99], [0, 0, 1.5, 1.5])
        yaw_rate = 0 * t if still else np.where(t < 4, 2 * np.sin(np.pi * t / 4), np.sin(2 * t))
        wheel = (speed + yaw_rate * self.HALF) / radius
        wheel = wheel + slip * np.random.default_rng(1).standard_normal(len(t))
        lean = np.sin(self.CAMBER)
        sensors = {}
        noise = 0.01 * (np.arange(len(t)) % 3)
        for place, gyr, acc in (
            ("Chair", (yaw_rate, noise, 0 * t), (1 + 0 * t, 0 * t, 0 * t)),
            ("x-IMU3", (wheel, noise, 0 * t), (lean + 0 * t, np.cos(self.CAMBER) + 0 * t, 0 * t)),
        ):
            columns = {"Timestamp (us)": np.rint((4734 + t) * 1e6)}
            columns |= dict(zip(XIO[:3], np.rad2deg(gyr), strict=True))
            columns |= dict(zip(XIO[3:], acc, strict=True))
            sensors[place] = csv_text(columns)
        fine = np.arange(0, seconds - 2, 1 / 120)
        grid = np.arange(0, seconds, 1 / 1200)
        rate, way = np.interp(grid, t, yaw_rate), np.interp(grid, t, speed)
        yaw = np.cumsum(rate) / 1200
        place = np.column_stack(
            [np.cumsum(way * np.cos(yaw)), 0 * yaw, -np.cumsum(way * np.sin(yaw))]
        )
        at = begin_s + fine
        yaw = np.interp(at, grid, yaw)
        place = np.column_stack([np.interp(at, grid, axis / 1200) for axis in place.T])
        # Real markers wobble; without that, any wheel could be explained by sliding sideways.
        place = place + 0.002 * np.random.default_rng(2).standard_normal(place.shape)
        half = yaw / 2
        rows = [
            f"{k},{k / 120:.6f},0,{np.sin(h):.7f},0,{np.cos(h):.7f},{x:.6f},{y:.6f},{z:.6f},0.1"
            for k, (h, (x, y, z)) in enumerate(zip(half, place, strict=True))
        ]
        rows[600:650] = [f"{k},{k / 120:.6f},,,,,,,," for k in range(600, 650)]
        head = (
            "Format Version,1.23,Take Name,t,Rotation Type,Quaternion,Length Units,Meters\n\n"
            ",Type" + ",Rigid Body" * 8 + "\n,Name" + ",chair" * 8 + "\n,ID" + ",1" * 8 + "\n"
            ",,Rotation,Rotation,Rotation,Rotation,Position,Position,Position,Error\n"
            "Frame,Time (Seconds),X,Y,Z,W,X,Y,Z,\n"
        )
        return sensors, (head + "\n".join(rows) + "\n").encode()

    def straight(self):
        """A steady straight push, long enough for whole turns of the wheel, after a rest."""
        t = np.arange(0, 12, 0.02)
        wheel = np.interp(t, [0, 4, 5, 99], [0, 0, 6, 6])
        noise = 0.01 * (np.arange(len(t)) % 3)
        lean = np.sin(self.CAMBER)
        files = {}
        for place, x, acc_x in (("Chair", 0 * t, 1.0), ("x-IMU3", wheel, lean)):
            columns = {"Timestamp (us)": np.rint(t * 1e6)}
            columns |= dict(zip(XIO[:3], np.rad2deg((x, noise, 0 * t)), strict=True))
            acc = (acc_x + 0 * t, np.sqrt(1 - acc_x**2) + 0 * t, 0 * t)
            columns |= dict(zip(XIO[3:], acc, strict=True))
            files[place] = csv_text(columns)
        return files

    def person(self, day, name, trials):
        files = {f"data/{day}/{name}/.DS_Store": b"", f"data/{day}/{name}/imu/x": b""}
        for task, (sensors, capture) in trials.items():
            for place, content in sensors.items():
                folder = f"data/{day}/{name}/imu/{name}_{task}/{place} B4A2 (UDP)"
                files[f"{folder}/Inertial.csv"] = content
            files[f"data/{day}/{name}/opti/{name}_{task}.csv"] = capture
        for place, content in self.straight().items():
            folder = f"data/{day}/{name}/imu/{name}_straightpush_hs/{place} B4A2 (UDP)"
            files[f"{folder}/Inertial.csv"] = content
        return files

    def test_choice_geometry_truth_and_numbers_for_people(self, make):
        files = self.person(
            "test_02.13",
            "qq-two",
            {
                "slalom_ls": self.trial(begin_s=1.3),
                "slalom_hs": self.trial(slip=3.0),
                "uturn_ls": self.trial(radius=0.330),
                "uturn_hs": (self.trial()[0], b"Format Version,1\n"),
            },
        )
        files |= self.person("test_02.13", "qq-one", {"figure8_ls": self.trial(begin_s=-0.4)})
        files |= self.person("test_03.21", "qq-three", {"slalom_ls": self.trial(seconds=9.0)})
        made = make("mocap-chair", files)
        choice = made.table("trials").set_index("trial")
        assert choice.chosen.to_dict() == {
            "P01_figure8_ls": 1,
            "P02_slalom_ls": 1,
            "P02_slalom_hs": 0,
            "P02_uturn_ls": 0,
            "P03_slalom_ls": 0,
        }
        assert "slip" in choice.why_not["P02_slalom_hs"]
        assert "radius" in choice.why_not["P02_uturn_ls"]
        assert any("P02_uturn_hs" in sentence for sentence in made.note.left_out)
        assert choice.capture_begins_s["P02_slalom_ls"] == pytest.approx(1.3, abs=0.005)
        assert choice.capture_begins_s["P01_figure8_ls"] == pytest.approx(-0.4, abs=0.005)
        for file in (
            "P02_slalom_ls.csv.gz",
            "P01_static.csv.gz",
            "others/P02_slalom_hs_truth.csv.gz",
        ):
            assert file in made.files
        geometry = WheelchairGeometry.from_toml(made.folder / "P02_geometry.toml")
        assert geometry.wheel_radius_right_m == pytest.approx(self.RADIUS, abs=2e-3)
        assert np.rad2deg(geometry.camber_rad) == pytest.approx(17, abs=0.1)
        half = geometry.track_m / 2 - geometry.wheel_radius_right_m * np.sin(geometry.camber_rad)
        assert half == pytest.approx(self.HALF, abs=5e-3)
        truth, recording = made.table("P02_slalom_ls_truth"), made.recording("P02_slalom_ls")
        seen = truth.speed_mps.notna()
        assert 0.5 < seen.mean() < 0.9  # a gap of 0.4 s with margins, and both ends
        late = seen & (truth.time_s > 8)
        np.testing.assert_allclose(truth.speed_mps[late], 1.5, atol=0.03)
        rate = recording.gyroscope("frame")[late.to_numpy(), 0]
        np.testing.assert_allclose(truth.yaw_rate_radps[late], rate, atol=0.03)
        # No name of a person, neither in a file's name nor in a text.
        texts = [*made.files, *map(str, vars(made.note).values())]
        texts += [(made.folder / f).read_text() for f in made.files if f.endswith(".toml")]
        texts += made.table("trials").to_csv().splitlines()
        assert not any("qq-" in text for text in texts)

    def test_captures_that_were_not_at_hand_change_nothing(self, make, monkeypatch):
        sensors, capture = self.trial()
        large = self.trial(radius=0.300)
        files = self.person(
            "test_03.21", "qq-two", {"slalom_ls": (sensors, capture), "slalom_hs": large}
        )
        long = max(len(capture), len(large[1])) + 1
        files["data/test_03.21/qq-two/opti/qq-two_slalom_hs.csv"] = large[1] + b"\n" * long
        monkeypatch.setattr("mobility_imu.datasets.recipes.mocap_chair.SMALL_BYTES", long)
        made = make("mocap-chair", files)
        choice = made.table("trials").set_index("trial")
        assert choice.why_not["P01_slalom_hs"] == "not at hand when the choice was made"
        geometry = WheelchairGeometry.from_toml(made.folder / "P01_geometry.toml")
        assert geometry.wheel_radius_right_m == pytest.approx(self.RADIUS, abs=2e-3)
        assert "others/P01_slalom_hs.csv.gz" in made.files
