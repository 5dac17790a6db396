"""The comparison with peers: its measures, its sentences, and our side of its table.

No peer runs here: each needs an environment of its own.
"""

import json
import subprocess
import sys
from pathlib import Path

import bench_peers
import numpy as np
import peer_environments
import pytest
import real_recordings
from error_measures import angle_error, low_passed, path_error, rms, speed_error

ROOT = Path(__file__).parent.parent


def test_a_turned_and_shifted_path_has_no_error():
    rng = np.random.default_rng(1)
    path = np.cumsum(rng.normal(0, 0.1, (500, 3)), axis=0)
    turn = np.array([[np.cos(2.0), -np.sin(2.0), 0], [np.sin(2.0), np.cos(2.0), 0], [0, 0, 1]])
    assert path_error(path @ turn.T + [3.0, -4.0, 5.0], path) < 1e-12


def test_a_path_twice_as_long_errs_by_the_path():
    path = np.column_stack([np.linspace(0, 10, 101), np.zeros(101), np.zeros(101)])
    assert path_error(2 * path, path) == pytest.approx(rms(path[:, 0]), rel=1e-12)


def test_angles_wrap():
    truth = np.deg2rad(np.array([-179.0, 179.0, np.nan]))
    assert angle_error(np.deg2rad(np.array([179.0, -179.0, 0.0])), truth) == pytest.approx(2.0)


def test_speed_is_judged_where_the_reference_is_and_without_delay():
    """A swing of 0.5 Hz passes the filter of 3 Hz, noise of 20 Hz does not."""
    clock = np.arange(0, 20, 0.02)
    true = 1 + np.sin(2 * np.pi * 0.5 * clock)
    noisy = true + 0.5 * np.sin(2 * np.pi * 20 * clock)
    inner = np.where((clock > 2) & (clock < 18), true, np.nan)
    found = speed_error(clock, noisy, clock, inner, 3.0)
    assert found["rms_mps"] < 0.005
    assert found["path_ratio"] == pytest.approx(1, abs=1e-3)
    assert np.allclose(low_passed(np.ones(100), 50, 3), 1)


@pytest.mark.parametrize("direction", [[9.7, 0.1, -1.1], [0.2, -9.8, 0.3], [0.0, 0.1, -9.8]])
@pytest.mark.parametrize("to", [1, 2])
def test_axes_are_only_exchanged(direction, to):
    """Each entry is 0, 1 or -1, right-handed, and the largest component comes to the axis."""
    matrix = real_recordings.exchanged(to, np.array(direction))
    assert set(np.abs(matrix).ravel()) == {0.0, 1.0}
    assert np.linalg.det(matrix) == pytest.approx(1)
    assert (matrix @ direction)[to] == np.abs(direction).max()


def test_without_recordings_it_says_so():
    """Exit code 0, one sentence for each set, nothing installed."""
    environment = {"PATH": "", "PYTHONPATH": str(ROOT), "MOBILITY_IMU_CACHE": str(ROOT / "none")}
    done = subprocess.run(
        [sys.executable, str(ROOT / "benchmarks" / "bench_peers.py")],
        capture_output=True, text=True, env=environment, cwd=ROOT,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert len(done.stdout.splitlines()) == len(real_recordings.SETS)
    assert all("mobility-imu fetch" in line for line in done.stdout.splitlines())


def test_without_a_network_it_says_so(monkeypatch, tmp_path):
    failing = subprocess.CompletedProcess([], 1, "", "first\nERROR: no network\n")
    monkeypatch.setattr(peer_environments.subprocess, "run", lambda *_, **__: failing)
    with pytest.raises(peer_environments.NotInstalled, match=r"^qmt: .*no network"):
        peer_environments.peer_python("qmt", tmp_path)


def test_each_set_has_a_script_and_a_list_of_packages():
    for one in real_recordings.SETS:
        assert (peer_environments.HERE / one.script).is_file()
        listed = (peer_environments.HERE / f"requirements-{one.peer}.txt").read_text()
        assert f"{one.peer}==" in listed


def test_medians_are_over_recordings_with_both():
    nan = float("nan")
    errors = {
        name: {"peer": {"e": peer}, "ours": {"e": ours}}
        for name, peer, ours in (("a", 1.0, 2.0), ("b", 3.0, 1.0), ("c", 9.0, nan))
    }
    assert bench_peers.medians(errors, "e") == [2.0, 1.5]


CHAIRS = next(one for one in real_recordings.SETS if one.name == "chairs")


@pytest.mark.skipif(real_recordings.available(CHAIRS) is None, reason="mocap-chair is not here")
def test_our_side_of_the_chairs():
    """Prepared for all trials; what a peer is given is finite; ours errs by 0.06 m/s at most."""
    cases = CHAIRS.cases(real_recordings.available(CHAIRS))
    assert len(cases) >= 20
    for case in cases:
        assert len(case.sha256) == 64
        assert all(np.isfinite(value).all() for value in case.given.values())
        up = case.given["frame_acc"][:50].mean(axis=0)
        assert up[2] > 9
        assert case.judge(case.ours)["rms_mps"] <= 0.06
    errors = bench_peers.compared(cases, {})
    assert json.loads(json.dumps(errors)) == errors
