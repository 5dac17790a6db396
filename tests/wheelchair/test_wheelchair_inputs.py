"""Wheelchair: whatever a function is given, it answers or says what is wrong with it."""

import numpy as np
import pandas as pd
import pytest
from chairs import trials

from mobility_imu.errors import InputError
from mobility_imu.wheelchair import (
    SAMPLE_CHAIR,
    SlipSettings,
    SlipWindows,
    WheelchairGeometry,
    WheelchairMount,
    calibrate_mount,
    check_geometry,
    correct_slip,
    detect_pushes,
    detect_slip,
    estimate_velocity,
    find_faults,
    identify_tasks,
    slip_report,
    slip_sources,
    smooth_recording,
    task_codes,
    task_events,
    wheel_speeds,
)
from mobility_imu.wheelchair.calibration import (
    axle_direction,
    frame_alignment_angles,
    realign,
    wheel_alignment_angles,
)
from mobility_imu.wheelchair.outcomes import onset_errors, turn_direction
from mobility_imu.wheelchair.tasks import curvature_radius, reduce_variability, task_steps
from mobility_imu.wheelchair.uncertainty import (
    velocity_standard_deviation,
    wheel_yaw_standard_deviation,
)
from mobility_imu.wheelchair.velocity import (
    linear_velocity,
    single_wheel_velocity,
    wheel_spin_rate,
    wheel_yaw_rate,
)

COUNT = 60
TIME_S, ONES, CODES = np.arange(COUNT) / 100, np.ones(COUNT), np.ones(COUNT, np.int8)
STATIC, STRAIGHT, DRIVE = (part.recording for part in trials(SAMPLE_CHAIR, 1))
MOUNT = calibrate_mount(STATIC, STRAIGHT).mount
VELOCITY = estimate_velocity(DRIVE, SAMPLE_CHAIR, MOUNT)
WINDOWS = detect_slip(ONES, ONES, 100)
SPEEDS = wheel_speeds(ONES, ONES, ONES, SAMPLE_CHAIR)
VECTORS = np.ones((COUNT, 3))

CALLS = {
    "axle_direction": (axle_direction, [VECTORS]),
    "calibrate_mount": (calibrate_mount, [STATIC, STRAIGHT]),
    "check_geometry": (check_geometry, [DRIVE, SAMPLE_CHAIR, MOUNT]),
    "correct_slip, tool": (
        lambda v, a, windows, fs: correct_slip(v, a, windows, fs, method="tool"),
        [ONES, ONES, WINDOWS, 100],
    ),
    "correct_slip, wheels": (
        lambda v, a, windows, fs, wheels: correct_slip(v, a, windows, fs, wheels=wheels),
        [ONES, ONES, WINDOWS, 100, SPEEDS],
    ),
    "curvature_radius": (curvature_radius, [ONES, ONES]),
    "detect_pushes": (detect_pushes, [TIME_S, ONES]),
    "detect_slip": (detect_slip, [ONES, ONES, 100]),
    "estimate_velocity": (estimate_velocity, [DRIVE, SAMPLE_CHAIR, MOUNT]),
    "frame_alignment_angles": (frame_alignment_angles, [[1, 2, 3]]),
    "identify_tasks": (identify_tasks, [VELOCITY]),
    "linear_velocity": (linear_velocity, [ONES, ONES, SAMPLE_CHAIR]),
    "mount.frame": (MOUNT.frame, [VECTORS]),
    "mount.wheel": (MOUNT.wheel, ["left", VECTORS]),
    "onset_errors": (onset_errors, [CODES, CODES, 100]),
    "realign": (realign, [VECTORS, np.eye(3)]),
    "reduce_variability": (reduce_variability, [CODES, 25]),
    "single_wheel_velocity": (
        lambda rate, yaw, chair, side: single_wheel_velocity(rate, yaw, chair, side=side),
        [ONES, ONES, SAMPLE_CHAIR, "left"],
    ),
    "slip_report": (slip_report, [ONES, ONES, WINDOWS, 100]),
    "slip_sources": (slip_sources, [SPEEDS, ONES, WINDOWS, 100]),
    "smooth_recording": (smooth_recording, [STATIC]),
    "task_codes": (task_codes, [ONES, ONES, 100]),
    "task_events": (task_events, [TIME_S, CODES, ONES, ONES]),
    "task_steps": (task_steps, [ONES, ONES, 100]),
    "turn_direction": (turn_direction, [CODES, ONES]),
    "velocity_standard_deviation": (
        lambda left, right, chair, gyr, radius: velocity_standard_deviation(
            left, right, chair, gyr_sd_radps=gyr, radius_sd_m=radius
        ),
        [ONES, ONES, SAMPLE_CHAIR, 0.01, 0.001],
    ),
    "windows.flags": (WINDOWS.flags, [COUNT]),
    "wheel_alignment_angles": (wheel_alignment_angles, [[1, 2, 3]]),
    "wheel_speeds": (wheel_speeds, [ONES, ONES, ONES, SAMPLE_CHAIR]),
    "wheel_spin_rate": (
        lambda gyr, yaw, camber: wheel_spin_rate(gyr, yaw, camber, side="left"),
        [ONES, ONES, 0.3],
    ),
    "wheel_yaw_rate": (
        lambda left, right, chair, d: wheel_yaw_rate(left, right, chair, distance_m=d),
        [ONES, ONES, SAMPLE_CHAIR, 0.8],
    ),
    "wheel_yaw_standard_deviation": (
        lambda yaw, v, chair, sd: wheel_yaw_standard_deviation(
            yaw, v, chair, gyr_sd_radps=sd, radius_sd_m=sd, distance_sd_m=sd
        ),
        [ONES, ONES, SAMPLE_CHAIR, 0.001],
    ),
    "WheelchairGeometry": (WheelchairGeometry, [0.3, 0.3, 0.3, 0.8]),
    "WheelchairMount": (WheelchairMount, [np.eye(3), np.eye(3), np.eye(3)]),
}
STRANGE = {
    "none": None,
    "text": "abc",
    "empty list": [],
    "short list": [1],
    "square": np.zeros((2, 2)),
    "NaN": np.full(COUNT, np.nan),
    "infinity": np.full(COUNT, np.inf),
    "large": np.full(COUNT, 1e300),
    "texts": np.full(COUNT, "a"),
    "complex": np.full(COUNT, 1j),
    "truth": True,
    "negative": -1,
    "zero": 0,
    "one infinity": np.inf,
    "one NaN": np.nan,
    "largest": 1e308,
    "large vector": [1e300, -1e300, 1e300],
    "largest series": np.full(COUNT, 1.7e308),
    "largest up and down": 1.7e308 * (-1.0) ** np.arange(COUNT),
    "largest vectors": np.full((COUNT, 3), 1.7e308),
    "whole and large": 10**12,
    "whole and larger": 2**70,
    "mapping": {},
    "object": object(),
    "indexed series": pd.Series(ONES, index=range(5, 5 + COUNT)),
    "date": np.datetime64("2026-01-01"),
    "masked": np.ma.masked_array(ONES, mask=np.arange(COUNT) % 2),
    "ragged": [[1], [1, 2]],
    "vectors": VECTORS,
    "vectors of NaN": np.full((COUNT, 3), np.nan),
    "half the samples": ONES[::2],
}


