"""The path of a recording's IMU: readings checked, rests found, filter and smoother run."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobility_imu.arguments import expect, settings_or_default
from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray, as_flags, one_of, shown
from mobility_imu.health import unit_faults
from mobility_imu.offsets import rest_offsets
from mobility_imu.quality import frozen_samples, saturated_samples
from mobility_imu.recording import Recording
from mobility_imu.runs import runs_of
from mobility_imu.walker.given_rests import shifted_rests
from mobility_imu.walker.navigation import (
    ClosedLoop,
    Navigation,
    NavigationSettings,
    navigate,
)
from mobility_imu.walker.stillness import StillnessSettings, find_stillness

__all__ = ["as_sentences", "checked_options", "followed", "navigate_recording"]

LATEST_REST_S = 5.0
"""The first rest has to begin within this time."""
LEAST_RATE_HZ = 10.0
MOST_NIS, NIS_RATE_HZ = 2.0, 80.0
"""Mean normalised innovation of the rests above which a warning is given, and the rate below which
a sample counts for less. What is wrong throughout a rest is as large at any rate, but the noise
that it is held against is less in a longer sample. The limit stands on real walks at 80 Hz and
simulated ones at 100 Hz. Of 16 simulated walks, held against the same time, each has 0.42 to 0.65,
the same within 0.06 with every second to every eighth sample alone."""
LARGEST_ACC_MPS2 = 200.0
"""The usual sensors end at 16 g, 157 m/s²; a single reading beyond this is damaged."""
_STEADY_RADPS = 0.01
"""Scatter of a resting gyroscope is below this; in deg/s it would be above."""
_LOCAL = 0.1
"""Innovations that lie in so small a fraction of the rests have a cause there, not throughout."""
_HARMLESS = 1 / 2
"""Up to this fraction of the detector's limit, an offset of the gyroscope is left to the filter."""


def navigate_recording(
    recording: Recording,
    *,
    smooth: bool = True,
    settings: NavigationSettings | None = None,
    stillness: StillnessSettings | None = None,
    closed_loop: ClosedLoop | None = None,
    rests: ArrayLike | None = None,
) -> tuple[Navigation, tuple[str, ...]]:
    """Stillness and path of a recording's sensor "frame", with warnings.

    An offset of the gyroscope that would hide the rests from the detector is found from the times
    in which neither rate nor force changes, and taken off first.

    Parameters
    ----------
    recording : Recording with a sensor "frame"
    smooth, settings, closed_loop : see :func:`mobility_imu.walker.navigation.navigate`
    stillness : StillnessSettings
    rests : (n,) flags of the samples at rest, if they are known; None finds them

    Returns
    -------
    Navigation from the first rest on, warnings (a late rest, samples at the end of the range, an
    offset)

    Raises
    ------
    InputError
        If there is no rest within the first seconds, a reading is larger than any sensor's, the
        rate is too low, the unit of a half changes on the way, or ``closed_loop`` is asked for
        without the smoother.
    """
    settings, stillness, known = checked_options(
        recording,
        smooth=smooth,
        settings=settings,
        stillness=stillness,
        closed_loop=closed_loop,
        rests=rests,
    )
    _check_rate_and_size(recording)
    return followed(recording, smooth, settings, stillness, closed_loop, known)


def followed(
    recording: Recording,
    smooth: bool,
    settings: NavigationSettings,
    stillness: StillnessSettings,
    closed_loop: ClosedLoop | None = None,
    known: NDArray[np.bool_] | None = None,
) -> tuple[Navigation, tuple[str, ...]]:
    """The same of readings whose units and sizes are known to be right.

    Parameters
    ----------
    recording, smooth, settings, stillness, closed_loop : of :func:`navigate_recording`, checked
    known : (n,) bool array of the rests, or None

    Returns
    -------
    Navigation, warnings

    Raises
    ------
    InputError
        As :func:`navigate_recording`, but for rate, units and sizes.
    """
    imu, gyr = recording.sensor("frame"), recording.gyroscope("frame")
    rate_hz = recording.sampling_rate_hz
    (cut, cut_gyr), warnings = _faulty_samples(recording)
    offset = _offset(recording, settings, stillness)
    if offset.any():
        gyr = gyr - offset
        warnings.append(f"{recording.source}: {_stated(offset)}")
    still = find_stillness(imu.acc_mps2, gyr, rate_hz, stillness)
    shifted = None if known is None else shifted_rests(known, still, rate_hz)
    still = still if known is None else known
    begin, late_s = _first_rest(recording, still)
    if late_s > LATEST_REST_S:
        why = "" if known is not None else _why_not_still(imu.acc_mps2, gyr, rate_hz, stillness)
        raise InputError(
            f"{recording.source}: the frame is not still within the first {LATEST_REST_S:g} s: "
            f"expected some seconds of rest at the start, which say where up is{why}"
        )
    if late_s > 0.2:
        warnings.append(
            f"{recording.source}: the frame moves at the start; the first {late_s:.1f} s are left "
            "out"
        )
    try:
        path = navigate(
            recording.time_s[begin:],
            imu.acc_mps2[begin:],
            gyr[begin:],
            still[begin:],
            settings,
            smooth=smooth,
            cut=cut[begin:],
            cut_gyr=cut_gyr[begin:],
            closed_loop=closed_loop,
        )
    except InputError as error:
        raise InputError(f"{recording.source}: {error}") from None
    if offset.any():
        path = replace(path, gyr_bias_radps=path.gyr_bias_radps + offset)
    source = recording.source
    of_rests = [f"{source}: {shifted}"] if shifted else _inconsistent_rests(path, source)
    return path, (*warnings, *path.warnings, *of_rests)


