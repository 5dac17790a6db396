"""What a wheel's accelerometer knows of its turning: gravity turns in the wheel's plane.

Up, seen from a wheel, turns backward as the wheel rolls forward. Its angle gives the wheel's spin
without the gyroscope, and its direction gives the chair's yaw rate without frame and radius: the
part of the wheel's rate along up in the wheel's plane is yaw rate times cos(camber).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import ndimage

from mobility_imu.filters import rms
from mobility_imu.frames import FloatArray, as_number, as_series, as_vectors
from mobility_imu.wheelchair.fits import fit_by_pieces, pieces_of
from mobility_imu.wheelchair.series import as_rate

__all__ = ["SpinFit", "spin_fit", "up_in_plane", "upward_angle", "without_arm", "yaw_rate_of_wheel"]

STEADY_S = 0.1
"""Accelerations are averaged over this: a wheel at 4 m/s turns by a fifth of a turn in it."""
TIED_S = 1.0
"""Time over which up is averaged once the gyroscope has turned it back."""
LEAST_SPIN_RADPS = 0.5
"""A wheel counts as turning from here on: 0.15 m/s."""
SHORTEST_TURNING_S = 5.0
LEAST_FACTOR = 0.2
"""No gyroscope reads five times too much: it is gravity that is not seen to turn."""
LEAST_TURNED_RAD = 4 * np.pi
"""Two turns of the wheel, of which gravity's noise (0.1 rad) is less than 1 %."""
PIECE_S = 2.0
"""Residuals of one piece depend on each other: a stroke lasts about a second."""
LARGEST_SCATTER_RAD = 0.6
"""Larger scatter says that something else turns up, such as a sensor that is loose."""

SLOW_SD_RAD = 0.5
"""Slow change of the angle from one end of a drive to the other that no gyroscope makes: slopes,
speeding up, lost samples. One module's scale factor scatters by 1 % over six real drives of 33 to
75 rad."""


class SpinFit(NamedTuple):
    """True spin by gravity, as a factor of what the gyroscope reads and a constant.

    Parameters
    ----------
    factor : true spin over the spin that is read
    constant_radps : rad/s, true spin where zero is read
    covariance : (2, 2) array of the two
    scatter_rad : rad, root mean square of the angles about the fit
    turned_rad : rad, range of the gyroscope's angle
    duration_s : s, of the recording
    """

    factor: float
    constant_radps: float
    covariance: FloatArray
    scatter_rad: float
    turned_rad: float
    duration_s: float

    def scale(self, offset_sd_radps: float) -> tuple[float, float]:
        """Scale error of the gyroscope, if its offset is known to be zero to a standard deviation.

        Parameters
        ----------
        offset_sd_radps : rad/s

        Returns
        -------
        fraction that it reads too much, and its standard deviation
        """
        (variance, together), (_, other) = self.covariance
        gain = together / (other + offset_sd_radps**2)
        factor = self.factor - gain * self.constant_radps
        variance = max(variance - gain * together, 0.0) + (SLOW_SD_RAD / self.turned_rad) ** 2
        return float(1 / factor - 1), float(np.sqrt(variance) / factor**2)

    def offset(self, scale_sd: float) -> tuple[float, float]:
        """Offset of the gyroscope, if its scale is known to be right to a standard deviation.

        Parameters
        ----------
        scale_sd : fraction

        Returns
        -------
        rad/s that it reads too much, and its standard deviation
        """
        (other, together), (_, variance) = self.covariance
        gain = together / (other + scale_sd**2)
        constant = self.constant_radps - gain * (self.factor - 1)
        variance = max(variance - gain * together, 0.0) + (SLOW_SD_RAD / self.duration_s) ** 2
        return float(-constant), float(np.sqrt(variance))


