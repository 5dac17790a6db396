"""What each choice that the document leaves open is worth: how many frames get another label."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from mobility_imu.frames import FloatArray
from mobility_imu.wheelchair.settings import TaskSettings
from mobility_imu.wheelchair.tasks import (
    Codes,
    Edge,
    Symbols,
    curvature_radius,
    find_pattern,
    reduce_variability,
    refine_edges,
    symbolic_signals,
    window_means,
)

DEFAULT = TaskSettings()
Labelling = Callable[[FloatArray, FloatArray], Codes]


def label_steps(
    velocity_mps: FloatArray,
    yaw_rate_radps: FloatArray,
    sampling_rate_hz: float,
    *,
    symbols: Symbols | None = None,
    look: int | None = None,
    shortest: int | None = None,
    settings: TaskSettings = DEFAULT,
    edge: Edge = "covering",
) -> Codes:
    """Steps 1 to 5, with one of them exchanged.

    Parameters
    ----------
    velocity_mps, yaw_rate_radps : (n,) arrays, m/s and rad/s
    sampling_rate_hz : Hz
    symbols : what steps 1 and 2 give, if they are to be others
    look : frames that step 4 looks, the settings' if None
    shortest : frames that step 5 asks for, a segment if None
    settings, edge : as :func:`~mobility_imu.wheelchair.tasks.task_codes` has them

    Returns
    -------
    (n,) array of task codes
    """
    segment, usual_look = settings.frames(sampling_rate_hz)
    if symbols is None:
        symbols = symbolic_signals(velocity_mps, yaw_rate_radps, segment, settings, edge)
    refined = refine_edges(
        find_pattern(symbols),
        np.abs(velocity_mps),
        np.abs(np.rad2deg(yaw_rate_radps)),
        usual_look if look is None else look,
        settings,
    )
    return reduce_variability(refined, segment if shortest is None else shortest)


def letters_of(
    velocity_mps: FloatArray, speed_mps: FloatArray, turning_degps: FloatArray, radius_m: FloatArray
) -> Symbols:
    """Table 1 with its default limits, applied to given means.

    Parameters
    ----------
    velocity_mps, speed_mps, turning_degps, radius_m : (n,) arrays

    Returns
    -------
    Symbols
    """
    limit, near, far = (
        DEFAULT.linear_velocity_mps,
        DEFAULT.pivot_radius_m,
        DEFAULT.wide_radius_m,
    )
    return Symbols(
        np.where(velocity_mps <= -limit, 0, np.where(velocity_mps >= limit, 2, 1)).astype(np.int8),
        np.where(speed_mps >= limit, 2, 1).astype(np.int8),
        np.where(turning_degps >= DEFAULT.yaw_rate_degps, 2, 1).astype(np.int8),
        np.where(radius_m <= near, 0, np.where(radius_m < far, 1, 2)).astype(np.int8),
    )


def one_offset(velocity_mps: FloatArray, yaw_rate_radps: FloatArray, segment: int) -> Symbols:
    """Step 1 with a single segmentation instead of one for every offset.

    Parameters
    ----------
    velocity_mps, yaw_rate_radps : (n,) arrays, m/s and rad/s
    segment : frames in a segment

    Returns
    -------
    Symbols
    """
    first = np.arange(len(velocity_mps)) // segment * segment
    signals = (
        velocity_mps,
        np.abs(velocity_mps),
        np.abs(np.rad2deg(yaw_rate_radps)),
        curvature_radius(velocity_mps, yaw_rate_radps),
    )
    return letters_of(*(window_means(signal, segment)[first] for signal in signals))


def radius_of_means(velocity_mps: FloatArray, yaw_rate_radps: FloatArray, segment: int) -> Symbols:
    """Steps 1 and 2 with the radius from a segment's means, not the mean of its radii.

    Parameters
    ----------
    velocity_mps, yaw_rate_radps : (n,) arrays, m/s and rad/s
    segment : frames in a segment

    Returns
    -------
    Symbols
    """
    usual = symbolic_signals(velocity_mps, yaw_rate_radps, segment, DEFAULT, "covering")
    speed, turning = (
        window_means(np.abs(signal), segment) for signal in (velocity_mps, yaw_rate_radps)
    )
    radius = curvature_radius(speed, turning)
    letters = letters_of(radius, radius, radius, radius).radius
    return replace(usual, radius=vote(letters, segment))


def vote(letters: Codes, segment: int) -> Codes:
    """Most frequent letter of the windows that cover each frame, of equals the first.

    Parameters
    ----------
    letters : (n,) array of 0, 1, 2, letter of the window that starts at each frame
    segment : frames in a window

    Returns
    -------
    (n,) array of 0, 1, 2
    """
    stop = np.arange(len(letters)) + 1
    start = np.maximum(stop - segment, 0)
    sums = [np.r_[0, np.cumsum(letters == letter)] for letter in range(3)]
    most = np.argmax([total[stop] - total[start] for total in sums], axis=0)
    return np.asarray(most, np.int8)


def open_choices(sampling_rate_hz: float) -> dict[str, Labelling]:
    """Other readings of section 2, each a function from velocities to labels.

    Parameters
    ----------
    sampling_rate_hz : Hz

    Returns
    -------
    dict from the choice in words to the function
    """
    segment, look = DEFAULT.frames(sampling_rate_hz)
    per_degree = 180 / np.pi
    in_degrees = TaskSettings(
        pivot_radius_m=DEFAULT.pivot_radius_m * per_degree,
        wide_radius_m=DEFAULT.wide_radius_m * per_degree,
    )
    above = TaskSettings(yaw_rate_degps=float(np.nextafter(DEFAULT.yaw_rate_degps, np.inf)))

    def other(**change: object) -> Labelling:
        return lambda v, w: label_steps(v, w, sampling_rate_hz, **change)  # type: ignore[arg-type]

    def step_1(symbols: Callable[[FloatArray, FloatArray, int], Symbols]) -> Labelling:
        return lambda v, w: label_steps(v, w, sampling_rate_hz, symbols=symbols(v, w, segment))

    return {
        "first frames as in the tool": other(edge="tool"),
        f"one offset instead of {segment}": step_1(one_offset),
        "yaw rate > 40, as in the document (tool: >=)": other(settings=above),
        "radius from °/s": other(settings=in_degrees),
        "radius from means, not mean of radii": step_1(radius_of_means),
        "no step 4": other(look=0),
        "step 4 looks half as far": other(look=look // 2),
        "step 4 looks twice as far": other(look=2 * look),
        "step 4 looks without end": lambda v, w: label_steps(v, w, sampling_rate_hz, look=len(v)),
        "no step 5": other(shortest=0),
        "step 5 of any length": lambda v, w: label_steps(v, w, sampling_rate_hz, shortest=len(v)),
    }


def frames_changed(
    velocity_mps: FloatArray, yaw_rate_radps: FloatArray, sampling_rate_hz: float
) -> dict[str, int]:
    """How many frames each open choice labels otherwise than the package's defaults.

    Parameters
    ----------
    velocity_mps, yaw_rate_radps : (n,) arrays, m/s and rad/s
    sampling_rate_hz : Hz

    Returns
    -------
    dict from the choice in words to the number of frames
    """
    label = partial(label_steps, velocity_mps, yaw_rate_radps, sampling_rate_hz)
    usual = label()
    return {
        what: int(np.count_nonzero(choice(velocity_mps, yaw_rate_radps) != usual))
        for what, choice in open_choices(sampling_rate_hz).items()
    }
