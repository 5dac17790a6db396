"""Walker: error-state filter with smoother, beside gaitmap's RtsKalman on the same recording.

Each runs in its own interpreter, in turns, warm; CPU time per sample, median of the rounds, each
with its own detector of stillness. Ours carries 15 states (biases too) and gives the smoothed
standard deviations, gaitmap's 9. The covariance goes in strides of up to 8 samples, as is standard;
the time with a step of it per sample is given beside. Then the readable form, which works without
numba, and what a user waits for: the first call ever, which compiles nothing, the compiler, the
first call of a later process, and the memory for one hour. Exit code 1 if something needed is
missed.
"""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

# One thread each, or CPU time says little. Before NumPy is loaded.
for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[name] = "1"
os.environ["MOBILITY_IMU_COMPILE"] = "always"

import time  # noqa: E402

import numpy as np  # noqa: E402
from scipy.spatial.transform import Rotation  # noqa: E402

from mobility_imu.reproduction.walker.tables import pose_mount  # noqa: E402
from mobility_imu.simulation.walker import (  # noqa: E402
    RECTANGLE,
    WalkStyle,
    attach_imu,
    simulate_walk,
)
from mobility_imu.walker import navigation  # noqa: E402
from mobility_imu.walker.navigation import NavigationSettings, navigate  # noqa: E402
from mobility_imu.walker.stillness import find_stillness  # noqa: E402

HERE = Path(__file__).parent
PEER_PYTHON = Path(sys.prefix) / "gaitmap" / "bin" / "python"  # made by ``make bench``
RATE_HZ = 100.0
ROUNDS = 9
NEEDED = {
    "ratio": 5,
    "readable, us": 150,
    "readable, a step per sample, us": 500,
    "first path, s": 5,
    "compiling, s": 15,
    "reload, s": 2,
    "one hour, GB": 1,
}

FIRST_CALL = """
import json, resource, sys, time
start = time.perf_counter()
import numpy as np
from mobility_imu.walker.navigation import navigate
imported = time.perf_counter()
seconds = float(sys.argv[1])
rng = np.random.default_rng(0)
clock = np.arange(int(seconds * 100)) / 100
acc = np.array([0.0, 0.0, 9.80665]) + 0.01 * rng.standard_normal((len(clock), 3))
gyr = 0.001 * rng.standard_normal((len(clock), 3))
before = time.perf_counter()
navigate(clock, acc, gyr, clock % 3 < 1.5)
now = time.perf_counter()
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
print(json.dumps({"import": imported - start, "call": now - before, "peak_GB": peak}))
"""


def walk():
    """A round of 17.5 m with short stances; about 40 % of the samples are still."""
    motion = simulate_walk(RECTANGLE, seed=1, style=WalkStyle(stance_s=(0.8, 1.2)))
    made = attach_imu(motion, pose_mount("4"), seed=1, unit_seed=1, sampling_rate_hz=RATE_HZ)
    imu = made.recording.sensor("frame")
    quaternion = Rotation.from_matrix(made.rotation_imu_to_world[0]).as_quat()
    return made.recording.time_s, imu.acc_mps2, made.recording.gyroscope("frame"), quaternion


def in_process(cache, seconds, compiling=""):
    """First call in a new process, with numba's cache in a given folder."""
    env = {**os.environ, "NUMBA_CACHE_DIR": cache, "MOBILITY_IMU_COMPILE": compiling}
    command = [sys.executable, "-c", FIRST_CALL, str(seconds)]
    out = subprocess.run(command, env=env, check=True, capture_output=True, text=True).stdout
    return json.loads(out)


def start_peer(folder, acc, gyr, quaternion):
    file = Path(folder) / "walk.npz"
    np.savez(file, acc=acc, gyr=gyr, quaternion=quaternion, rate_hz=RATE_HZ, window_s=0.3)
    command = [str(PEER_PYTHON), "-W", "ignore", str(HERE / "peer_gaitmap.py"), str(file)]
    env = {**os.environ, "NUMBA_CACHE_DIR": folder}
    return subprocess.Popen(
        command, env=env, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )


