"""Scooter angles: our form against the literal one, a memory copy, and the obvious filter calls.

CPU time per sample, median of several rounds in which all peers take turns.
"""

import time

import numpy as np
from scipy import signal

from mobility_imu.filters import median_filter
from mobility_imu.scooter import SUZUKI_ET4D
from mobility_imu.scooter.angles import three_axis_angles
from mobility_imu.scooter.geometry import body_specific_force, lever_acceleration


def literal(lever, body, geometry):
    """Equations (6) and (7) typed as they are printed."""
    alpha, beta = geometry.steering_inclination_rad, geometry.lever_inclination_rad
    x, y, z = body[:, 0], body[:, 1], body[:, 2]
    c1 = y * np.cos(alpha) + z * np.sin(alpha)
    steering = np.arcsin(lever[:, 0] / np.sqrt(x**2 + c1**2)) - np.arctan(x / c1)
    k1 = -y * np.sin(alpha) + z * np.cos(alpha)
    k2 = (
        -x * np.sin(steering)
        + y * np.cos(steering) * np.cos(alpha)
        + z * np.cos(steering) * np.sin(alpha)
    )
    throttle = np.arctan(k2 / k1) - np.arcsin(lever[:, 1] / np.sqrt(k1**2 + k2**2))
    return steering, throttle - (alpha - beta)


def ride(count):
    rng = np.random.default_rng(1)
    body = body_specific_force(rng.uniform(-0.1, 0.1, count), rng.uniform(-0.1, 0.1, count))
    steering, throttle = rng.uniform(-0.8, 0.8, count), rng.uniform(0, 0.7, count)
    lever = lever_acceleration(body, steering, throttle, SUZUKI_ET4D)
    return np.ascontiguousarray(lever), np.ascontiguousarray(body), steering, throttle


def nanoseconds(calls, count, rounds):
    spent = {name: [] for name in calls}
    for _ in range(rounds):
        for name, call in calls.items():
            start = time.process_time()
            call()
            spent[name].append(time.process_time() - start)
    return {name: float(np.median(times)) / count * 1e9 for name, times in spent.items()}


def main():
    count = 1_000_000
    lever, body, steering, throttle = ride(count)
    ours = three_axis_angles(lever, body, SUZUKI_ET4D)
    assert np.abs(ours[0] - steering).max() < 1e-12 and np.abs(ours[1] - throttle).max() < 1e-12
    # Six inputs and two outputs of eight bytes, each read or written once.
    source, target = np.ones(8 * count), np.empty(8 * count)
    ns = nanoseconds(
        {
            "ours": lambda: three_axis_angles(lever, body, SUZUKI_ET4D),
            "literal": lambda: literal(lever, body, SUZUKI_ET4D),
            "copy of the same bytes": lambda: np.copyto(target, source),
        },
        count,
        7,
    )
    print(
        f"angles, {count} samples (ns per sample): " + str({k: round(v, 1) for k, v in ns.items()})
    )
    print(f"  {ns['literal'] / ns['ours']:.1f} times faster than the literal form (at least 2)")
    print(f"  {ns['ours'] / ns['copy of the same bytes']:.1f} times a memory copy (at most 6)")

    count = 100_000
    lever, body = lever[:count], body[:count]
    ns = nanoseconds(
        {
            "ours": lambda: three_axis_angles(
                median_filter(lever, 25), median_filter(body, 25), SUZUKI_ET4D
            ),
            "obvious": lambda: literal(
                signal.medfilt(lever, (25, 1)), signal.medfilt(body, (25, 1)), SUZUKI_ET4D
            ),
        },
        count,
        3,
    )
    print(f"with 25-median, {count} samples (ns): " + str({k: round(v) for k, v in ns.items()}))
    print(
        f"  {ns['obvious'] / ns['ours']:.1f} times faster than 2-D medfilt + literal (at least 8)"
    )


if __name__ == "__main__":
    np.seterr(invalid="ignore")  # medfilt's zero-padded ends have no angle in the literal form
    main()
