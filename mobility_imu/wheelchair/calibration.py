"""Realignment of wheel and frame IMUs from a static and a straight-line trial (section 1.1).

The document solves for two angles with ``atan``; that keeps the aligned z axis in the IMU's own
z hemisphere. With sensors that face outward on both wheels, as its Figure 1 draws them, the aligned
axes point outward too, and (1.17) subtracts the wheels accordingly. Sensors that face inward come
out the other way. The forms here use ``atan2`` and take the direction from the trials: they hold
for any mounting, and make a forward roll positive on both wheels.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy import ndimage

from mobility_imu.arguments import expect
from mobility_imu.errors import InputError
from mobility_imu.fields import check_fields
from mobility_imu.frames import FloatArray, as_rotation, as_vectors, one_of
from mobility_imu.offsets import (
    GyroscopeOffset,
    merge_offsets,
    offset_warnings,
    rest_offsets,
    without_offsets,
)
from mobility_imu.recording import Recording
from mobility_imu.results import Result
from mobility_imu.rotations import elementary_rotation
from mobility_imu.wheelchair.geometry import SIDES, Side, WheelPair
from mobility_imu.wheelchair.mount import WheelchairMount
from mobility_imu.wheelchair.remarks import other_names
from mobility_imu.wheelchair.saturation import saturated_gyroscopes, saturation_warnings
from mobility_imu.wheelchair.series import as_offsets

__all__ = [
    "AlignmentAngles",
    "Form",
    "WheelchairCalibration",
    "alignment_matrix",
    "axle_direction",
    "calibrate_mount",
    "frame_alignment_angles",
    "realign",
    "wheel_alignment_angles",
]

Form = Literal["corrected", "printed"]

# A chair that stands still shows sensor noise only: a few 0.01 rad/s.
LARGEST_STILL_RATE_RADPS = 0.1
# Gravity turns so far with a wheel that rolls, or a frame that is tipped, by 6 deg. Of six real
# chairs at rest, wheels have up to 0.8 and frames up to 0.5. Means leave out knocks and shaking.
LARGEST_STILL_CHANGE_MPS2, STILL_SMOOTHING_S = 1.0, 0.25
# Half a turn of the wheel is one push; less than that does not show its axle.
SMALLEST_TRAVEL_RAD = np.pi
# In a straight line a wheel's gyroscope sees its axle only; turning shows up across it.
LARGEST_OFF_AXLE_SHARE = 0.15
LARGEST_HEADING_CHANGE_RAD = np.deg2rad(45)
# A trial whose straightest part is less of its way was no straight line with a bend.
SMALLEST_PART_OF_THE_WAY = 0.4
# Who goes forward and comes back by hand ends within a few percent of the way from the start.
SMALLEST_WAY_LEFT = 0.1
ACCELERATION_SMOOTHING_S = 0.15
# 0.15 m/s for a usual wheel; with less, the forward direction would be read from noise.
SMALLEST_RATE_CHANGE_RADPS = 0.5


class AlignmentAngles(NamedTuple):
    """Two successive turns that bring an IMU's axes to the aligned ones, rad."""

    about_y_rad: float
    about_x_rad: float


def alignment_matrix(about_y_rad: float, about_x_rad: float) -> FloatArray:
    """Rotation from the aligned frame to the IMU's axes (eqs 1.3-1.5 and 1.11).

    Parameters
    ----------
    about_y_rad : gamma (wheel) or sigma (frame), rad, about the IMU's y
    about_x_rad : epsilon (wheel) or delta (frame), rad, about the new x

    Returns
    -------
    (3, 3) array: Ry(about_y) Rx(about_x)
    """
    return elementary_rotation("y", about_y_rad) @ elementary_rotation("x", about_x_rad)


def realign(vectors_imu: ArrayLike, rotation_aligned_to_imu: ArrayLike) -> FloatArray:
    """Re-express measurements in the aligned frame (eqs 1.1, 1.2 and 1.10).

    Parameters
    ----------
    vectors_imu : (n, 3) array in the IMU's axes
    rotation_aligned_to_imu : (3, 3) array from :func:`alignment_matrix`

    Returns
    -------
    (n, 3) array in the aligned axes
    """
    rotation = as_rotation(rotation_aligned_to_imu, "rotation_aligned_to_imu")
    return as_vectors(vectors_imu, "vectors_imu") @ rotation