def ask(peer):
    """CPU seconds, fraction of zero-velocity updates and age of the peer after one run."""
    peer.stdin.write("run\n")
    peer.stdin.flush()
    return [float(part) for part in peer.stdout.readline().split()]


def main():
    clock, acc, gyr, quaternion = walk()
    count = len(clock)

    textbook = NavigationSettings(moving_stride=1, resting_stride=1)

    def ours(settings=None, *, smooth=True):
        start = time.process_time()
        still = find_stillness(acc, gyr, RATE_HZ)
        navigate(clock, acc, gyr, still, settings, smooth=smooth)
        return time.process_time() - start

    good = True

    def verdict(name, value, text, *, least=False):
        nonlocal good
        met = value >= NEEDED[name] if least else value <= NEEDED[name]
        good &= met
        bound = "at least" if least else "at most"
        print(f"  {text} ({bound} {NEEDED[name]}: {'met' if met else 'MISSED'})")

    resting = find_stillness(acc, gyr, RATE_HZ).mean()
    print(f"walk of {count} samples; microseconds of CPU per sample, median of {ROUNDS} rounds")
    with tempfile.TemporaryDirectory() as folder:
        peer = start_peer(folder, acc, gyr, quaternion) if PEER_PYTHON.exists() else None
        if peer is not None:
            cold = ask(peer)
            ask(peer)
        ours(), ours(smooth=False)
        spent = {"ours": [], "ours, filter only": [], "ours, textbook": [], "gaitmap": []}
        for _ in range(ROUNDS):
            if peer is not None:
                spent["gaitmap"].append(ask(peer)[0])
            spent["ours"].append(ours())
            spent["ours, filter only"].append(ours(smooth=False))
            spent["ours, textbook"].append(ours(textbook))
        us = {name: 1e6 * np.median(times) / count for name, times in spent.items() if times}
        if peer is not None:
            peer.stdin.close()
            peer.wait()
    print(f"  ours, filter and smoother {us['ours']:.2f}, filter only {us['ours, filter only']:.2f}"
          f", a step of the covariance and an update per sample {us['ours, textbook']:.2f}; "
          f"still {100 * resting:.0f} %")  # fmt: skip
    if peer is None:
        good = False
        print(f"  gaitmap is not installed ({PEER_PYTHON}): run make bench with a network")
    else:
        print(f"  gaitmap RtsKalman {us['gaitmap']:.2f}; zero velocity {100 * cold[1]:.0f} %; "
              f"import and first run {cold[2]:.1f} s")  # fmt: skip
        ratio = us["gaitmap"] / us["ours"]
        verdict("ratio", ratio, f"{ratio:.1f} times faster than gaitmap", least=True)

    navigation.choose = lambda *_, **__: "plain"
    for name, chosen in (("readable, us", None), ("readable, a step per sample, us", textbook)):
        spent = 1e6 * min(ours(chosen) for _ in range(2)) / count
        verdict(name, spent, f"readable form{', a step per sample' * bool(chosen)}: {spent:.0f} us")

    with tempfile.TemporaryDirectory() as cache:
        first = in_process(cache, 120)
        cold = in_process(cache, 60, compiling="always")
        warm, hour = (in_process(cache, seconds) for seconds in (60, 3600))
    verdict(
        "first path, s",
        first["import"] + first["call"],
        f"first path of two minutes, nothing compiled: import {first['import']:.1f} + call "
        f"{first['call']:.1f} s",
    )
    verdict("compiling, s", cold["call"], f"a path with compiling: {cold['call']:.1f} s")
    again = warm["import"] + warm["call"]
    verdict(
        "reload, s",
        again,
        f"later process: import {warm['import']:.2f} + call {warm['call']:.2f} s",
    )
    verdict(
        "one hour, GB",
        hour["peak_GB"],
        f"one hour at 100 Hz: {hour['call']:.2f} s, peak {hour['peak_GB']:.2f} GB",
    )
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
