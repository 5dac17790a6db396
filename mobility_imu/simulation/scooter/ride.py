"""Rides over a course, recorded by an IMU on the lever and one on the body."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy import interpolate, signal
from scipy.spatial.transform import Rotation

from mobility_imu.arguments import check_columns, expect, settings_or_default
from mobility_imu.errors import InputError
from mobility_imu.fields import check_fields
from mobility_imu.frames import FloatArray, as_number
from mobility_imu.recording import Recording
from mobility_imu.results import Result
from mobility_imu.rotations import elementary_rotation
from mobility_imu.scooter.geometry import (
    SUZUKI_ET4D,
    ScooterGeometry,
    rotation_lever_base_to_steering,
    rotation_lever_to_lever_base,
    rotation_steering_column_to_body,
    rotation_steering_to_column,
)
from mobility_imu.simulation.checks import LONGEST_M
from mobility_imu.simulation.kinematics import felt_by_imu
from mobility_imu.simulation.scooter.course import Course, Ground, ground_line, level_at
from mobility_imu.simulation.scooter.driver import SPEED_LIMIT_MPS, Driver, ScooterMotion, drive
from mobility_imu.simulation.scooter.parts import (
    FAST_HZ,
    Layout,
    Reference,
    ScooterUnit,
    Shaking,
)
from mobility_imu.simulation.scooter.reference import read_reference
from mobility_imu.simulation.seeds import stream
from mobility_imu.simulation.sensor import LPMS_CU2, SensorModel, SensorOutput, measure

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, eq=False, repr=False)
class SimulatedRide(Result):
    """One run: what was recorded, what the reference measured, and the truth.

    Parameters
    ----------
    recording : Recording of ``lever`` and ``body``, on the IMUs' clock
    steering_rad, throttle_rad : (n,) arrays, rad, true angles at the recording's samples
    reference : (m, 2) array, rad, wire sensors' steering and throttle
    reference_time_s : (m,) array, s, on the second logger's clock
    pulses_s, reference_pulses_s : arrays, s, Hall pulses as each logger saw them, on its clock
    speed_mps : (n,) array, m/s, true speed at the recording's samples
    """

    recording: Recording
    steering_rad: FloatArray
    throttle_rad: FloatArray
    reference: FloatArray
    reference_time_s: FloatArray
    pulses_s: FloatArray
    reference_pulses_s: FloatArray
    speed_mps: FloatArray

    def __post_init__(self) -> None:
        """Check that what belongs together has one length."""
        expect("SimulatedRide.recording", self.recording, Recording)
        check_columns(self, "reference_time_s")
        check_columns(self, "pulses_s", "reference_pulses_s")
        count = (len(self.recording),)
        wires = (len(self.reference_time_s), 2)
        check_fields(self, steering_rad=count, throttle_rad=count, speed_mps=count, reference=wires)
        super().__post_init__()

    def truth(self) -> pd.DataFrame:
        """True angles in degrees and speed as a table."""
        import pandas as pd

        return pd.DataFrame(
            {
                "time_s": self.recording.time_s,
                "steering_deg": np.rad2deg(self.steering_rad),
                "throttle_deg": np.rad2deg(self.throttle_rad),
                "speed_mps": self.speed_mps,
            }
        )


def simulate_ride(
    course: Course,
    *,
    seed: int,
    geometry: ScooterGeometry = SUZUKI_ET4D,
    unit: ScooterUnit | None = None,
    driver: Driver | None = None,
    layout: Layout | None = None,
    ground: Ground | None = None,
    shaking: Shaking | None = None,
    reference: Reference | None = None,
    sensor: SensorModel = LPMS_CU2,
    sampling_rate_hz: float = 100.0,
) -> SimulatedRide:
    """Drive over a course once and record it.

    Parameters
    ----------
    course : Course
    seed : of the run; the same seed gives the same bytes
    geometry : ScooterGeometry
    unit, driver, layout, ground, shaking, reference, sensor : the parts of the model
    sampling_rate_hz : Hz, of IMUs and reference

    Returns
    -------
    SimulatedRide

    Raises
    ------
    InputError
        If a part is of another class, the course is too long, the sensor loses samples or jitters,
        the sampling rate is not positive or above FAST_HZ, or the seed is negative or not whole.
    """
    expect("course", course, Course)
    expect("geometry", geometry, ScooterGeometry)
    expect("sensor", sensor, SensorModel)
    sampling_rate_hz = as_number(sampling_rate_hz, "sampling_rate_hz")
    if course.length_m > LONGEST_M:
        raise InputError(f"course: {course.length_m:g} m in all, expected up to {LONGEST_M:g} m")
    if sensor.dropped_share > 0 or sensor.clock_jitter_s > 0:
        raise InputError(
            "sensor: lost samples and jitter differ between the two IMUs of a ride, whose samples "
            "are paired here; expected dropped_share = 0 and clock_jitter_s = 0"
        )
    unit = settings_or_default("unit", unit, ScooterUnit)
    driver = settings_or_default("driver", driver, Driver)
    layout = settings_or_default("layout", layout, Layout)
    ground = settings_or_default("ground", ground, Ground)
    shaking = settings_or_default("shaking", shaking, Shaking)
    reference = settings_or_default("reference", reference, Reference)
    rng = stream(seed, 13)
    motion = drive(course, driver, layout, geometry, rng)
    time_s = np.arange(0.0, motion.time_s[-1], 1 / FAST_HZ)
    fast = ScooterMotion(*(_refine(time_s, motion.time_s, part) for part in motion))
    pose = _pose(fast, course, layout, ground, rng)
    places = _places_in_body(fast, geometry, layout)
    on_tactile = level_at(course, fast.distance_m, "tactile", 0.2)
    outputs = {}
    for k, (name, tilt) in enumerate(unit.mountings.items()):
        place, turn = places[name]
        at = pose.origin + np.einsum("nij,nj->ni", pose.rotation, place)
        axes = pose.rotation @ turn @ Rotation.from_rotvec(tilt).as_matrix()
        acc, gyr = felt_by_imu(at, axes, 1 / FAST_HZ)
        acc = acc + _shake(fast.speed_mps, on_tactile, shaking, shaking.vibration_hz[k], rng)
        outputs[name] = measure(
            time_s,
            acc,
            gyr,
            sensor,
            sampling_rate_hz=sampling_rate_hz,
            seed=2 * seed + k,
            unit_seed=2 * unit.unit_seed + k,
            speed_share=fast.speed_mps / SPEED_LIMIT_MPS,
        )
    wires = read_reference(fast, reference, sampling_rate_hz, rng)
    return _as_ride(course, outputs, wires, time_s, fast)


def _as_ride(
    course: Course,
    outputs: dict[str, SensorOutput],
    wires: tuple[FloatArray, FloatArray, FloatArray, FloatArray],
    time_s: FloatArray,
    fast: ScooterMotion,
) -> SimulatedRide:
    """Readings of the IMUs and of the reference with the truth at the IMUs' samples."""
    body = outputs["body"]

    def at_samples(values: FloatArray) -> FloatArray:
        return np.interp(body.true_time_s, time_s, values)

    imus = {name: output.imu for name, output in outputs.items()}
    return SimulatedRide(
        Recording(body.time_s, imus, source=f"simulated ride, {course.name}"),
        at_samples(fast.steering_rad),
        at_samples(fast.throttle_rad),
        *wires,
        speed_mps=at_samples(fast.speed_mps),
    )


