"""Errors of an estimate against a reference: the same functions for ours and for every peer."""

import numpy as np
from scipy import signal

LOW_PASS_ORDER = 2


def low_passed(values, rate_hz, cutoff_hz):
    """Values after a Butterworth filter, forward and backward: no delay."""
    sos = signal.butter(LOW_PASS_ORDER, cutoff_hz, fs=rate_hz, output="sos")
    return signal.sosfiltfilt(sos, values)


def rms(errors):
    """Root mean square of what is finite; NaN if nothing is."""
    errors = np.abs(errors[np.isfinite(errors)])
    return float(np.sqrt(np.mean(errors**2))) if len(errors) else float("nan")


def speed_error(time_s, speed_mps, truth_time_s, truth_mps, cutoff_hz):
    """RMS of a speed, m/s, and found over true path, where there is a reference.

    The estimate is low-passed as the reference was.
    """
    rate_hz = (len(time_s) - 1) / (time_s[-1] - time_s[0])
    found = np.interp(truth_time_s, time_s, low_passed(speed_mps, rate_hz, cutoff_hz))
    there, step = np.isfinite(truth_mps), np.gradient(truth_time_s)
    path = [float(np.abs(v[there]) @ step[there]) for v in (found, truth_mps)]
    return {"rms_mps": rms((found - truth_mps)[there]), "path_ratio": path[0] / path[1]}


def angle_error(angle_rad, truth_rad, also=None):
    """RMS of an angle's error in deg, wrapped to half a turn; ``also`` limits the samples."""
    error = np.rad2deg(np.angle(np.exp(1j * (angle_rad - truth_rad))))
    return rms(error if also is None else error[also])


def path_error(path_m, truth_m):
    """RMS of the horizontal distance to the reference, m; both begin at 0.

    The heading's zero is a matter of choice: the turn that fits best is taken.
    """
    found, true = (p[:, 0] + 1j * p[:, 1] - (p[0, 0] + 1j * p[0, 1]) for p in (path_m, truth_m))
    turn = np.vdot(found, true)
    return rms(found * turn / abs(turn) - true)
