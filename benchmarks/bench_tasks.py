"""Speed and memory of the task identification, beside the plain rendering of the document.

Both run here and now on the same simulated drive; the plain one on a shorter piece of it, since
both take the same time per frame whatever the length. Needed: at least 50 times faster, at most
0.5 microseconds per frame. Exit code 1 if not.
"""

import sys
import time
import tracemalloc

import numpy as np
from plain_tasks import plain_tasks

from mobility_imu.simulation.wheelchair import COURT, IDEAL, random_mounting, simulate_drive
from mobility_imu.wheelchair import SAMPLE_CHAIR, TaskSettings, task_codes

RATE_HZ = 100
SETTINGS = TaskSettings()  # segments of 25 frames
PEER_FRAMES = 12_656
LENGTHS = (12_656, 126_560, 1_300_000)
NEEDED_RATIO = 50
NEEDED_US_PER_FRAME = 0.5


def drive(frames):
    """Velocity and yaw rate of a chair on a court, over and over, with measurement noise."""
    once = simulate_drive(COURT, SAMPLE_CHAIR, random_mounting(1), seed=1, noise=IDEAL)
    rng = np.random.default_rng(1)
    velocity, yaw_rate = (
        np.resize(series, frames) + rng.normal(0, 0.01, frames)
        for series in (once.linear_velocity_mps, once.yaw_rate_radps)
    )
    return velocity, yaw_rate


def seconds(call, repeats):
    """Shortest of some runs: what else the machine does only makes them longer."""
    best = np.inf
    for _ in range(repeats):
        start = time.perf_counter()
        call()
        best = min(best, time.perf_counter() - start)
    return best


def main():
    velocity, yaw_rate = drive(max(LENGTHS))
    segment, look = SETTINGS.frames(RATE_HZ)
    piece = slice(PEER_FRAMES)
    peer = seconds(
        lambda: plain_tasks(velocity[piece], yaw_rate[piece], segment, look, SETTINGS, "covering"),
        3,
    )
    peer_us = 1e6 * peer / PEER_FRAMES
    print(f"{'':24}{'frames':>10}{'s':>9}{'us/frame':>10}{'ratio':>7}{'peak MB':>9}{'B/frame':>9}")
    print(f"{'plain Python':24}{PEER_FRAMES:>10}{peer:>9.3f}{peer_us:>10.3f}{1:>7}")
    good = True
    for frames in LENGTHS:
        v, w = velocity[:frames], yaw_rate[:frames]
        ours = seconds(lambda v=v, w=w: task_codes(v, w, RATE_HZ, SETTINGS), 5)
        tracemalloc.start()
        codes = task_codes(v, w, RATE_HZ, SETTINGS)
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        us = 1e6 * ours / frames
        print(
            f"{'task_codes':24}{frames:>10}{ours:>9.4f}{us:>10.3f}{peer_us / us:>7.0f}"
            f"{peak / 1e6:>9.1f}{peak / frames:>9.0f}"
        )
        good &= peer_us / us >= NEEDED_RATIO and us <= NEEDED_US_PER_FRAME
        if frames == PEER_FRAMES:
            plain = plain_tasks(v, w, segment, look, SETTINGS, "covering")
            different = int((codes != np.array(plain)).sum())
            print(f"  frames labelled differently: {different} of {frames}")
            good &= different == 0
    verdict = "met" if good else "MISSED"
    print(
        f"needed: ratio >= {NEEDED_RATIO}, <= {NEEDED_US_PER_FRAME} us/frame, no difference: "
        f"{verdict}"
    )
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