def _refine(time_s: FloatArray, coarse_s: FloatArray, values: FloatArray) -> FloatArray:
    """Cubic spline: its second derivative, which becomes acceleration, has no jumps."""
    return np.asarray(interpolate.CubicSpline(coarse_s, values, axis=0)(time_s))


class _Pose(NamedTuple):
    """The body in the world, at FAST_HZ."""

    rotation: FloatArray  # (n, 3, 3), body to world
    origin: FloatArray  # (n, 3), middle of the rear axle


def _pose(
    fast: ScooterMotion, course: Course, layout: Layout, ground: Ground, rng: np.random.Generator
) -> _Pose:
    s = fast.distance_m
    grade = level_at(course, s, "grade_rad", course.transition_m)
    bank = level_at(course, s, "bank_rad", course.transition_m)
    along = ground.grade_sd_rad * rng.standard_normal()
    across = ground.bank_sd_rad * rng.standard_normal()
    cos, sin = np.cos(fast.heading_rad), np.sin(fast.heading_rad)
    grade = grade + along * cos - across * sin
    bank = bank + across * cos + along * sin
    pitch_m = rng.uniform(*ground.tactile_pitch_m)
    lines = [
        ground_line(course, layout.wheelbase_m, ground, pitch_m, rng) for _ in range(2)
    ]  # left, right
    rear = np.stack([line(s) for line in lines])
    front = np.stack([line(s + layout.wheelbase_m) for line in lines])
    pitch = grade + (front.mean(axis=0) - rear.mean(axis=0)) / layout.wheelbase_m
    sides = (rear + front) / 2
    roll = bank + (sides[1] - sides[0]) / layout.tread_m
    turn = (
        elementary_rotation("z", fast.heading_rad)
        @ elementary_rotation("x", pitch)
        @ elementary_rotation("y", -roll)
    )
    step = np.diff(s, prepend=s[0])
    height = np.cumsum(np.sin(grade) * step) + rear.mean(axis=0)
    # Seen from above a slope is shorter than along it.
    shorter = np.cumsum(
        np.cos(grade)[:, None] * np.diff(fast.position_m, axis=0, prepend=0), axis=0
    )
    return _Pose(turn, np.column_stack([shorter, height]))