def as_sentences(warnings: Iterable[str]) -> tuple[str, ...]:
    """Check that warnings are sentences, as results carry them.

    Parameters
    ----------
    warnings : of a result

    Returns
    -------
    tuple of str

    Raises
    ------
    InputError
        If they are something else, such as one text.
    """
    several = isinstance(warnings, Iterable) and not isinstance(warnings, str | np.ndarray)
    sentences = tuple(warnings) if several else ()
    if not several or not all(isinstance(text, str) for text in sentences):
        raise InputError(f"warnings: got {shown(warnings)}, expected those of a result")
    return sentences


def _first_rest(recording: Recording, still: NDArray[np.bool_]) -> tuple[int, float]:
    """First sample at rest, and its time after the start; infinite if there is none.

    Where up is comes from the first rest; what lies before it cannot be followed.
    """
    begin = int(np.argmax(still))
    late_s = float(recording.time_s[begin] - recording.time_s[0])
    return begin, late_s if still.any() else np.inf


def checked_options(
    recording: Recording,
    *,
    smooth: bool = True,
    settings: NavigationSettings | None = None,
    stillness: StillnessSettings | None = None,
    closed_loop: ClosedLoop | None = None,
    rests: ArrayLike | None = None,
) -> tuple[NavigationSettings, StillnessSettings, NDArray[np.bool_] | None]:
    """Check the arguments of :func:`navigate_recording`, whatever the readings are.

    Parameters
    ----------
    recording, smooth, settings, stillness, closed_loop, rests : of :func:`navigate_recording`

    Returns
    -------
    settings, stillness, (n,) bool array of the rests that are known or None

    Raises
    ------
    InputError
        If one is of another kind, the rests have another length, or ``closed_loop`` is asked for
        without the smoother.
    """
    expect("recording", recording, Recording)
    settings = settings_or_default("settings", settings, NavigationSettings)
    stillness = settings_or_default("stillness", stillness, StillnessSettings)
    expect("closed_loop", closed_loop, ClosedLoop, none=True)
    one_of("smooth", smooth, (True, False))
    if closed_loop is not None and not smooth:
        raise InputError("closed_loop needs the smoother: it cannot be had with smooth=False")
    known = None if rests is None else as_flags(rests, "rests", length=len(recording))
    return settings, stillness, known


def _offset(
    recording: Recording, settings: NavigationSettings, detector: StillnessSettings
) -> FloatArray:
    """Offset of the gyroscope to be taken off, rad/s; zeros if the filter can do without.

    The filter learns a small one in the first rest, or assumes one of a stated size. What the rests
    do not show with certainty counts as no offset.
    """
    found = rest_offsets(recording, ("frame",)).get("frame")
    if found is None:
        return np.zeros(3)
    small = _HARMLESS * detector.rate_radps
    if not settings.initial_gyr_mean:
        small = min(small, 2 * settings.gyr_bias_prior_sd_radps)
    size = float(np.linalg.norm(found.offset_radps))
    if size < max(small, 3 * float(np.linalg.norm(found.sd_radps))):
        return np.zeros(3)
    return found.offset_radps


def _stated(offset_radps: FloatArray) -> str:
    shown = (f"{k} {v:.2f}" for k, v in zip("xyz", np.rad2deg(offset_radps), strict=True))
    return f"the gyroscope has an offset ({', '.join(shown)} deg/s), which is taken off"