def wheel_alignment_angles(
    rate_imu_radps: ArrayLike, *, form: Form = "corrected"
) -> AlignmentAngles:
    """Angles gamma and epsilon that turn z onto a wheel's axle (eqs 1.6-1.9).

    Parameters
    ----------
    rate_imu_radps : (3,) array, angular rate of the wheel rolling forward, IMU axes; only its
        direction matters
    form : "printed" uses ``atan`` as the document does: the aligned z then lies in the IMU's z
        hemisphere, whatever the direction of the roll (on sensors that face outward it is the
        outward axle of the document's Figure 1), and z = 0 divides by zero

    Returns
    -------
    AlignmentAngles

    Raises
    ------
    InputError
        If the vector is zero; "printed": if its z component is.

    Examples
    --------
    A right wheel whose IMU faces outward turns about -z when it rolls forward. The printed form
    gives the outward axle, the other form the one about which rolling forward is positive.

    >>> for form in ("corrected", "printed"):
    ...     axle = alignment_matrix(*wheel_alignment_angles([0, 0, -5], form=form))[:, 2]
    ...     print(form, axle.round(6) + 0.0)
    corrected [ 0.  0. -1.]
    printed [0. 0. 1.]
    """
    return _angles_to_z(rate_imu_radps, "rate_imu_radps", form)


def frame_alignment_angles(acc_imu_mps2: ArrayLike, *, form: Form = "corrected") -> AlignmentAngles:
    """Angles sigma and delta that turn z upward (eqs 1.12-1.15).

    The document writes the resting acceleration as -z (1.12), which fits a sensor that reports
    gravity. An accelerometer reports specific force, +g upward. With ``atan`` the sign drops out,
    with ``atan2`` it does not: +z is used here.

    Parameters
    ----------
    acc_imu_mps2 : (3,) array, mean specific force at rest, IMU axes
    form : as in :func:`wheel_alignment_angles`

    Returns
    -------
    AlignmentAngles
    """
    return _angles_to_z(acc_imu_mps2, "acc_imu_mps2", form)


def _of_unit_size(vectors: FloatArray) -> FloatArray:
    """Vectors over the power of two above their largest component: no square overflows.

    What depends on directions and ratios alone keeps every digit.
    """
    largest = np.abs(vectors).max(initial=0.0)
    return np.asarray(np.ldexp(vectors, -np.frexp(largest)[1])) if largest > 0 else vectors


def _angles_to_z(vector: ArrayLike, name: str, form: Form) -> AlignmentAngles:
    one_of("form", form, ("corrected", "printed"))
    x, y, z = _of_unit_size(as_vectors(vector, name, ndim=1))
    if not x * x + y * y + z * z > 0:
        raise InputError(f"{name}: a zero vector has no direction")
    if form == "corrected":
        return AlignmentAngles(float(np.arctan2(x, z)), float(np.arctan2(-y, np.hypot(x, z))))
    if z == 0:
        raise InputError(f"{name}: z = 0, the printed equations divide by it")
    about_y = np.arctan(x / z)
    return AlignmentAngles(float(about_y), float(np.arctan(-y * np.cos(about_y) / z)))


