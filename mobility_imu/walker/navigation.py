"""Where the IMU goes: strapdown integration with an error-state Kalman filter and smoother.

World frame: z up, origin where the IMU is at the start. Its heading is a matter of choice: here
the IMU is brought upright by the shortest turn. (The paper lays x in the vertical plane of the
IMU's x axis, which fails where that axis is vertical, as it nearly is in its third mounting.)

A reading is taken for the value at its time. The filter steps from midpoint to midpoint between
samples, with the means over these intervals; what is given out is brought back to the samples.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from mobility_imu._compiled import choose
from mobility_imu.arguments import expect, settings_or_default
from mobility_imu.errors import InputError
from mobility_imu.frames import (
    GAP_FACTOR,
    STANDARD_GRAVITY_MPS2,
    FloatArray,
    as_clock,
    as_flags,
    as_floats,
    as_vectors,
    one_of,
    shown,
)
from mobility_imu.results import Result
from mobility_imu.rotations import cross_matrix
from mobility_imu.runs import runs_of
from mobility_imu.walker import _kernel, eskf
from mobility_imu.walker.error_state import (
    GRAVITY_MPS2,
    STATES,
    NavigationState,
    corrected_state,
    error_dynamics,
    imu_output,
    interval_means,
    state_error,
    step_transition,
    strapdown_rates,
    strapdown_step,
)
from mobility_imu.walker.geometry import rotation_world_to_imu
from mobility_imu.walker.navigation_settings import ClosedLoop, NavigationSettings
from mobility_imu.walker.saturation import bridged_rates
from mobility_imu.walker.stillness import LARGEST_READING

if TYPE_CHECKING:
    import pandas as pd

__all__ = [
    "GRAVITY_MPS2",
    "STATES",
    "ClosedLoop",
    "Navigation",
    "NavigationSettings",
    "NavigationState",
    "corrected_state",
    "error_dynamics",
    "imu_output",
    "integrate_strapdown",
    "interval_means",
    "navigate",
    "run_filter",
    "state_error",
    "step_transition",
    "strapdown_rates",
]

FASTEST_REST_MPS = 50.0
"""Speed at rest, where the filter is told zero, that shows a filter without digits: with the
defaults it is 1 mm/s, and with readings of no frame some m/s."""
VELOCITY_OF_ROW = slice(7, 10)
_PLAIN_S_PER_SAMPLE = 1e-4  # of the readable filter, and a fifth of it for the states alone


@dataclass(frozen=True, eq=False, repr=False)
class Navigation(Result):
    """Path of the IMU with standard deviations, at the samples; arrays with n rows.

    Parameters
    ----------
    time_s : (n,) s
    quaternion : (n, 4) Hamilton, scalar first, IMU to world
    position_m, velocity_mps : (n, 3) world
    gyr_bias_radps, acc_bias_mps2 : (n, 3) IMU's axes
    sd : (n, 15) standard deviations in the order of STATES; the attitude's are half angles, rad,
        about the IMU's axes; inside a stride their squares are linear from sample to sample
    xy_covariance_m2 : (n,) covariance of the position's errors along x and y
    still : (n,) bool
    nis : (n,) normalised innovation squared, summed over the updates of a sample
    nis_dof : (n,) int, number of these updates; 0 but at a stride's last sample
    settings : NavigationSettings of the filter; None without one
    warnings : sentences
    """

    time_s: FloatArray
    quaternion: FloatArray
    position_m: FloatArray
    velocity_mps: FloatArray
    gyr_bias_radps: FloatArray
    acc_bias_mps2: FloatArray
    sd: FloatArray
    xy_covariance_m2: FloatArray
    still: NDArray[np.bool_]
    nis: FloatArray
    nis_dof: NDArray[np.int64]
    settings: NavigationSettings | None = None
    warnings: tuple[str, ...] = ()

    def rotation_imu_to_world(self) -> FloatArray:
        """Attitude as matrices, (n, 3, 3)."""
        return np.swapaxes(rotation_world_to_imu(self.quaternion), 1, 2)

    def state(self, sample: int) -> NavigationState:
        """State at one sample.

        Parameters
        ----------
        sample : number of the sample; negative ones count from the end

        Returns
        -------
        NavigationState
        """
        return NavigationState(
            self.quaternion[sample], self.position_m[sample], self.velocity_mps[sample],
            self.gyr_bias_radps[sample], self.acc_bias_mps2[sample],
        )  # fmt: skip

    def to_frame(self) -> pd.DataFrame:
        """Table with one row per sample: states, then their standard deviations.

        Returns
        -------
        pandas.DataFrame
        """
        import pandas as pd

        vectors = {
            "half_turn_{}_sd_rad": self.sd[:, 0:3],
            "gyr_bias_{}_sd_radps": self.sd[:, 3:6],
            "{}_sd_m": self.sd[:, 6:9],
            "velocity_{}_sd_mps": self.sd[:, 9:12],
            "acc_bias_{}_sd_mps2": self.sd[:, 12:15],
        }
        columns: dict[str, NDArray[np.generic]] = {"time_s": self.time_s}
        columns |= {f"q{name}": self.quaternion[:, k] for k, name in enumerate("wxyz")}
        for name, values in (
            ("{}_m", self.position_m),
            ("velocity_{}_mps", self.velocity_mps),
            ("gyr_bias_{}_radps", self.gyr_bias_radps),
            ("acc_bias_{}_mps2", self.acc_bias_mps2),
            *vectors.items(),
        ):
            columns |= {name.format(axis): values[:, k] for k, axis in enumerate("xyz")}
        return pd.DataFrame({**columns, "still": self.still})


def integrate_strapdown(
    time_s: ArrayLike,
    acc_mps2: ArrayLike,
    gyr_radps: ArrayLike,
    start: NavigationState,
    *,
    still: ArrayLike | None = None,
) -> Navigation:
    """Integrate eqs 20 and 21 without a filter; the velocity is set to 0 where the frame is still.

    Parameters
    ----------
    time_s : (n,) array, s
    acc_mps2, gyr_radps : (n, 3) arrays, in the IMU's axes
    start : NavigationState at the first sample (its biases are taken off throughout)
    still : (n,) bool array, none if it is not given

    Returns
    -------
    Navigation; its standard deviations are NaN
    """
    clock, acc, gyr, at_rest = _inputs(time_s, acc_mps2, gyr_radps, still)
    first = _checked_start(start)
    acc, gyr = interval_means(acc, gyr, float(np.median(np.diff(clock))))
    count, dt = len(clock), _intervals(clock)
    states = np.empty((count + 1, 16))
    states[0] = eskf.as_row(first)
    given = (acc, gyr, at_rest, dt, states)
    plain_s = count * _PLAIN_S_PER_SAMPLE / 5
    if choose({_kernel.strapdown_path: given}, plain_s=plain_s, what="integration") == "compiled":
        _kernel.strapdown_path(*given)
    else:
        state = first
        for k in range(count):
            state, _ = strapdown_step(state, acc[k], gyr[k], dt[k])
            if at_rest[k]:
                state = state._replace(velocity_mps=np.zeros(3))
            states[k + 1] = eskf.as_row(state)
    variances = np.full((count + 1, 16), np.nan)
    nis, dof = np.zeros(count), np.zeros(count, np.int64)
    ends = np.arange(1, count + 1)
    return _at_samples(clock, states, ends, variances, at_rest, nis, dof, None)


def navigate(
    time_s: ArrayLike,
    acc_mps2: ArrayLike,
    gyr_radps: ArrayLike,
    still: ArrayLike,
    settings: NavigationSettings | None = None,
    *,
    smooth: bool = True,
    cut: ArrayLike | None = None,
    cut_gyr: ArrayLike | None = None,
    closed_loop: ClosedLoop | None = None,
) -> Navigation:
    """Path of an IMU: error-state Kalman filter and, unless ``smooth=False``, RTS smoother.

    When the frame is still: velocity zero, height as at the start (if it is upright), rate zero.
    The smoother gives what a Rauch-Tung-Striebel smoother gives, by the adjoint recursion of
    Bryson and Frazier, which needs no inverse. The state is integrated at every sample, the
    covariance in strides, see NavigationSettings. The equations are in
    :mod:`mobility_imu.walker.eskf`.

    Parameters
    ----------
    time_s : (n,) array, s
    acc_mps2 : (n, 3) array, m/s², specific force in the IMU's axes
    gyr_radps : (n, 3) array, rad/s, in the IMU's axes
    still : (n,) bool array, see :func:`mobility_imu.walker.stillness.find_stillness`
    settings : NavigationSettings
    smooth : whether each estimate may use what comes after it
    cut, cut_gyr : (n,) bool arrays, samples in which accelerometer, gyroscope were at the end of
        their range
    closed_loop : tells the smoother that the frame ends where it began

    Returns
    -------
    Navigation

    Raises
    ------
    InputError
        If the frame is not still at the first sample: where up is, and the biases, come from the
        rest there, and no later rest can tell the attitude before it.
    """
    settings = settings_or_default("settings", settings, NavigationSettings)
    clock, acc, gyr, at_rest = _inputs(time_s, acc_mps2, gyr_radps, still)
    gyr, beyond = bridged_rates(gyr, settings.gyr_range_radps)
    if cut_gyr is not None:
        beyond = beyond | as_flags(cut_gyr, "cut_gyr", length=len(clock))
    acc, gyr = interval_means(acc, gyr, float(np.median(np.diff(clock))))
    state, covariance = _start(clock, acc, gyr, at_rest, settings)
    return run_filter(
        clock, acc, gyr, at_rest, state, covariance, settings,
        smooth=smooth, cut=cut, cut_gyr=beyond, closed_loop=closed_loop,
    )  # fmt: skip


def run_filter(
    time_s: ArrayLike,
    acc_mps2: ArrayLike,
    gyr_radps: ArrayLike,
    still: ArrayLike,
    start: NavigationState,
    covariance: ArrayLike,
    settings: NavigationSettings,
    *,
    smooth: bool = True,
    cut: ArrayLike | None = None,
    cut_gyr: ArrayLike | None = None,
    closed_loop: ClosedLoop | None = None,
    observed: ArrayLike | None = None,
) -> Navigation:
    """Filter and smoother from a given start and means over intervals, see :func:`navigate`.

    Parameters
    ----------
    time_s, acc_mps2, gyr_radps, still, settings, smooth, closed_loop : as in :func:`navigate`
    cut, cut_gyr : as in :func:`navigate`
    start : NavigationState
    covariance : (15, 15) array, of the error of the start
    observed : (n, 4) array, velocity (m/s) and height (m) that the updates observe; zeros if it is
        not given. Simulations put the stated noise here to test consistency. An update takes the
        mean over its stride.

    Returns
    -------
    Navigation
    """
    clock, acc, gyr, at_rest = _inputs(time_s, acc_mps2, gyr_radps, still)
    count = len(clock)
    nowhere = np.zeros(count, np.bool_)
    saturated = as_flags(nowhere if cut is None else cut, "cut", length=count)
    rate_saturated = as_flags(nowhere if cut_gyr is None else cut_gyr, "cut_gyr", length=count)
    given = np.zeros((1, 4)) if observed is None else as_floats(observed, "observed")
    seen = np.array(given, order="C")
    if observed is not None and (seen.shape != (count, 4) or not np.isfinite(seen).all()):
        raise InputError(f"observed {seen.shape}: expected ({count}, 4) finite numbers")
    expect("settings", settings, NavigationSettings)
    expect("closed_loop", closed_loop, ClosedLoop, none=True)
    one_of("smooth", smooth, (True, False))
    if closed_loop is not None and not smooth:
        raise InputError(
            "closed_loop with smooth = False: the filter does not know the end, expected smoothing"
        )
    first, first_covariance = _checked_start(start), _checked_covariance(covariance)
    dt = _intervals(clock)
    alone = saturated | rate_saturated | (dt > GAP_FACTOR * np.median(dt))
    ends = eskf.stride_ends(at_rest, alone, settings.moving_stride, settings.resting_stride)
    problem = eskf.Problem(
        acc, gyr, dt, at_rest, _long_moves(at_rest, dt, settings.longest_move_s), saturated,
        rate_saturated, seen, ends, settings.noise(), settings.zero_rate,
        settings.form, float(np.cos(settings.upright_rad)),
    )  # fmt: skip
    states, variances, nis, dof = _solve(problem, first, first_covariance, smooth, closed_loop)
    if not np.isfinite(states).all():
        raise _without_end(acc, gyr)
    resting = float(np.abs(states[1:][at_rest, VELOCITY_OF_ROW]).max(initial=0.0))
    if resting > FASTEST_REST_MPS:
        raise InputError(
            f"the frame would move by {resting:.2g} m/s where it is still: the noises of the "
            "settings lie so many powers of ten apart, or from the readings, that no digit is left"
        )
    return _at_samples(clock, states, ends, variances, at_rest, nis, dof, settings)


def _solve(
    problem: eskf.Problem,
    start: NavigationState,
    covariance: FloatArray,
    smooth: bool,
    closed_loop: ClosedLoop | None,
) -> tuple[FloatArray, FloatArray, FloatArray, NDArray[np.int64]]:
    """States (n + 1, 16), variances (m + 1, 16), NIS and its degrees of freedom (n,).

    By the kernel if its machine code is there or is worth its time, else by the readable form.
    """
    count, strides = len(problem.dt), len(problem.ends)
    states, covariances = np.empty((count + 1, 16)), np.zeros((strides + 1, 240))
    states[0], covariances[0].reshape(15, 16)[:, :15] = eskf.as_row(start), covariance
    transitions, work = np.empty((strides, 240)), _kernel.aligned(10)
    innovations, weights, errors = np.zeros((3, strides, 15))
    nis, dof = np.zeros(count), np.zeros(count, np.int64)
    sign, coupling = (1.0, 0.0) if problem.form == "printed" else (-1.0, 1.0)
    at_limit = eskf.SATURATED_ACC_SD_MPS2**2, eskf.SATURATED_GYR_SD_RADPS**2
    noise = np.array([*problem.noise, *at_limit])
    mu, big_lambda = np.zeros(15), np.zeros((15, 15))
    variances = np.empty((strides + 1, 16))
    forward = (
        problem.acc, problem.gyr, problem.still, problem.long_move, problem.saturated,
        problem.rate_saturated, problem.observed, problem.dt,
        problem.ends, noise, problem.zero_rate, sign, coupling, problem.upright_cos, work, states,
        covariances, transitions, innovations, weights, errors, nis, dof,
    )  # fmt: skip
    backward = (
        problem.ends, covariances, transitions, innovations, weights, errors, mu, np.zeros(240),
        work, states, variances,
    )  # fmt: skip
    loops: dict[Callable[..., None], tuple[Any, ...]] = {
        _kernel.run_filter: forward,
        _kernel.run_smoother: backward,
    }
    way = choose(loops, plain_s=count * _PLAIN_S_PER_SAMPLE, what="walker's filter")
    if way == "compiled":
        _kernel.run_filter(*forward)
        dense = covariances.reshape(-1, 15, 16)[:, :, :15]
    else:
        filtered = eskf.run_filter(problem, start, covariance)
        states, dense, nis, dof = filtered[:4]
    if not smooth:
        return states, eskf.variances_of(dense), nis, dof
    if closed_loop is not None:
        mu, big_lambda = eskf.known_end(
            eskf.from_row(states[0]), eskf.from_row(states[-1]), dense[-1],
            closed_loop.position_sd_m, closed_loop.heading_sd_rad,
        )  # fmt: skip
    if way == "compiled":
        flat = np.zeros((15, 16))
        flat[:, :15] = big_lambda
        _kernel.run_smoother(*backward[:6], mu, flat.ravel(), *backward[8:])
    else:
        states, variances = eskf.run_smoother(problem, filtered, mu, big_lambda)
    np.maximum(variances[:, :15], 0, out=variances[:, :15])  # rounding may have left less
    return states, variances, nis, dof


def _inputs(
    time_s: ArrayLike, acc_mps2: ArrayLike, gyr_radps: ArrayLike, still: ArrayLike | None
) -> tuple[FloatArray, FloatArray, FloatArray, NDArray[np.bool_]]:
    """Clock, readings and flags, checked; copies of one layout, which the compiled loops expect."""
    clock = np.array(as_clock(time_s))
    acc = np.array(as_vectors(acc_mps2, "acc_mps2", length=len(clock), finite=True), order="C")
    gyr = np.array(as_vectors(gyr_radps, "gyr_radps", length=len(clock), finite=True), order="C")
    if max(np.abs(acc).max(), np.abs(gyr).max()) > LARGEST_READING:
        raise _without_end(acc, gyr)
    none = np.zeros(len(clock), np.bool_)
    return clock, acc, gyr, as_flags(none if still is None else still, "still", length=len(clock))


def _without_end(acc: FloatArray, gyr: FloatArray) -> InputError:
    """Error of readings that no path can be computed from."""
    force, rate = np.abs(acc).max(), np.abs(gyr).max()
    return InputError(
        f"the path has no finite end: the largest readings are {force:.3g} m/s² and "
        f"{rate:.3g} rad/s, expected those of an IMU on a walking frame"
    )


def _checked_start(start: NavigationState) -> NavigationState:
    """State as float arrays, its quaternion of length 1."""
    expect("start", start, NavigationState)
    q = as_floats(start.quaternion, "start.quaternion")
    size = np.abs(q).max() if q.shape == (4,) else np.nan
    if not (np.isfinite(size) and size > 0):
        raise InputError(
            f"start.quaternion = {shown(start.quaternion)}: expected four numbers, not all zero"
        )
    q = q / size  # the squares of huge numbers are infinite
    length = np.linalg.norm(q)
    vectors = (as_vectors(start[k], f"start.{NavigationState._fields[k]}", ndim=1, finite=True)
               for k in range(1, 5))  # fmt: skip
    return NavigationState(q / length, *(np.array(vector) for vector in vectors))


def _checked_covariance(covariance: ArrayLike) -> FloatArray:
    p = np.array(as_floats(covariance, "covariance"))
    if p.shape != (15, 15) or not np.isfinite(p).all():
        raise InputError(f"covariance {p.shape}: expected (15, 15) finite numbers")
    if (np.diagonal(p) < 0).any() or not np.allclose(p, p.T, rtol=1e-6, atol=1e-12 * p.max()):
        raise InputError("covariance: expected a symmetric matrix without negative variances")
    return p


def _intervals(clock: FloatArray) -> FloatArray:
    """Length of the interval that each sample stands for: from midpoint to midpoint."""
    step = np.diff(clock)
    bounds = np.concatenate([[step[0]], step, [step[-1]]])
    return np.asarray((bounds[1:] + bounds[:-1]) / 2)


def _long_moves(still: NDArray[np.bool_], dt: FloatArray, longest_s: float) -> NDArray[np.bool_]:
    """Whether each sample is in a move that lasts too long for one of a frame."""
    found = np.zeros(len(still), np.bool_)
    for move in runs_of(~still):
        found[move] = dt[move].sum() > longest_s
    return found


def _start(
    clock: FloatArray,
    acc: FloatArray,
    gyr: FloatArray,
    still: NDArray[np.bool_],
    settings: NavigationSettings,
) -> tuple[NavigationState, FloatArray]:
    """Upright by the first rest's mean specific force, rates less their mean there."""
    if not still[0]:
        begins = int(np.argmax(still))
        later = (
            f"; the first rest begins at sample {begins}, {clock[begins] - clock[0]:.3g} s later: "
            "leave out what comes before it"
            if still.any()
            else ""
        )
        raise InputError(
            "still: the frame is not still at the first sample, expected a rest of some seconds at "
            f"the start, which tells where up is{later}"
        )
    moving = np.flatnonzero(~still)
    rest = slice(0, int(moving[0]) if len(moving) else len(still))
    force, rate = acc[rest].mean(axis=0), gyr[rest].mean(axis=0)
    norm = np.linalg.norm(force)
    if not norm > 0:
        raise InputError("acc_mps2: zero in the first rest, expected 9.81 m/s² of gravity")
    up = force / norm
    turn, _ = Rotation.align_vectors([[0.0, 0.0, 1.0]], up[None])
    length = float(np.sum(_intervals(clock)[rest]))
    noise = settings.noise()
    if settings.initial_gyr_mean:
        gyr_bias, gyr_var = rate, settings.gyr_bias_sd_radps**2 + noise.gyr / length
    else:
        gyr_bias, gyr_var = np.zeros(3), settings.gyr_bias_prior_sd_radps**2
    # The first attitude is right if the accelerometer's bias is nil: both err together.
    acc_var = settings.acc_bias_sd_mps2**2
    lean = cross_matrix(up) / (2 * STANDARD_GRAVITY_MPS2)
    p = np.zeros((15, 15))
    p[0:3, 0:3] = lean @ lean.T * (acc_var + noise.acc / length) + 1e-10 * np.eye(3)
    p[0:3, 12:15] = lean * acc_var
    p[12:15, 0:3] = p[0:3, 12:15].T
    p[3:6, 3:6] = gyr_var * np.eye(3)
    p[6:9, 6:9] = 1e-12 * np.eye(3)
    p[9:12, 9:12] = noise.velocity * np.eye(3)
    p[12:15, 12:15] = acc_var * np.eye(3)
    zero = np.zeros(3)
    return NavigationState(turn.as_quat(scalar_first=True), zero, zero, gyr_bias, zero), p


def _at_samples(
    clock: FloatArray,
    states: FloatArray,
    ends: NDArray[np.int64],
    variances: FloatArray,
    still: NDArray[np.bool_],
    nis: FloatArray,
    dof: NDArray[np.int64],
    settings: NavigationSettings | None,
) -> Navigation:
    """From the midpoints between the samples to the samples."""
    middle = (states[1:] + states[:-1]) / 2
    quaternion = middle[:, 0:4]
    quaternion /= np.sqrt(np.sum(quaternion**2, axis=1, keepdims=True))
    position, velocity, gyr_bias, acc_bias = (middle[:, k : k + 3] for k in (4, 7, 10, 13))
    sizes = np.diff(ends, prepend=0)
    stride = np.repeat(np.arange(len(ends)), sizes)
    later = (np.arange(len(clock)) + 0.5 - (ends - sizes)[stride]) / sizes[stride]
    spread = variances[stride]
    spread += later[:, None] * np.diff(variances, axis=0)[stride]
    xy = spread[:, 15].copy()
    sd = np.sqrt(np.maximum(spread[:, :15], 0))
    return Navigation(
        clock, quaternion, position, velocity, gyr_bias, acc_bias, sd, xy, still, nis, dof, settings
    )