def _check_rate_and_size(recording: Recording) -> None:
    """Check the sampling rate, both halves' units, and that no force is larger than a sensor's."""
    acc = recording.sensor("frame", gyroscope=True).acc_mps2
    rate_hz = recording.sampling_rate_hz
    if not LEAST_RATE_HZ <= rate_hz:
        raise InputError(
            f"{recording.source}: {rate_hz:g} samples per second, expected {LEAST_RATE_HZ:g} or "
            "more (is time_s in ms?)"
        )
    units = unit_faults(recording, "frame")
    if units:
        raise InputError("; ".join(fault.sentence for fault in units))
    beyond = np.abs(acc) > LARGEST_ACC_MPS2
    if beyond.any():
        k, axis = (int(index[0]) for index in np.nonzero(beyond))
        raise InputError(
            f"{recording.source}: frame_acc_{'xyz'[axis]} is {acc[k, axis]:.4g} m/s² at "
            f"{recording.time_s[k]:g} s (sample {k}), more than such a sensor measures "
            f"({LARGEST_ACC_MPS2:g}); {int(beyond.sum())} such reading(s): correct or remove them"
        )


def _faulty_samples(
    recording: Recording,
) -> tuple[tuple[NDArray[np.bool_], NDArray[np.bool_]], list[str]]:
    """Samples with accelerometer, gyroscope at the end of their range, and all faults' warnings."""
    acc, gyr = recording.sensor("frame").acc_mps2, recording.gyroscope("frame")
    # A sensor that seldom moves repeats its largest value by rounding; a range ends far out.
    cut_acc, cut_gyr = saturated_samples(acc), saturated_samples(gyr)
    cut_acc[cut_acc] = np.abs(acc[cut_acc]).max(axis=1) > 15.0
    cut_gyr[cut_gyr] = np.abs(gyr[cut_gyr]).max(axis=1) > 3.0
    warnings = [
        f"{recording.source}: frame_{name} is saturated in {int(cut.sum())} samples, first at "
        f"{recording.time_s[np.argmax(cut)]:g} s: speed and path are uncertain from there to the "
        "next still phase"
        for name, cut in (("acc", cut_acc), ("gyr", cut_gyr))
        if cut.any()
    ]
    frozen = frozen_samples(np.hstack([acc, gyr]), recording.sampling_rate_hz)
    if frozen.any():
        warnings.append(
            f"{recording.source}: the readings repeat themselves in {int(frozen.sum())} samples, "
            f"first at {recording.time_s[np.argmax(frozen)]:g} s: was the sensor frozen?"
        )
    return (cut_acc, cut_gyr), warnings


def _why_not_still(
    acc: FloatArray, gyr: FloatArray, rate_hz: float, settings: StillnessSettings
) -> str:
    """What the gyroscope reads if the accelerometer alone finds the frame at rest."""
    soon = slice(0, int(LATEST_REST_S * rate_hz))
    quiet = find_stillness(acc[soon], np.zeros_like(gyr[soon]), rate_hz, settings)
    if quiet.mean() <= 0.2:
        return ""
    rate = gyr[soon][quiet]
    mean = float(np.linalg.norm(rate.mean(axis=0)))
    scatter = float(rate.std(axis=0).max())
    known = (
        f" (the force is at rest there, but the gyroscope reads {mean:.2g} rad/s in the mean, with "
        f"a scatter of {scatter:.2g}; up to {settings.rate_radps:g} counts as rest: "
    )
    if scatter < _STEADY_RADPS:
        return known + "take its offset off first, or is the frame turning evenly?)"
    return known + "does the frame turn, or is the gyroscope in deg/s?)"


def _inconsistent_rests(path: Navigation, source: str) -> list[str]:
    """Warn if the rests contradict what the filter expects, and say where they do."""
    updates = int(path.nis_dof.sum())
    # What is wrong throughout a rest is measured by a stride's noise, less than a sample's.
    strides, samples = np.count_nonzero(path.nis_dof), np.count_nonzero(path.still)
    whole = min(1.0, 1 / (float(np.median(np.diff(path.time_s))) * NIS_RATE_HZ)) if updates else 0.0
    nis = path.nis.sum() / updates * strides / samples * whole if updates else 0.0
    if nis <= MOST_NIS:
        return []
    excess = f"{source}: the rests are {np.sqrt(nis):.1f} times as far from what the filter expects"
    rests = runs_of(path.still)
    each = np.array([path.nis[rest].sum() for rest in rests])
    order = np.argsort(each)[::-1]
    carrying = int(np.searchsorted(np.cumsum(each[order]), 0.9 * each.sum())) + 1
    if len(rests) > 1 and carrying <= max(1, _LOCAL * len(rests)):
        worst = rests[order[0]]
        k = worst.start + int(np.argmax(path.nis[worst]))
        return [
            f"{excess} as they should be, nearly all of it in {carrying} of {len(rests)} rests, "
            f"most at {path.time_s[k]:.1f} s: was the frame moved or hit there, or is a reading "
            "damaged?"
        ]
    return [
        f"{excess} as they should be: does the frame move a little at rest (unsteady hands, a "
        "foot), or are axes exchanged, or signs reversed?"
    ]
