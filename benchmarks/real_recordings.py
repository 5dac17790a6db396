"""Real recordings with a reference, made ready for peers, judged alike, and ours beside them.

A recording is a ``Case``: what a peer is given (arrays, written as .npz), how what it answers is
judged, and what ours answers. Ours is what ``mobility-imu wheelchair velocity`` and
``mobility-imu scooter angles --method fusion`` write with their defaults; for a foot, for which the
command has no option, ``estimate_trajectory`` with ``NavigationSettings.for_foot()``.
"""

import contextlib
import hashlib
import io
import tempfile
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from error_measures import angle_error, path_error, speed_error
from scipy.spatial.transform import Rotation

from mobility_imu.cli.main import app
from mobility_imu.datasets.folders import find_folder
from mobility_imu.errors import InputError
from mobility_imu.readers import read_recording
from mobility_imu.scooter import ScooterGeometry, ScooterMount
from mobility_imu.walker import NavigationSettings, WalkerMount, estimate_trajectory
from mobility_imu.walker.saturation import bridged_rates
from mobility_imu.wheelchair import WheelchairGeometry, calibrate_mount

ENDING = "_truth.csv.gz"
FEET_RATE_HZ = 200.0
FEET_RANGE_RADPS = np.deg2rad(500.0)
"""The readings of this gyroscope pile up between 515 and 560 deg/s; below 500 they do not."""


class Case(NamedTuple):
    """One recording: input of the peer, our answer, and errors of an answer in SI or deg."""

    name: str
    sha256: str
    given: dict[str, Any]
    ours: dict[str, np.ndarray]
    judge: Callable[[dict[str, np.ndarray]], dict[str, float]]


class RealSet(NamedTuple):
    """Recordings of one kind, with the peer that is asked and what both were given."""

    name: str
    dataset: str
    peer: str
    script: str
    given: str
    peer_settings: str
    cases: Callable[[Path], list[Case]]
    measures: tuple[str, ...]  # errors that the table compares, by key


def available(real_set):
    """Folder of a set's recordings, None if they are not here."""
    return find_folder(real_set.dataset)


def names_with_truth(folder):
    return [path.name.removesuffix(ENDING) for path in sorted(folder.glob(f"*{ENDING}"))]


def checksum(path):
    return hashlib.sha256(path.read_bytes()).hexdigest()


def command(*arguments):
    """Table that one of our commands writes."""
    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()):
        target = Path(folder) / "answer.csv"
        given = [str(each) for each in (*arguments, "-o", target)]
        with contextlib.redirect_stderr(io.StringIO()), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            app(given, standalone_mode=False)
        return pd.read_csv(target)


def quiet_recording(path, **options):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return read_recording(path, **options)


# Chairs and a car.


def exchanged(to, from_vector):
    """Matrix that only exchanges axes: the largest component becomes ``to``, positive."""
    axis = int(np.argmax(np.abs(from_vector)))
    matrix = np.zeros((3, 3))
    matrix[to, axis] = sign = np.sign(from_vector[axis])
    others = [k for k in range(3) if k != axis]
    rest = [k for k in range(3) if k != to]
    matrix[rest[0], others[0]] = 1.0
    matrix[rest[1], others[1]] = 1.0
    if np.linalg.det(matrix) < 0:
        matrix[rest[1], others[1]] = -1.0
    assert sign and np.isclose(np.linalg.det(matrix), 1)
    return matrix