@dataclass(frozen=True, eq=False, repr=False)
class WheelchairCalibration(Result):
    """Mount of the three IMUs, and how well the trials showed it.

    Parameters
    ----------
    mount : WheelchairMount
    off_axle_share : (left, right), root mean square of the rate across the axle over that along
        it in the straight line; near 0 when the chair went straight, NaN without a sensor
    offsets : sensor to :class:`~mobility_imu.offsets.GyroscopeOffset`, as found at rest and taken
        off; for :func:`~mobility_imu.wheelchair.velocity.estimate_velocity`, whose recording may
        have no rest
    warnings : sentences on what is missing; empty if nothing is
    """

    mount: WheelchairMount
    off_axle_share: WheelPair
    offsets: dict[str, GyroscopeOffset] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Check every field."""
        check_fields(self, mount=WheelchairMount, off_axle_share=[float, 2])
        object.__setattr__(self, "off_axle_share", WheelPair(*self.off_axle_share))
        object.__setattr__(self, "offsets", as_offsets(self.offsets))
        super().__post_init__()


def axle_direction(gyr_radps: ArrayLike) -> tuple[FloatArray, float]:
    """Direction of a wheel's axle in IMU axes, forward spin positive, from a straight line.

    The direction along which the rate's mean square is largest: unlike a mean of unit vectors
    it gives no weight to samples at rest. The sign makes the whole turn of the trial positive.

    Parameters
    ----------
    gyr_radps : (n, 3) array, rad/s, chair moving forward in total

    Returns
    -------
    direction : (3,) unit array
    off_axle_share : root mean square across over along

    Raises
    ------
    InputError
        If the wheel does not turn, or turns back as far as forward.
    """
    gyr = _of_unit_size(as_vectors(gyr_radps, "gyr_radps", ndim=2, finite=True))
    squares, directions = np.linalg.eigh(gyr.T @ gyr)
    turned = (gyr @ directions[:, -1]).sum()
    if not squares[2] > 0 or turned == 0:
        raise InputError(
            "gyr_radps: the wheel turns by 0 rad in all, expected a chair that moves forward"
        )
    off_axle = float(np.sqrt(max(squares[0] + squares[1], 0.0) / squares[2]))
    return directions[:, -1] * np.sign(turned), off_axle


def calibrate_mount(
    static: Recording, straight: Recording, *, take_off_offsets: bool = True
) -> WheelchairCalibration:
    """Find how the IMUs are mounted, from the two trials of the document (section 1.1).

    Up is the frame IMU's mean acceleration at rest, the axles come from the straight line, and
    forward is the horizontal direction in which the frame accelerates together with the wheels.
    The gyroscopes' offsets are found where the chair rests in either trial, and taken off.

    Parameters
    ----------
    static : the chair standing still
    straight : the chair pushed straight forward, some metres, from rest or rolling; a wheel whose
        sensor is missing gets no rotation, with a warning
    take_off_offsets : False uses the rates as they are, as the document does

    Returns
    -------
    WheelchairCalibration

    Raises
    ------
    InputError
        If the frame turns or all wheels roll in the static trial, or the straight-line trial is too
        short or turns; the message gives the number that shows it.
    """
    expect("static", static, Recording)
    expect("straight", straight, Recording)
    one_of("take_off_offsets", take_off_offsets, (True, False))
    at_rest = _offsets(static) if take_off_offsets else {}
    up = _up(without_offsets(static, at_rest))
    moved = _moved_at_rest(without_offsets(static, _offsets(static)))
    present = [side for side in SIDES if f"{side}_wheel" in straight.sensors]
    offsets = merge_offsets(_offsets(straight), at_rest) if take_off_offsets else {}
    warnings = (
        offset_warnings(straight, offsets, ["frame", *(f"{side}_wheel" for side in present)])
        if take_off_offsets
        else ()
    )
    wheels = [
        f"{side}_wheel"
        for side in present
        if straight.sensors[f"{side}_wheel"].gyr_radps is not None
    ]
    warnings += saturation_warnings(straight, saturated_gyroscopes(straight, wheels))
    whole = without_offsets(straight, offsets)
    straight, refusal, part_used = _straightest(whole, up, present or SIDES)
    axles = {side: _axle(straight, side, None if refusal else up) for side in present or SIDES}
    if refusal:
        raise InputError(refusal)
    rates = [straight.gyroscope(f"{side}_wheel") @ axle for side, (axle, _) in axles.items()]
    forward = _forward(straight, up, np.mean(rates, axis=0), turns=bool(part_used))
    rotations = {
        side: alignment_matrix(*wheel_alignment_angles(axle)).T for side, (axle, _) in axles.items()
    }
    return WheelchairCalibration(
        mount=WheelchairMount(
            rotation_left_imu_to_wheel=rotations.get("left"),
            rotation_right_imu_to_wheel=rotations.get("right"),
            rotation_frame_imu_to_chair=np.array([forward, np.cross(up, forward), up]),
        ),
        off_axle_share=WheelPair(
            *(axles[side][1] if side in axles else float("nan") for side in SIDES)
        ),
        offsets=offsets,
        warnings=(
            *(
                f"{straight.source}: no sensor on the {side} wheel; the mount holds for the other "
                f"only{other_names(straight)}"
                for side in SIDES
                if side not in axles
            ),
            *part_used,
            *moved,
            *warnings,
        ),
    )


def _offsets(trial: Recording) -> dict[str, GyroscopeOffset]:
    """Offsets of the chair's gyroscopes that the trial has, by its rests."""
    names = [
        name
        for name in ("frame", *(f"{side}_wheel" for side in SIDES))
        if name in trial.sensors and trial.sensors[name].gyr_radps is not None
    ]
    return rest_offsets(trial, names)