def upward_angle(acc_wheel_mps2: ArrayLike, sampling_rate_hz: float) -> FloatArray:
    """Angle of up in the wheel's plane, which falls as the wheel rolls forward.

    Parameters
    ----------
    acc_wheel_mps2 : (n, 3) array, m/s², in the wheel's frame: z is the axle
    sampling_rate_hz : Hz

    Returns
    -------
    (n,) array, rad, from the wheel's x axis to its y axis, without jumps
    """
    acc = as_vectors(acc_wheel_mps2, "acc_wheel_mps2", ndim=2)
    width = max(1, round(STEADY_S * as_rate(sampling_rate_hz)))
    in_plane = ndimage.uniform_filter1d(acc[:, :2], width, axis=0)
    return np.unwrap(np.arctan2(in_plane[:, 1], in_plane[:, 0]))


def up_in_plane(acc_mps2: FloatArray, spin_radps: FloatArray, rate_hz: float) -> FloatArray:
    """Up in a wheel's plane, seen by the accelerometer and averaged.

    The gyroscope's spin turns the accelerations back before they are averaged, so that up stands
    still in them, and turns their mean forth again.

    Parameters
    ----------
    acc_mps2 : (n, 2) array, m/s², along two axes across the axle
    spin_radps : (n,) array, rad/s, about the axle, from the first of these axes to the second
    rate_hz : Hz

    Returns
    -------
    (n, 2) array of unit vectors
    """
    turn = np.exp(1j * np.cumsum(spin_radps) / rate_hz)
    up = _averaged((acc_mps2[:, 0] + 1j * acc_mps2[:, 1]) * turn, max(1, round(TIED_S * rate_hz)))
    up = np.conj(turn) * up / np.maximum(np.abs(up), 1e-9)
    return np.column_stack([up.real, up.imag])


def without_arm(
    acc_wheel_mps2: ArrayLike, spin_radps: ArrayLike, sampling_rate_hz: float
) -> FloatArray:
    """Accelerations without what the sensor's distance from the axle adds.

    A sensor at r in the wheel's plane is pulled inward by spin squared times r; on a rim, at speed,
    by more than gravity. This part stands still in the wheel's axes while gravity goes round, so
    that r is found by least squares.

    Parameters
    ----------
    acc_wheel_mps2 : (n, 3) array, m/s², in the wheel's frame: z is the axle
    spin_radps : (n,) array, rad/s
    sampling_rate_hz : Hz

    Returns
    -------
    (n, 3) array, m/s²
    """
    acc = np.array(as_vectors(acc_wheel_mps2, "acc_wheel_mps2", ndim=2))
    rate = as_rate(sampling_rate_hz)
    spin = ndimage.uniform_filter1d(
        as_series(spin_radps, "spin_radps", length=len(acc)), max(1, round(STEADY_S * rate))
    )
    pull = -(spin**2) + 1j * np.gradient(spin) * rate
    power = float((np.abs(pull) ** 2).sum())
    if power == 0:
        return acc
    in_plane = acc[:, 0] + 1j * acc[:, 1]
    part = (np.vdot(pull, in_plane) / power) * pull
    acc[:, 0] -= part.real
    acc[:, 1] -= part.imag
    return acc