def chair_cases(folder, label_of, cutoff_hz):
    """Speed by frame and wheels; worklab wants the frame's z up, a wheel's y along its axle."""
    cases = []
    for name in names_with_truth(folder):
        label = label_of(name)
        files = {key: folder / f"{label}_{key}.csv.gz" for key in ("static", "straight")}
        static, straight, drive = map(quiet_recording, (*files.values(), folder / f"{name}.csv.gz"))
        geometry_file = folder / f"{label}_geometry.toml"
        geometry = WheelchairGeometry.from_toml(geometry_file)
        mount = calibrate_mount(static, straight).mount
        to_y = np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]])  # z of ours is y of worklab
        given: dict[str, Any] = {"time_s": drive.time_s}
        for theirs, ours in (("frame", "frame"), ("right", "right_wheel"), ("left", "left_wheel")):
            if ours not in drive.sensors:
                continue
            acc, gyr = drive.sensor(ours).acc_mps2, drive.gyroscope(ours)
            if theirs == "frame":
                plain = exchanged(2, static.sensor(ours).acc_mps2.mean(axis=0))
                aligned = mount.rotation_frame_imu_to_chair
            else:
                aligned = to_y @ mount.rotation_imu_to_wheel(theirs)
                plain = exchanged(1, aligned[1])
            given |= {f"{theirs}_acc": acc @ plain.T, f"{theirs}_gyr": gyr @ plain.T}
            given |= {
                f"{theirs}_acc_aligned": acc @ aligned.T,
                f"{theirs}_gyr_aligned": gyr @ aligned.T,
            }
        radii = geometry.wheel_radius_right_m, geometry.wheel_radius_left_m
        given |= {
            "camber_deg": np.rad2deg(geometry.camber_rad),
            "radius_m": radii[0] if "left_acc" not in given else np.mean(radii),
            "track_m": geometry.track_m,
        }
        table = command(
            "wheelchair", "velocity", folder / f"{name}.csv.gz", "--static", files["static"],
            "--straight", files["straight"], "--geometry", geometry_file,
        )  # fmt: skip
        truth = pd.read_csv(folder / f"{name}{ENDING}")
        true = truth["time_s"].to_numpy(), truth["speed_mps"].to_numpy()

        def judge(answer, clock=drive.time_s, true=true):
            errors = speed_error(clock, answer["speed_mps"], *true, cutoff_hz)
            for way in ("aligned", "not_resampled"):  # a peer's other answers
                if f"{way}_mps" in answer:
                    other = speed_error(clock, answer[f"{way}_mps"], *true, cutoff_hz)
                    errors[f"rms_{way}_mps"] = other["rms_mps"]
            return errors

        speed = np.interp(drive.time_s, table["time_s"], table["linear_velocity_mps"])
        cases.append(
            Case(name, checksum(folder / f"{name}.csv.gz"), given, {"speed_mps": speed}, judge)
        )
    return cases


# Hinges.


def our_angles(path, geometry_file, samples):
    """Angles by our command; NaN throughout where it refuses the recording."""
    given = ("--geometry", geometry_file, "--method", "fusion")
    try:
        table = command("scooter", "angles", path, *given)
    except InputError as refusal:
        print(f"  ours refuses {path.name}: {refusal}")
        return dict.fromkeys(("first_rad", "second_rad"), np.full(samples, np.nan))
    return {
        "first_rad": np.deg2rad(table["steering_deg"].to_numpy()),
        "second_rad": -np.deg2rad(table["throttle_deg"].to_numpy()),
    }


def hinge_cases(folder):
    """Steering and throttle; a peer gets both sensors turned so that the joint's axes are z, x.

    With both angles zero the turned axes of both sensors are parallel:
    lever to body = Rx(alpha) Rz(steering) Rx(-throttle) Rx(beta - alpha), eq. 5.
    """
    cases = []
    for name in names_with_truth(folder):
        path = folder / f"{name}.csv.gz"
        own = folder / f"{name}_geometry.toml"
        geometry_file = own if own.is_file() else folder / "geometry.toml"
        geometry = ScooterGeometry.from_toml(geometry_file)
        recording = quiet_recording(path)
        alpha, beta = geometry.steering_inclination_rad, geometry.lever_inclination_rad
        turns = {
            "base": Rotation.from_euler("x", -alpha).as_matrix(),
            "tip": Rotation.from_euler("x", beta - alpha).as_matrix(),
        }
        if "[scooter.mount]" in geometry_file.read_text():
            mount = ScooterMount.from_toml(geometry_file)
            turns["base"] = turns["base"] @ mount.rotation_body_imu_to_body
            turns["tip"] = turns["tip"] @ mount.rotation_lever_imu_to_lever
        given: dict[str, Any] = {"rate_hz": recording.sampling_rate_hz}
        for end, sensor in (("base", "body"), ("tip", "lever")):
            given[f"{end}_acc"] = recording.sensor(sensor).acc_mps2 @ turns[end].T
            given[f"{end}_gyr"] = recording.gyroscope(sensor) @ turns[end].T
        ours = our_angles(path, geometry_file, len(recording))
        truth = pd.read_csv(folder / f"{name}{ENDING}")
        steering, throttle = (
            np.interp(recording.time_s, truth["time_s"], truth[f"{key}_rad"])
            for key in ("steering", "throttle")
        )
        there = np.isfinite(steering) & np.isfinite(throttle)
        if np.isfinite(ours["first_rad"]).any():  # the same samples for both
            there &= np.isfinite(ours["first_rad"])

        def judge(answer, steering=steering, throttle=throttle, there=there):
            first = angle_error(answer["first_rad"], steering, there)
            second = angle_error(-answer["second_rad"], throttle, there)
            return {
                "steering_rms_deg": first,
                "throttle_rms_deg": second,
                "both_rms_deg": float(np.hypot(first, second)),
            }

        cases.append(Case(name, checksum(path), given, ours, judge))
    return cases


