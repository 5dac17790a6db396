"""Rides of the driving test, and what estimators without gyroscopes make of them.

:mod:`mobility_imu.reproduction.scooter.driving` measures the errors of these and of others.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from mobility_imu.frames import STANDARD_GRAVITY_MPS2, FloatArray
from mobility_imu.reproduction.scooter.paper_method import PAPER_MEDIAN_WINDOW, paper_angles
from mobility_imu.scooter.geometry import SUZUKI_ET4D
from mobility_imu.scooter.pulses import moving_samples, reference_angles, synchronise
from mobility_imu.simulation.scooter import (
    COURSES,
    NO_SHAKING,
    PERFECT_REFERENCE,
    SMOOTH_GROUND,
    Ground,
    Layout,
    Reference,
    ScooterUnit,
    Shaking,
    SimulatedRide,
    draw_driver,
    draw_scooter,
    simulate_ride,
)
from mobility_imu.simulation.sensor import IDEAL, LPMS_CU2, SensorModel

DRIVERS = 4
RUNS = 3
LONGEST_GAP_S = 1.0
"""Seconds between two pulses (0.2 m apart) beyond which the scooter counts as standing; ours."""
LONGER_WINDOW = 101
"""Samples in the window of the fair baseline without gyroscopes (one second)."""
ANGLES = ("steering", "throttle")
PUBLISHED_LIMIT_DEG = {"steering": 10.0, "throttle": 5.0}

Corrections = tuple[FloatArray, FloatArray]
"""Rotations from the lever's and the body's IMU axes to {T} and {B}."""
Calibration = Callable[[ScooterUnit], Corrections]


def known_mounting(unit: ScooterUnit) -> Corrections:
    """True mounting of both IMUs, as a calibration without error would find it.

    Parameters
    ----------
    unit : ScooterUnit

    Returns
    -------
    lever, body : (3, 3) arrays, rotations from the IMU's axes to {T} and {B}
    """
    lever, body = (
        Rotation.from_rotvec(tilt).as_matrix() for tilt in (unit.lever_mounting, unit.body_mounting)
    )
    return lever, body


@dataclass(frozen=True)
class Conditions:
    """What the rides are made of, and the window they are smoothed with.

    Parameters
    ----------
    layout, ground, shaking, reference, sensor : see ``mobility_imu.simulation.scooter``
    mounting : whether the IMUs are mounted with an error
    median_window : samples, of the paper's filter
    """

    layout: Layout = field(default_factory=Layout)
    ground: Ground = field(default_factory=Ground)
    shaking: Shaking = field(default_factory=Shaking)
    reference: Reference = field(default_factory=Reference)
    sensor: SensorModel = LPMS_CU2
    mounting: bool = True
    median_window: int = PAPER_MEDIAN_WINDOW


def ablations() -> dict[str, Conditions]:
    """Full model, then the model with one effect switched off at a time, then with few left."""
    full = Conditions()
    nothing = Conditions(
        layout=Layout.together(),
        ground=SMOOTH_GROUND,
        shaking=NO_SHAKING,
        reference=PERFECT_REFERENCE,
        sensor=IDEAL,
        mounting=False,
        median_window=1,
    )
    return {
        "everything": full,
        "no lever arms": replace(full, layout=Layout.together()),
        "no roughness": replace(full, ground=replace(full.ground, roughness_m=0.0)),
        "no bumps on the paving": replace(full, ground=replace(full.ground, tactile_m=0.0)),
        "bumps in step with wheelbase": replace(
            full, ground=replace(full.ground, tactile_pitch_m=(0.06, 0.06))
        ),
        "no camber or grade": replace(
            full, ground=replace(full.ground, grade_sd_rad=0.0, bank_sd_rad=0.0)
        ),
        "no local vibration": replace(
            full, shaking=replace(full.shaking, vibration_mps2=0.0, tactile_mps2=0.0)
        ),
        "no spikes": replace(full, shaking=replace(full.shaking, spikes_per_s=0.0)),
        "no mounting error": replace(full, mounting=False),
        "ideal sensor": replace(full, sensor=IDEAL),
        "perfect reference": replace(full, reference=PERFECT_REFERENCE),
        "no median filter": replace(full, median_window=1),
        "lever arms only": replace(nothing, layout=full.layout, median_window=PAPER_MEDIAN_WINDOW),
        "mounting error only": replace(nothing, mounting=True, median_window=PAPER_MEDIAN_WINDOW),
        "nothing": nothing,
    }


class RideInputs(NamedTuple):
    """What an estimator may see of a ride."""

    lever_acc: FloatArray
    lever_gyr: FloatArray
    body_acc: FloatArray
    body_gyr: FloatArray
    rate_hz: float
    moving: NDArray[np.bool_]
    window: int
    calibrated: bool


Estimator = Callable[[RideInputs], FloatArray]


def _paper(ride: RideInputs, method: Any, window: int, edge: Any) -> FloatArray:
    angles = paper_angles(
        ride.lever_acc,
        ride.body_acc,
        ride.moving,
        SUZUKI_ET4D,
        method=method,
        window=window,
        edge=edge,
    )
    return np.column_stack([angles.steering_rad, angles.throttle_rad])


def _single(ride: RideInputs) -> FloatArray:
    return _paper(ride, "single", ride.window, "zero")


def _dual(ride: RideInputs) -> FloatArray:
    return _paper(ride, "dual", ride.window, "zero")


def _subtraction(ride: RideInputs) -> FloatArray:
    return _paper(ride, "subtraction", ride.window, "zero")


def _body_x_only(ride: RideInputs) -> FloatArray:
    # Eq. 6 with the body's x as measured, but C1 = g sin(alpha): the body's y and z do not enter.
    level = np.broadcast_to([0.0, 0.0, STANDARD_GRAVITY_MPS2], ride.body_acc.shape).copy()
    level[:, 0] = ride.body_acc[:, 0]
    return _paper(ride._replace(body_acc=level), "dual", ride.window, "zero")


def _longer_median(ride: RideInputs) -> FloatArray:
    # Zeros beyond the ends would spoil a whole second of each ride: not a fair baseline.
    return _paper(ride, "dual", LONGER_WINDOW, "nearest")


PAPER_ESTIMATORS: dict[str, Estimator] = {
    "single": _single,
    "dual": _dual,
    "subtraction": _subtraction,
    "body's x only": _body_x_only,
    "dual, longer median": _longer_median,
}
"""The paper's two; its reference 37's; a probe that shows why reference 37's does well; the paper's
dual estimate with a median over 101 samples."""


def make_ride(
    scooter: int,
    course: str,
    driver: int,
    run: int,
    conditions: Conditions,
    *,
    unit: ScooterUnit | None = None,
) -> SimulatedRide:
    """One run of the study. Scooter, course, driver and run make its seed, no two alike.

    Parameters
    ----------
    scooter : seed
    course : name in ``mobility_imu.simulation.scooter.COURSES``
    driver, run : numbers from 0 to 15
    conditions : Conditions
    unit : ScooterUnit; None draws that of the seed

    Returns
    -------
    SimulatedRide
    """
    place = list(COURSES).index(course)
    return simulate_ride(
        COURSES[course],
        seed=((scooter * len(COURSES) + place) * 16 + driver) * 16 + run,
        unit=draw_scooter(scooter) if unit is None else unit,
        driver=draw_driver(driver),
        layout=conditions.layout,
        ground=conditions.ground,
        shaking=conditions.shaking,
        reference=conditions.reference,
        sensor=conditions.sensor,
    )


def motion_and_truth(ride: SimulatedRide) -> tuple[NDArray[np.bool_], dict[str, FloatArray]]:
    """Samples in motion by the pulses, with wire sensors and truth at these samples.

    Parameters
    ----------
    ride : SimulatedRide

    Returns
    -------
    moving : (n,) bool array
    truth : "wire" and "truth" to (k, 2) arrays, rad, steering and throttle of the k samples
    """
    time_s = ride.recording.time_s
    moving = moving_samples(time_s, ride.pulses_s, longest_gap_s=LONGEST_GAP_S)
    offset = synchronise(ride.pulses_s, ride.reference_pulses_s)
    wire = reference_angles(time_s, ride.reference_time_s, ride.reference, offset.offset_s)
    true = np.column_stack([ride.steering_rad, ride.throttle_rad])
    return moving, {"wire": wire[moving], "truth": true[moving]}


def paper_estimates(
    ride: SimulatedRide,
    moving: NDArray[np.bool_],
    estimators: Sequence[str],
    *,
    window: int = PAPER_MEDIAN_WINDOW,
) -> dict[str, FloatArray]:
    """Run estimators without gyroscopes on one ride, whose mounting is not known.

    Parameters
    ----------
    ride : SimulatedRide
    moving : (n,) bool array, see :func:`motion_and_truth`
    estimators : names from :data:`PAPER_ESTIMATORS`
    window : samples of the paper's median

    Returns
    -------
    dict of name to (k, 2) array, rad, of the k samples in motion
    """
    inputs = inputs_of(ride, moving, None, window)
    return {name: PAPER_ESTIMATORS[name](inputs) for name in estimators}


def inputs_of(
    ride: SimulatedRide,
    moving: NDArray[np.bool_],
    corrections: Corrections | None,
    window: int,
) -> RideInputs:
    """What an estimator may see of a ride.

    Parameters
    ----------
    ride : SimulatedRide
    moving : (n,) bool array
    corrections : rotations of both IMUs to {T} and {B}; None for none
    window : samples of the paper's median

    Returns
    -------
    RideInputs
    """
    recording = ride.recording
    lever, body = (recording.sensor(name).acc_mps2 for name in ("lever", "body"))
    lever_gyr, body_gyr = (recording.gyroscope(name) for name in ("lever", "body"))
    if corrections is not None:
        to_lever, to_body = (turn.T for turn in corrections)
        lever, lever_gyr = lever @ to_lever, lever_gyr @ to_lever
        body, body_gyr = body @ to_body, body_gyr @ to_body
    rate_hz = recording.sampling_rate_hz
    calibrated = corrections is not None
    return RideInputs(lever, lever_gyr, body, body_gyr, rate_hz, moving, window, calibrated)