def spin_fit(
    acc_wheel_mps2: ArrayLike, spin_radps: ArrayLike, sampling_rate_hz: float
) -> SpinFit | None:
    """How a wheel's spin by gravity goes with its gyroscope's.

    The angle of up is fitted by the gyroscope's angle, time and a constant. Neither radius nor slip
    enters: gravity turns with the wheel itself.

    Parameters
    ----------
    acc_wheel_mps2 : (n, 3) array, m/s², in the wheel's frame: z is the axle
    spin_radps : (n,) array, rad/s, the gyroscope's rate about the axle less the part of the
        chair's turn
    sampling_rate_hz : Hz

    Returns
    -------
    SpinFit, or None where the wheel turns too little, or gravity does not show its turning
    """
    acc = as_vectors(acc_wheel_mps2, "acc_wheel_mps2", ndim=2)
    spin = as_series(spin_radps, "spin_radps", length=len(acc))
    rate = as_rate(sampling_rate_hz)
    acc = without_arm(acc, spin, rate)
    turned = np.cumsum(spin) / rate
    angle = -upward_angle(acc, rate)
    smooth = ndimage.uniform_filter1d(spin, max(1, round(STEADY_S * rate)))
    seen = np.abs(np.gradient(angle)) * rate
    moving = np.maximum(np.abs(smooth), ndimage.uniform_filter1d(seen, max(1, round(rate))))
    if (moving > LEAST_SPIN_RADPS).sum() < SHORTEST_TURNING_S * rate:
        return None
    if max(np.ptp(angle), np.ptp(turned)) < LEAST_TURNED_RAD:
        return None
    time_s = np.arange(len(acc)) / rate
    gain, offset = _first_guess(angle, turned, time_s, rate)
    if gain is None:
        return None
    # Turned back by what the guess explains, up stands nearly still, and can be averaged.
    guess = gain * turned + offset * time_s
    width = max(1, round(STEADY_S * rate))
    in_plane = ndimage.uniform_filter1d(acc[:, 0] + 1j * acc[:, 1], width)
    still = _averaged(in_plane * np.exp(1j * guess), max(1, round(TIED_S * rate)))
    left = guess - np.unwrap(np.angle(still))
    design = np.column_stack([turned, time_s - time_s.mean(), np.ones(len(acc))])
    if np.ptp(turned) < LEAST_TURNED_RAD:
        return None
    found, covariance = fit_by_pieces(design, left, pieces_of(len(acc), PIECE_S, rate))
    scatter = rms(left - design @ found)
    if not scatter < LARGEST_SCATTER_RAD or not abs(found[0]) > LEAST_FACTOR:
        return None
    return SpinFit(
        float(found[0]),
        float(found[1]),
        covariance[:2, :2],
        scatter,
        float(np.ptp(turned)),
        float(time_s[-1]),
    )


def _averaged(values: NDArray[np.complex128], width: int) -> NDArray[np.complex128]:
    return np.asarray(
        ndimage.uniform_filter1d(values.real, width)
        + 1j * ndimage.uniform_filter1d(values.imag, width)
    )


def _first_guess(
    angle: FloatArray, turned: FloatArray, time_s: FloatArray, rate: float
) -> tuple[float | None, float]:
    """Gain and offset from the angles gained in short pieces; a lost turn spoils one piece only."""
    step = max(1, round(PIECE_S * rate / 2))
    gained, read, lasted = (np.diff(v[::step]) for v in (angle, turned, time_s))
    if len(read) < 4 or np.square(read).sum() == 0:
        return None, 0.0
    used = np.ones(len(read), bool)
    gain = offset = 0.0
    for _ in range(4):
        design = np.column_stack([read, lasted])[used]
        gain, offset = np.linalg.lstsq(design, gained[used], rcond=None)[0]
        apart = np.abs(gained - gain * read - offset * lasted)
        used = apart <= max(3 * 1.48 * np.median(apart), 0.3)
        if used.sum() < 4:
            return None, 0.0
    return float(gain), float(offset)


def yaw_rate_of_wheel(
    gyr_wheel_radps: ArrayLike,
    acc_wheel_mps2: ArrayLike,
    camber_rad: float,
    sampling_rate_hz: float,
) -> FloatArray:
    """Chair's yaw rate from one wheel's sensor alone: its rate along up in the wheel's plane.

    Up is what the accelerometer sees, turned along by the gyroscope's spin and averaged, so that
    pushes and the sensor's distance from the axle hardly matter. Slip and radius do not enter.

    Parameters
    ----------
    gyr_wheel_radps, acc_wheel_mps2 : (n, 3) arrays, rad/s and m/s², in the wheel's frame
    camber_rad : rad
    sampling_rate_hz : Hz

    Returns
    -------
    (n,) array, rad/s, left positive
    """
    gyr = as_vectors(gyr_wheel_radps, "gyr_wheel_radps", ndim=2)
    acc = as_vectors(acc_wheel_mps2, "acc_wheel_mps2", length=len(gyr))
    rate = as_rate(sampling_rate_hz)
    acc = without_arm(acc, gyr[:, 2], rate)
    up = up_in_plane(acc[:, :2], gyr[:, 2], rate)
    upward = (gyr[:, :2] * up).sum(axis=1)
    return np.asarray(upward / np.cos(as_number(camber_rad, "camber_rad", negative=True)))
