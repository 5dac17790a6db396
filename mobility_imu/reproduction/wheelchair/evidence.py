"""Numbers behind the findings W1 to W13 about WheelMove-ID (v0)."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from mobility_imu.frames import FloatArray
from mobility_imu.reproduction.findings import Evidence, quoted
from mobility_imu.reproduction.wheelchair.printed import (
    SignChoice,
    gyroscope_outward,
    sign_choices,
    velocity_printed,
    yaw_rate_printed,
)
from mobility_imu.reproduction.wheelchair.sample import (
    SIGNALS,
    letter_combinations,
    open_combinations,
)
from mobility_imu.wheelchair.calibration import (
    Form,
    alignment_matrix,
    frame_alignment_angles,
    wheel_alignment_angles,
)
from mobility_imu.wheelchair.geometry import DOCUMENT_TO_CHAIR, SAMPLE_CHAIR, SIDES, side_sign
from mobility_imu.wheelchair.settings import TaskSettings
from mobility_imu.wheelchair.tasks import (
    Edge,
    Symbols,
    Task,
    curvature_radius,
    find_pattern,
    reduce_variability,
    task_codes,
    task_steps,
)
from mobility_imu.wheelchair.velocity import linear_velocity, wheel_spin_rate, wheel_yaw_rate

Evidences = tuple[Evidence, ...]


def resting_acceleration() -> Evidences:
    """W1: where (1.12) with atan2 puts the upward axis, for both kinds of sensor."""
    force = np.array([0.3, -0.2, 9.8])  # a sensor that lies nearly level, z up

    def up(reading: FloatArray) -> float:
        # (1.12) turns the aligned z against the reading; atan2 follows its sign.
        axis = alignment_matrix(*frame_alignment_angles(-reading))[:, 2]
        return float(axis @ force / np.linalg.norm(force))

    return (
        Evidence(
            what="component of the aligned z axis along the true upward axis, (1.12) with atan2",
            first_from="sensor that reports specific force (+g at rest)",
            first=up(force),
            second_from="sensor that reports gravity (−g at rest)",
            second=up(-force),
            tolerance=0.01,
        ),
    )


def facing_of_the_sensor() -> Evidences:
    """W2: axle by the printed inverse tangents against Figure 1's, for both facings."""
    rng = np.random.default_rng(1)
    tilts = Rotation.from_rotvec(rng.normal(0, 0.3, (1000, 3))).as_matrix()

    def agreement(facing: int, form: Form = "printed") -> float:
        worst = 1.0
        for side in SIDES:
            # The sensor's z is the outward axle, or the inward one, but for a small tilt.
            rate_sign = side_sign(side) * facing  # of the gyroscope's z in a forward push
            for tilt in tilts:
                out = facing * tilt[:, 2]  # Figure 1's axle in the sensor's axes
                angles = wheel_alignment_angles(rate_sign * tilt[:, 2], form=form)
                worst = min(worst, float(alignment_matrix(*angles)[:, 2] @ out))
        return worst

    return (
        Evidence(
            what="component of the aligned z axis along Figure 1's outward axle, smallest of 1000 "
            "tilted sensors on each side",
            first_from="the document's arctangents, sensors facing inward",
            first=agreement(-1),
            second_from="the document's arctangents, sensors facing outward",
            second=agreement(1),
            truth=1.0,
            tolerance=1e-9,
        ),
        Evidence(
            what="the same component, sensors facing outward",
            first_from="atan2, which follows the sign of the push (right wheel)",
            first=agreement(1, "corrected"),
            second_from="arctangents as in the document",
            second=agreement(1),
            truth=1.0,
            tolerance=1e-9,
        ),
    )


def _signed(yaw_rate_radps: float) -> tuple[float, float]:
    """Speed (m/s) and yaw rate (rad/s) with the yaw rate in place of the root, turning in place.

    Wheels with axles positive rolling forward; Figure 1's outward axles change signs only.
    """
    chair = SAMPLE_CHAIR
    left, right = (
        wheel_spin_rate(
            side_sign(side) * gyroscope_outward(0.0, yaw_rate_radps, chair, side)[0],
            yaw_rate_radps,
            chair.camber_rad,
            side=side,
        )
        for side in SIDES
    )
    speed = float(linear_velocity(left, right, chair))
    return speed, float(wheel_yaw_rate(left, right, chair, distance_m=chair.track_m))


