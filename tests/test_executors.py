"""Work spread over processes gives the same bytes as one process.

A process pool here; ``make check STEP=dask`` runs the same on a Dask cluster.
"""

import dataclasses
import os
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import contextmanager
from functools import partial
from multiprocessing import get_context
from operator import call
from threading import Event

import numpy as np
import pandas as pd
import pytest

from mobility_imu.errors import InputError
from mobility_imu.executors import run_all
from mobility_imu.reproduction.scooter.driving import StudySettings, driving_study
from mobility_imu.reproduction.walker.studies import LEVELS, calibration_study, tilt_run
from mobility_imu.scooter import estimate_ride
from mobility_imu.scooter.angles import estimate_angles
from mobility_imu.scooter.geometry import SUZUKI_ET4D
from mobility_imu.simulation.scooter import COURSES, draw_driver, draw_scooter, simulate_ride
from mobility_imu.simulation.walker import RECTANGLE, attach_imu, simulate_walk
from mobility_imu.simulation.wheelchair import (
    COURT,
    STATIC_TRIAL,
    STRAIGHT_TRIAL,
    random_mounting,
    simulate_drive,
)
from mobility_imu.walker import estimate_trajectory
from mobility_imu.wheelchair import SAMPLE_CHAIR, calibrate_mount, estimate_velocity


@contextmanager
def dask_executor():
    from dask.distributed import Client, LocalCluster

    with (
        LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        Client(cluster) as client,
    ):
        yield client.get_executor()


@pytest.fixture(scope="module")
def executor():
    if os.environ.get("MOBILITY_IMU_EXECUTOR") == "dask":
        with dask_executor() as pool:
            yield pool
    else:
        with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
            yield pool


def parts(value):
    """All that a result holds, as bytes and text."""
    if isinstance(value, np.ndarray):
        yield f"{value.dtype}{value.shape}".encode() + np.ascontiguousarray(value).tobytes()
    elif isinstance(value, pd.DataFrame):
        yield value.to_csv().encode()
    elif dataclasses.is_dataclass(value):
        for field in dataclasses.fields(value):
            yield from parts(getattr(value, field.name))
    elif hasattr(value, "items"):
        for key, one in value.items():
            yield repr(key).encode()
            yield from parts(one)
    elif isinstance(value, list | tuple):
        for one in value:
            yield from parts(one)
    else:
        yield repr(value).encode()


def same(function, arguments, executor):
    """Results of one process, once those of the executor are found to be the same."""
    here, there = run_all(function, arguments), run_all(function, arguments, executor)
    for one, other in zip(here, there, strict=True):
        assert type(one) is type(other)
        assert list(parts(one)) == list(parts(other))
    return here


def test_results_come_in_the_order_of_the_arguments(executor):
    assert run_all(pow, [(k, 2) for k in range(20)], executor) == [k**2 for k in range(20)]
    assert run_all(pow, [], executor) == run_all(pow, []) == []


def test_a_call_that_fails_raises_and_cancels_those_that_wait():
    gate, done = Event(), []

    def work(k):
        if k == 0:
            raise ZeroDivisionError
        gate.wait(10)
        done.append(k)

    with ThreadPoolExecutor(1) as pool:
        with pytest.raises(ZeroDivisionError):
            run_all(work, [(k,) for k in range(50)], pool)
        gate.set()
    assert len(done) <= 1  # the one that ran already


def test_scooter_rides_and_angles(executor):
    unit, driver = draw_scooter(1), draw_driver(1)
    drive = partial(simulate_ride, COURSES["side"], unit=unit, driver=driver)
    rides = same(call, [(partial(drive, seed=seed),) for seed in (1, 2)], executor)
    both = [[r.recording.sensor(name).acc_mps2 for name in ("lever", "body")] for r in rides]
    same(estimate_angles, [(*two, SUZUKI_ET4D) for two in both], executor)


def test_scooter_study(executor):
    settings = StudySettings(drivers=1, runs=1, courses=("side",), histograms=True)
    here = driving_study([0, 1], settings)
    there = driving_study([0, 1], settings, executor=executor)
    assert list(parts(here)) == list(parts(there))


def test_wheelchair_drives_and_velocities(executor):
    mounting = random_mounting(1)
    drive = partial(simulate_drive, seed=1)
    legs = [(trial, SAMPLE_CHAIR, mounting) for trial in (STATIC_TRIAL, STRAIGHT_TRIAL, COURT)]
    static, straight, court = (one.recording for one in same(drive, legs, executor))
    mount = calibrate_mount(static, straight).mount
    same(estimate_velocity, [(court, SAMPLE_CHAIR, mount)] * 2, executor)
    listed = estimate_velocity([court, court], SAMPLE_CHAIR, mount, executor=executor)
    assert list(parts(listed[0])) == list(parts(listed[1]))


def test_walker_walks_and_paths(executor):
    level = LEVELS["realistic"]
    (tilts, _), *_ = same(tilt_run, [(seed, "1", level) for seed in (0, 1)], executor)
    motion = simulate_walk(RECTANGLE, seed=1, imperfections=level.imperfections)
    walk = attach_imu(motion, tilts.mount, level.sensor, seed=1, unit_seed=1)
    same(estimate_trajectory, [(walk.recording, None, walk.mount)] * 2, executor)


def test_walker_study(executor):
    levels = {"realistic": LEVELS["realistic"]}
    here = calibration_study([0, 1], levels, poses=("1",))
    there = calibration_study([0, 1], levels, poses=("1",), executor=executor)
    assert list(parts(here)) == list(parts(there))


@pytest.mark.parametrize("wrong", [ThreadPoolExecutor, 3, "abc", object()], ids=range(4))
def test_what_takes_no_work_is_no_executor(wrong):
    """The class of an executor has a ``submit`` too, and cannot take work."""
    with pytest.raises(InputError, match="expected an object with submit"):
        run_all(pow, [(2, 3)], wrong)
    with pytest.raises(InputError, match="expected an object with submit"):
        estimate_ride([], SUZUKI_ET4D, executor=wrong)