def _axle(straight: Recording, side: Side, up: FloatArray | None) -> tuple[FloatArray, float]:
    """Direction and off-axle fraction of one wheel, from a trial that shows them.

    With ``up``, what the frame turns by is no sign of a loose sensor: rough ground wobbles.
    """
    gyr = straight.gyroscope(f"{side}_wheel")
    travel = _travel(straight, side)[-1]
    if travel < SMALLEST_TRAVEL_RAD:
        raise InputError(
            f"{straight.source}: the {side} wheel turns {travel:.2f} rad, expected more than "
            f"{SMALLEST_TRAVEL_RAD:.1f} rad in the straight-line trial"
        )
    try:
        direction, share = axle_direction(gyr)
    except InputError as error:
        raise InputError(f"{straight.source}: {side} wheel: {error}") from None
    spin = gyr @ direction
    if spin.sum() < SMALLEST_WAY_LEFT * np.abs(spin).sum():
        raise InputError(
            f"{straight.source}: the {side} wheel turns {travel / 2:.1f} rad one way and as far "
            "back, so that forward is not known; cut the straight-line trial to its way forward"
        )
    unexplained = share
    if up is not None:
        along = float(np.sqrt(np.mean(np.square(gyr @ direction))))
        yaw = float(np.sqrt(np.mean(np.square(straight.gyroscope("frame") @ up))))
        unexplained = float(np.sqrt(max(share**2 - (yaw / along) ** 2, 0.0)))
    if unexplained > LARGEST_OFF_AXLE_SHARE:
        raise InputError(
            f"{straight.source}: {share:.0%} of the {side} wheel's rate lies across its axle, "
            f"expected less than {LARGEST_OFF_AXLE_SHARE:.0%}: the chair turned, or the sensor "
            "is loose"
        )
    return direction, share


def _travel(straight: Recording, side: Side) -> FloatArray:
    """Angle in rad that a wheel has turned by, either way."""
    rate = np.linalg.norm(straight.gyroscope(f"{side}_wheel"), axis=1)
    return np.asarray(np.cumsum(rate) / straight.sampling_rate_hz)


def _straightest(
    straight: Recording, up: FloatArray, sides: Sequence[Side]
) -> tuple[Recording, str, tuple[str, ...]]:
    """Part of the trial with the longest way on one heading.

    With it, why the trial cannot be used, empty if it can; and a sentence if a part is used.
    """
    heading = np.cumsum(straight.gyroscope("frame") @ up) / straight.sampling_rate_hz
    change, limit = float(np.ptp(heading)), LARGEST_HEADING_CHANGE_RAD
    if change <= limit:
        return straight, "", ()
    refusal = (
        f"{straight.source}: the heading changes by {np.rad2deg(change):.0f} deg, expected less "
        f"than {np.rad2deg(limit):.0f} deg in the straight-line trial"
    )
    way = np.min([_travel(straight, side) for side in sides], axis=0)
    first, last = _longest_way(heading, way, limit)
    speed = np.mean([np.linalg.norm(straight.gyroscope(f"{s}_wheel"), axis=1) for s in sides], 0)
    used = slice(first, last)
    if (
        way[last] - way[first] < max(SMALLEST_TRAVEL_RAD, SMALLEST_PART_OF_THE_WAY * way[-1])
        or np.ptp(_smooth(speed, straight.sampling_rate_hz)[used]) < SMALLEST_RATE_CHANGE_RADPS
    ):
        return straight, refusal, ()
    begin, end = straight.time_s[first], straight.time_s[last]
    note = f"{refusal}; only its straightest part is used, {begin:.1f} to {end:.1f} s"
    return straight.trim(begin, end), "", (note,)


def _longest_way(heading: FloatArray, way: FloatArray, limit: float) -> tuple[int, int]:
    """First and last sample between which the heading keeps within a limit and the way is longest.

    Two queues hold the samples that can still be the highest and the lowest of what is looked at.
    """
    best, start = (0, 0), 0
    high: deque[int] = deque()
    low: deque[int] = deque()
    for stop, value in enumerate(heading):
        while high and heading[high[-1]] <= value:
            high.pop()
        while low and heading[low[-1]] >= value:
            low.pop()
        high.append(stop)
        low.append(stop)
        while heading[high[0]] - heading[low[0]] > limit:
            start += 1
            for queue in (high, low):
                if queue[0] < start:
                    queue.popleft()
        if way[stop] - way[start] > way[best[1]] - way[best[0]]:
            best = (start, stop)
    return best