# Feet.


def foot_cases(folder):
    """Path with the rests given; a clock of 200 Hz for the peer, which knows no other."""
    cases = []
    for name in names_with_truth(folder):
        path = folder / f"{name}.csv.gz"
        recording = quiet_recording(path, fill_gaps_s=0.05)
        truth = pd.read_csv(folder / f"{name}{ENDING}")
        clock = recording.time_s
        place = np.column_stack(
            [np.interp(clock, truth["time_s"], truth[f"{axis}_m"]) for axis in "xyz"]
        )
        rests = np.interp(clock, truth["time_s"], truth["still"]) > 0.99
        acc = recording.sensor("frame").acc_mps2
        first = acc[clock < clock[0] + 0.5].mean(axis=0)
        upright, _ = Rotation.align_vectors([[0, 0, 1]], [first])
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            found = estimate_trajectory(
                recording, None, WalkerMount(upright.as_matrix(), [0.0, 0.0, 0.0]),
                NavigationSettings.for_foot(gyr_range_radps=FEET_RANGE_RADPS), rests=rests,
            )  # fmt: skip
        assert len(found) == len(clock), "a walk that does not begin at rest"
        given = {
            "acc": acc,
            "gyr": recording.gyroscope("frame"),
            "gyr_bridged": bridged_rates(recording.gyroscope("frame"), FEET_RANGE_RADPS)[0],
            "quaternion": upright.as_quat(),
            "rests": rests,
            "rate_hz": FEET_RATE_HZ,
        }

        def judge(answer, place=place):
            errors = {"rms_m": path_error(answer["path_m"], place)}
            if "bridged_m" in answer:
                errors["rms_bridged_m"] = path_error(answer["bridged_m"], place)
            return errors

        cases.append(Case(name, checksum(path), given, {"path_m": found.position_m}, judge))
    return cases


QMT_SETTINGS = (
    "oriEstOfflineVQF; headingCorrection with two axes, window centred, 32 s, time constants 2 s "
    "(of 24 combinations the best against the reference)"
)
SETS = (
    RealSet(
        "chairs", "mocap-chair", "worklab", "peer_worklab.py",
        "frame and right wheel, camber, radius and half track (radius, track and one shift of the "
        "clock per trial fitted to the reference); ours also a rest and a straight drive",
        "resample_imu (400 Hz), offset(), process_imu(n_sensors=2); axes exchanged",
        lambda folder: chair_cases(folder, lambda name: name[:3], 3.0), ("rms_mps",),
    ),
    RealSet(
        "car", "car-wheels", "worklab", "peer_worklab.py",
        "body and two wheels; radii, track and shifts of the clocks fitted to the reference; ours "
        "also a rest and a straight drive",
        "resample_imu (400 Hz), offset(), process_imu(n_sensors=3); axes exchanged",
        lambda folder: chair_cases(folder, lambda name: name, 0.5), ("rms_mps",),
    ),
    RealSet(
        "two hinges", "two-hinges", "qmt", "peer_qmt.py",
        "both sensors, both axes",
        QMT_SETTINGS,
        hinge_cases, ("steering_rms_deg", "throttle_rms_deg", "both_rms_deg"),
    ),
    RealSet(
        "one hinge", "one-hinge", "qmt", "peer_qmt.py",
        "both sensors, both axes, the encoder's zero",
        QMT_SETTINGS,
        hinge_cases, ("steering_rms_deg", "throttle_rms_deg", "both_rms_deg"),
    ),
    RealSet(
        "feet", "foot-walks", "gaitmap", "peer_gaitmap_feet.py",
        "the rests (best mask of the origin), gravity of the first 0.5 s; heading fitted; ours "
        "also that the gyroscope reads right up to 500 deg/s (from its readings)",
        "RtsKalman, level_walking=True, rests given, 200 Hz",
        foot_cases, ("rms_m",),
    ),
)  # fmt: skip
