"""Walks of many minutes, in which small errors of the fits are surer than in short ones."""

import pytest

from mobility_imu.simulation import faults as inject
from mobility_imu.simulation.bundle import WALKER_LEVELS
from mobility_imu.simulation.levels import FOOTPRINT, MOUNTS
from mobility_imu.simulation.walker import OUT_AND_BACK_30, attach_imu, simulate_walk
from mobility_imu.walker import find_faults


def walked(seed, level, duration_s=360):
    chosen = WALKER_LEVELS[level]
    motion = simulate_walk(
        OUT_AND_BACK_30, seed=seed, imperfections=chosen.imperfections, duration_s=duration_s
    )
    mount = list(MOUNTS.values())[seed % 5]
    return attach_imu(motion, mount, chosen.sensor, seed=seed, unit_seed=seed)


def scales(walk, recording):
    found = find_faults(recording, FOOTPRINT, walk.mount)
    return [fault.size for fault in found if fault.code == "scale"]


@pytest.mark.parametrize(
    ("seed", "level"), [(900_600, "realistic"), (900_601, "realistic"), (900_600, "real")]
)
def test_a_frame_that_rocks_where_it_stands_has_no_scale(seed, level):
    walk = walked(seed, level)
    assert scales(walk, walk.recording) == []


@pytest.mark.parametrize("factor", [0.85, 1.2])
def test_a_scale_of_a_long_walk_is_told_as_it_is(factor):
    walk = walked(900_602, "realistic")
    (size,) = scales(walk, inject.scale(walk.recording, "frame", "gyr", factor))
    # Six per cent is the smallest that is told; the fit's deviation is 1 to 2 %.
    assert size == pytest.approx(factor - 1, abs=0.06)