def _up(static: Recording) -> FloatArray:
    rate = float(np.sqrt(np.mean(np.square(static.gyroscope("frame"))) * 3))
    if rate > LARGEST_STILL_RATE_RADPS:
        raise InputError(
            f"{static.source}: the frame turns at {rate:.2f} rad/s (root mean square), expected "
            f"less than {LARGEST_STILL_RATE_RADPS} rad/s in the static trial"
        )
    resting = static.sensor("frame").acc_mps2.mean(axis=0)
    return alignment_matrix(*frame_alignment_angles(resting))[:, 2]


def _moved_at_rest(static: Recording) -> tuple[str, ...]:
    """Sentences on a static trial in which one wheel turns, or the frame is moved without a turn.

    An offset reads like a turn, but gravity stays. A chair that rolls speeds up, and its mean
    acceleration is not up: then all wheels turn, which is refused.
    """
    rates, changes = {}, {}
    fs = static.sampling_rate_hz
    for name in ("frame", *(f"{side}_wheel" for side in SIDES)):
        imu = static.sensors.get(name)
        if imu is None or imu.gyr_radps is None:
            continue
        force, rate = (
            ndimage.uniform_filter1d(values, max(1, round(STILL_SMOOTHING_S * fs)), axis=0)
            for values in (imu.acc_mps2, imu.gyr_radps)
        )
        rates[name] = float(np.sqrt(np.mean(np.square(rate)) * 3))
        changes[name] = float(np.ptp(force, axis=0).max())
    wheels = [name for name in rates if name != "frame"]
    turning = [
        name
        for name in wheels
        if rates[name] > LARGEST_STILL_RATE_RADPS and changes[name] > LARGEST_STILL_CHANGE_MPS2
    ]
    sentences = [
        f"{static.source}: the {name.replace('_', ' ')} turns at {rates[name]:.2f} rad/s (root "
        f"mean square), expected less than {LARGEST_STILL_RATE_RADPS} rad/s in the static trial"
        for name in turning
    ]
    cut = "cut the trial to the seconds in which the chair stands"
    if turning and turning == wheels:
        raise InputError(f"{sentences[0]}: the chair rolls; {cut}")
    if changes["frame"] > LARGEST_STILL_CHANGE_MPS2:
        sentences.append(
            f"{static.source}: the frame's acceleration changes by {changes['frame']:.1f} m/s², "
            f"expected less than {LARGEST_STILL_CHANGE_MPS2:g} m/s² in the static trial: the chair "
            "is carried, tipped or pushed"
        )
    return tuple(f"{sentence}; {cut}, or record it again" for sentence in sentences)


def _smooth(values: FloatArray, fs: float) -> FloatArray:
    """Vibration is far faster than a push."""
    return np.asarray(ndimage.gaussian_filter1d(values, ACCELERATION_SMOOTHING_S * fs, axis=0))


def _forward(
    straight: Recording, up: FloatArray, wheel_rate: FloatArray, *, turns: bool
) -> FloatArray:
    """Horizontal direction (IMU axes) in which the frame speeds up when the wheels do.

    With ``turns``, the acceleration to the side, which goes with speed times yaw rate, is left out.
    """
    fs = straight.sampling_rate_hz
    # Vibration is far faster than a push; both signals get the same smoothing.
    sigma = ACCELERATION_SMOOTHING_S * fs
    spin_up = ndimage.gaussian_filter1d(wheel_rate, sigma, order=1) * fs
    acc = _smooth(straight.sensor("frame").acc_mps2, fs)
    if turns:
        side = _smooth(wheel_rate * (straight.gyroscope("frame") @ up), fs)
        side = side - side.mean()
        spin_up = spin_up - side * (side @ spin_up) / (side @ side)
    pull = spin_up @ (acc - acc.mean(axis=0))
    pull -= (pull @ up) * up
    change = float(np.ptp(_smooth(wheel_rate, fs)))
    if change < SMALLEST_RATE_CHANGE_RADPS:
        raise InputError(
            f"{straight.source}: the wheels' rate changes by {change:.2f} rad/s, expected more "
            f"than {SMALLEST_RATE_CHANGE_RADPS} rad/s: the frame IMU's forward direction shows "
            "only while the speed changes; start or end the straight line at rest"
        )
    return np.asarray(pull / np.linalg.norm(pull))