def camber_term() -> Evidences:
    """W3: speed and yaw rate of the wheels, printed root and signed term, both turns."""
    choices = sign_choices(SAMPLE_CHAIR)
    tool = next(c for c in choices if (c.sign_left, c.sign_right) == (1, 1))  # with the centres

    def worst(choice: SignChoice) -> float:
        return max(
            abs(choice.yaw_left - 1),
            abs(choice.yaw_right - 1),
            abs(choice.velocity_left),
            abs(choice.velocity_right),
        )

    signed = {turn: _signed(turn) for turn in (1.0, -1.0)}
    return (
        *(
            Evidence(
                what=f"the wheels' yaw rate divided by the true one, {turn} turn, sample's chair",
                first_from="the document's root, the public tool's signs and distance",
                first=gain,
                second_from="yaw rate in place of the root",
                second=signed[yaw][1] / yaw,
                truth=1.0,
                tolerance=1e-6,
            )
            for turn, yaw, gain in (
                ("left", 1.0, tool.yaw_left),
                ("right", -1.0, tool.yaw_right),
            )
        ),
        Evidence(
            what="largest error of speed (m/s) or yaw rate (rad/s), left and right turn at 1 rad/s",
            first_from="best of the eight combinations: four choices of fixed signs, two distances",
            first=min(worst(choice) for choice in choices),
            second_from="the sign that fits side and turn",
            second=max(max(abs(v), abs(w - yaw)) for yaw, (v, w) in signed.items()),
            truth=0.0,
            tolerance=1e-6,
        ),
    )


def _printed(speed: float, yaw: float, facing: int) -> tuple[float, float]:
    """Speed by (1.17) and yaw rate by (1.18) as printed, from uncorrected axle rates."""
    chair = SAMPLE_CHAIR
    left, right = (facing * gyroscope_outward(speed, yaw, chair, side)[0] for side in SIDES)
    turned = yaw_rate_printed(left, right, chair, distance_m=chair.wheel_centre_distance_m)
    return float(velocity_printed(left, right, chair)), float(turned)


def signs_of_speed_and_turn() -> Evidences:
    """W4: (1.17) and (1.18) as printed, axles outward and inward."""
    return (
        Evidence(
            what="yaw rate in a left turn of 1 rad/s",
            first_from="(1.18) with Figure 1's outward axles",
            first=_printed(0.0, 1.0, 1)[1],
            second_from="arrow of the yaw rate in Figure 1",
            second=1.0,
            tolerance=0.01,
            unit="rad/s",
        ),
        Evidence(
            what="speed of a chair that rolls straight on at 1 m/s, by (1.17)",
            first_from="axles inward, as the sensors of the public sample",
            first=_printed(1.0, 0.0, -1)[0],
            second_from="axles outward, as Figure 1 draws them",
            second=_printed(1.0, 0.0, 1)[0],
            truth=1.0,
            tolerance=1e-9,
            unit="m/s",
        ),
    )


def unit_in_the_radius() -> Evidences:
    """W5: radius of a circle run at 1 m/s and 60 °/s."""
    circumference = 1.0 * 360 / 60  # way travelled in a full turn
    return (
        Evidence(
            what="radius at 1 m/s and 60 °/s",
            first_from="(2.1) with the yaw rate in °/s, as listed",
            first=float(curvature_radius(1.0, 60.0)),
            second_from="(2.1) with the yaw rate in rad/s",
            second=float(curvature_radius(1.0, np.deg2rad(60.0))),
            truth=circumference / (2 * np.pi),
            tolerance=1e-9,
            unit="m",
        ),
    )


def letters_without_a_task() -> Evidences:
    """W6: combinations of letters without a task."""
    rocking = np.tile(np.r_[np.full(5, 0.9), np.full(5, -0.95)], 40)
    steps = task_steps(rocking, np.zeros(len(rocking)), 100)
    middle = slice(100, 300)
    by_rule = find_pattern(steps.symbols)[middle]
    return (
        Evidence(
            what="combinations of letters without a task, of 36",
            first_from="Table 2 as in the document",
            first=float(open_combinations()),
            second_from="the public tool's rule and ours",
            second=float(np.count_nonzero(_codes_of_all_combinations() == 0)),
            tolerance=0.5,
        ),
        Evidence(
            what="samples, of 200, while a chair rocks back and forth (mean speed −0.025 m/s)",
            first_from="called forward by the public tool's rule and ours",
            first=float((by_rule == Task.FORWARD).sum()),
            second_from="with the letter c for the speed, as Table 2 requires for forward",
            second=float((steps.symbols.velocity[middle] == "abc".index("c")).sum()),
            tolerance=0.5,
        ),
    )


def _codes_of_all_combinations() -> FloatArray:
    rows = [["abc".index(row[signal]) for signal in SIGNALS] for row in letter_combinations()]
    return np.asarray(find_pattern(Symbols(*np.array(rows, np.int8).T)))


def isolated_task() -> Evidences:
    """W7: what is left of 2 s of turning between two straights."""
    trial = np.repeat(np.array([Task.FORWARD, Task.WIDE, Task.FORWARD], np.int8), 200)

    def left(segment: int) -> float:
        return float((reduce_variability(trial, segment=segment) == Task.WIDE).sum())

    return (
        Evidence(
            what="samples of a wide turn between straights that remain after step 5, of 200",
            first_from='"any isolated task", without a length',
            first=left(len(trial)),
            second_from='"a single segment", the document\'s example (0.25 s)',
            second=left(25),
            tolerance=0.5,
        ),
    )