@pytest.mark.parametrize("name", CALLS)
def test_strange_inputs_are_answered_or_refused(name):
    function, good = CALLS[name]
    function(*good)
    for place in range(len(good)):
        for strange in STRANGE.values():
            try:
                function(*good[:place], strange, *good[place + 1 :])
            except InputError as error:
                assert str(error)


def test_flags_are_refused_for_what_is_no_recording():
    """A count that no memory holds is not tried; one that is allowed gives the windows."""
    windows = SlipWindows([2, 7], [3, 7])
    assert np.flatnonzero(windows.flags(9)).tolist() == [2, 3, 7]
    for count in (10**9 + 1, 10**12, 2**70):
        with pytest.raises(InputError, match=rf"count = {count}: expected .* at most 1000000000"):
            windows.flags(count)
    with pytest.raises(InputError, match="ends at sample 7, but there are 7"):
        windows.flags(7)


def test_motion_that_cannot_be_is_named():
    fast = np.ones(COUNT)
    fast[7] = -2e6
    for call in (
        lambda: task_codes(fast, ONES, 100),
        lambda: task_events(TIME_S, CODES, fast, ONES),
        lambda: detect_pushes(TIME_S, fast),
    ):
        with pytest.raises(
            InputError, match=r"linear_velocity_mps: sample 7 is -2e\+06, more than"
        ):
            call()
    with pytest.raises(InputError, match="yaw_rate_radps: sample 7"):
        turn_direction(CODES, fast)


@pytest.mark.parametrize("factor", [1e-200, 1e-100, 1e100, 1e307])
def test_directions_do_not_depend_on_the_size(factor):
    """Squares of such numbers vanish or overflow; the directions are those of the usual size."""
    vector = np.array([1.0, -2.0, 3.0])
    for angles in (wheel_alignment_angles, frame_alignment_angles):
        for form in ("corrected", "printed"):
            found, usual = (angles(v, form=form) for v in (factor * vector, vector))
            assert found == pytest.approx(usual, rel=1e-12)
    turned = np.outer(np.sin(np.arange(COUNT) / 9) + 0.5, vector) + 0.01
    (direction, share), (usual, usual_share) = map(axle_direction, (factor * turned, turned))
    assert direction == pytest.approx(usual, rel=1e-12)
    assert share == pytest.approx(usual_share, rel=1e-6)


def test_a_low_pass_that_no_number_can_hold_is_refused():
    windows = SlipWindows([5], [30])
    for low_pass_hz in (1e-300, 1e-6):
        settings = SlipSettings(low_pass_hz=low_pass_hz)
        with pytest.raises(InputError, match=f"low_pass_hz = {low_pass_hz:g}: expected at least"):
            correct_slip(ONES, ONES, windows, 100, settings, method="tool")
    settings = SlipSettings(low_pass_hz=1e-4)
    assert np.isfinite(correct_slip(ONES, ONES, windows, 100, settings, method="tool")).all()


@pytest.mark.parametrize("look", [estimate_velocity, find_faults, check_geometry])
@pytest.mark.parametrize(
    ("offsets", "says"), [([1], "offsets: "), ({"frame": np.zeros(3)}, r"offsets\['frame'\]: ")]
)
def test_what_are_no_offsets(look, offsets, says):
    with pytest.raises(InputError, match=says):
        look(DRIVE, SAMPLE_CHAIR, MOUNT, offsets=offsets)