def _places_in_body(
    fast: ScooterMotion, geometry: ScooterGeometry, layout: Layout
) -> dict[str, tuple[FloatArray, FloatArray]]:
    """Place of each IMU in the body (n, 3), and its nominal axes to body (n, 3, 3)."""
    count = len(fast.time_s)
    body = np.broadcast_to(np.array(layout.body_imu_m), (count, 3))
    return {
        "lever": lever_pose(fast, geometry, layout),
        "body": (body, np.broadcast_to(np.eye(3), (count, 3, 3))),
    }


def lever_pose(
    fast: ScooterMotion, geometry: ScooterGeometry, layout: Layout
) -> tuple[FloatArray, FloatArray]:
    """Place of the lever's IMU in the body (n, 3), m, and its nominal axes to body (n, 3, 3).

    Parameters
    ----------
    fast : ScooterMotion
    geometry : ScooterGeometry
    layout : Layout
    """
    alpha, beta = geometry.steering_inclination_rad, geometry.lever_inclination_rad
    steering = rotation_steering_column_to_body(alpha) @ rotation_steering_to_column(
        fast.steering_rad
    )
    lever = rotation_lever_base_to_steering(alpha, beta) @ rotation_lever_to_lever_base(
        fast.throttle_rad
    )
    place = np.array(layout.steering_point_m) + np.einsum(
        "nij,nj->ni",
        steering,
        np.array(layout.lever_pivot_m) + lever @ np.array(layout.lever_imu_m),
    )
    return place, steering @ lever


def _shake(
    speed: FloatArray,
    on_tactile: FloatArray,
    shaking: Shaking,
    centre_hz: float,
    rng: np.random.Generator,
) -> FloatArray:
    count = len(speed)
    noise, blows = rng.standard_normal((count, 3)), rng.random(count)
    size = rng.exponential(1.0, count)
    direction = rng.standard_normal((count, 3))
    if shaking.vibration_mps2 == shaking.tactile_mps2 == shaking.spikes_per_s == 0:
        return np.zeros((count, 3))
    share = np.clip(speed / SPEED_LIMIT_MPS, 0, 1)[:, None]
    band = signal.butter(2, [0.8 * centre_hz, 1.25 * centre_hz], "band", fs=FAST_HZ, output="sos")
    ringing = signal.sosfilt(band, noise, axis=0)
    ringing /= ringing.std(axis=0)
    strength = shaking.vibration_mps2 + shaking.tactile_mps2 * on_tactile[:, None]
    struck = (blows < shaking.spikes_per_s / FAST_HZ) * size * shaking.spike_mps2
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    decay = np.exp(-1 / (0.01 * FAST_HZ))
    spikes = signal.lfilter([1], [1, -decay], struck[:, None] * direction, axis=0)
    return np.asarray(share * (strength * ringing + spikes))