def vertical_axis() -> Evidences:
    """W8: how far the axis called Z points upward, by Figure 1 and by section 1.1.2."""
    upward = np.array([0.0, 0.0, 1.0])  # of the chair's frame in this package
    return (
        Evidence(
            what="component along the vertical of the chair's axis called Z",
            first_from="Figure 1 (Y up, Z to the right)",
            first=float(upward @ DOCUMENT_TO_CHAIR[:, 2]),
            second_from='section 1.1.2 ("oriented upward")',
            second=float(upward @ alignment_matrix(*frame_alignment_angles(upward))[:, 2]),
            tolerance=0.01,
        ),
    )


def distance_in_the_yaw_rate() -> Evidences:
    """W9: yaw rate by (1.18) from rightly corrected spins, two distances."""
    chair = SAMPLE_CHAIR
    by_contacts = _signed(1.0)[1]
    return (
        Evidence(
            what="yaw rate by (1.18) divided by the true one, spins corrected for camber",
            first_from="d between the wheels' centres",
            first=by_contacts * chair.track_m / chair.wheel_centre_distance_m,
            second_from="d between the contacts",
            second=by_contacts,
            truth=1.0,
            tolerance=1e-9,
        ),
    )


def exactly_at_the_limit() -> Evidences:
    """W10: turning frames of a trial at exactly 40 °/s."""
    limit = quoted("W10", r"< ([0-9]+)\$")
    yaw = np.full(200, np.deg2rad(limit))

    def turning(threshold_degps: float) -> float:
        settings = TaskSettings(yaw_rate_degps=threshold_degps)
        codes = task_codes(np.full(200, 1.0), yaw, 100, settings)
        return float(np.isin(codes, [Task.PIVOT, Task.TIGHT, Task.WIDE]).sum())

    return (
        Evidence(
            what="samples of 200 that count as turning at exactly 40 °/s",
            first_from="limit gets the letter c, turning (the public tool)",
            first=turning(limit * (1 - 1e-12)),
            second_from="limit gets the letter b",
            second=turning(limit * (1 + 1e-12)),
            tolerance=0.5,
        ),
    )


def year_of_a_reference() -> Evidences:
    """W11: year of one reference in the text and in the list."""
    return (
        Evidence(
            what="year of the article by Poulet and others",
            first_from="section 1.2",
            first=quoted("W11", r"Poulet et al\. ([0-9]+)"),
            second_from="list of references",
            second=quoted("W11", r"Sauret\.\*\* ([0-9]+)"),
            tolerance=0.5,
        ),
    )


def _start_and_stop(ramp_s: float) -> tuple[FloatArray, FloatArray]:
    """A chair that starts and stops: velocity in m/s, yaw rate in rad/s, at 100 Hz."""
    ramp = np.linspace(0.0, 1.0, round(100 * ramp_s))
    still = np.zeros(100)
    speed = np.concatenate([still, ramp, np.ones(200), ramp[::-1], still])
    return speed, np.zeros(len(speed))


def reach_of_step_4() -> Evidences:
    """W12: frames of forward propulsion, reach of step 4 as in the tool and half of it."""

    def forward(look_s: float, ramp_s: float) -> float:
        settings = TaskSettings(look_s=look_s)
        codes = task_codes(*_start_and_stop(ramp_s), 100, settings)
        return float((codes == Task.FORWARD).sum())

    half, tool = 0.15, TaskSettings().look_s
    return (
        Evidence(
            what="samples called forward, drive with a start and a stop of 0.5 s each",
            first_from="reach of 0.15 s",
            first=forward(half, 0.5),
            second_from="reach of 0.30 s, the public tool's at 100 Hz",
            second=forward(tool, 0.5),
            tolerance=0.5,
        ),
        Evidence(
            what="samples called forward, drive with a start and a stop of 1.5 s each",
            first_from="reach of 0.15 s",
            first=forward(half, 1.5),
            second_from="reach of 0.30 s",
            second=forward(tool, 1.5),
            tolerance=0.5,
            relation="together",
        ),
    )


def first_frames() -> Evidences:
    """W13: frames at rest at the beginning of a trial that begins in motion."""
    speed, yaw = np.full(300, 1.0), np.zeros(300)

    def still(edge: Edge) -> float:
        return float((task_codes(speed, yaw, 100, edge=edge) == Task.STATIC).sum())

    return (
        Evidence(
            what="samples that are called static, in a trial at a constant 1 m/s",
            first_from="the public tool's rule",
            first=still("tool"),
            second_from="only segments that contain the sample vote",
            second=still("covering"),
            truth=0.0,
            tolerance=0.5,
        ),
    )
