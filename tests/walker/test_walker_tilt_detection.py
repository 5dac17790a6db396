"""Walker: which tilts a recording holds, and in which order."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from walker_recordings import DATASHEET, FRAME, changed, cut_out, errors, pose_mount, tilt_recording

from mobility_imu.errors import InputError
from mobility_imu.simulation.sensor import IDEAL
from mobility_imu.simulation.walker import (
    CORRIDOR,
    PERFECT,
    attach_imu,
    simulate_tilts,
    simulate_walk,
)
from mobility_imu.walker import (
    NavigationSettings,
    calibrate_mount,
)
from mobility_imu.walker.follow import navigate_recording
from mobility_imu.walker.tilt_detection import _end_of_movement, find_tilts


def test_recording_that_ends_in_a_tilt():
    recording = tilt_recording()
    last = simulate_tilts(FRAME, seed=0).tilts[-1]
    short = cut_out(recording, recording.time_s < last.held_until_s)
    two = simulate_tilts(FRAME, seed=0).tilts[1].stop_s + 1
    front_and_back = cut_out(recording, recording.time_s < two)
    found = calibrate_mount(short, FRAME)
    assert len(found.tilts) == 3 and np.abs(errors(found, "1")[0]).max() < 0.01
    assert any("does not come back before the recording ends" in said for said in found.warnings)
    with pytest.raises(InputError, match="missing: left"):
        calibrate_mount(short, FRAME, method="four-tilts")
    with pytest.raises(InputError, match="missing: right"):
        calibrate_mount(front_and_back, FRAME, method="two-tilts", order=("front", "back"))
    with pytest.raises(InputError, match="one to the right or left"):
        calibrate_mount(front_and_back, FRAME, order=("front", "back"))
    # One pair of opposite tilts fits the order in two ways.
    with pytest.raises(InputError, match="front, back or right, left: state which"):
        calibrate_mount(front_and_back, FRAME)


def test_tilts_below_ten_degrees_are_left_out():
    from mobility_imu.simulation.walker import TiltStyle

    small = simulate_tilts(FRAME, seed=3, style=TiltStyle(angle_rad=(np.deg2rad(6), np.deg2rad(8))))
    recording = attach_imu(small, pose_mount("1"), DATASHEET, seed=1, unit_seed=1).recording
    with pytest.raises(InputError, match=r"no tilt found.*reaches only [67]\.\d deg"):
        calibrate_mount(recording, FRAME)
    with pytest.raises(InputError, match="no tilt found"):
        calibrate_mount(cut_out(recording, recording.time_s < 2.4), FRAME)


def test_a_lost_first_tilt_does_not_turn_the_mount():
    """What is left of the stated order says which tilts these are, or that nothing can be said."""
    recording, truth = tilt_recording(), simulate_tilts(FRAME, seed=0).tilts
    late = cut_out(recording, recording.time_s > truth[0].held_until_s + 0.3)
    found = calibrate_mount(late, FRAME)
    assert [tilt.direction for tilt in found.tilts] == ["back", "right", "left"]
    assert np.abs(errors(found, "1")[0]).max() < 0.01
    assert any("no tilt to the front found" in said for said in found.warnings)
    later = cut_out(recording, recording.time_s > truth[1].held_until_s + 0.3)
    with pytest.raises(InputError, match="front, back or right, left: state which"):
        calibrate_mount(later, FRAME)


def test_a_small_first_tilt_still_names_the_others():
    """The first tilt of 8 deg is left out, but not forgotten."""
    recording = tilt_recording(0, "1", IDEAL)
    path, _ = navigate_recording(recording)
    tilts, _ = find_tilts(path)
    attitude = Rotation.from_quat(path.quaternion, scalar_first=True)
    span = tilts[0].span
    lean = (attitude[span.start].inv() * attitude[span]).as_rotvec()
    small = lean * np.deg2rad(8) / tilts[0].angle_rad
    quaternion = path.quaternion.copy()
    quaternion[span] = (attitude[span.start] * Rotation.from_rotvec(small)).as_quat(
        scalar_first=True
    )
    left, said = find_tilts(changed(path, quaternion=quaternion))
    assert [tilt.direction for tilt in left] == ["back", "right", "left"]
    assert any("reaches only 8.0 deg" in text for text in said)
    # Back and right alone also fit front and left: the order has to be stated.
    cut = cut_out(recording, recording.time_s > 7.0)
    two = cut_out(cut, cut.time_s < simulate_tilts(FRAME, seed=0).tilts[2].stop_s + 1)
    with pytest.raises(InputError, match="state which ones were made"):
        calibrate_mount(two, FRAME)
    assert len(calibrate_mount(two, FRAME, order=("back", "right")).tilts) == 2


def test_a_walk_is_not_taken_for_tilts():
    walk = attach_imu(simulate_walk(CORRIDOR, seed=1), pose_mount("1"), DATASHEET, seed=1, unit_seed=1)  # noqa: E501  # fmt: skip
    with pytest.raises(InputError, match="is this a walk") as caught:
        calibrate_mount(walk.recording, FRAME)
    assert len(str(caught.value)) < 400


def test_tilts_in_another_order_are_recognised():
    """Only which way the first went has to be known."""
    order = ("front", "left", "right", "back")
    recording = tilt_recording(5, "3", DATASHEET, PERFECT, order)
    found = calibrate_mount(recording, FRAME)
    assert [tilt.direction for tilt in found.tilts] == list(order)
    assert any("front, left, right, back" in said for said in found.warnings)
    assert np.abs(errors(found, "3")[0]).max() < 0.01
    assert not calibrate_mount(recording, FRAME, order=order).warnings
    # A wrong first direction by a quarter turn: width and length come out swapped.
    turned = calibrate_mount(recording, FRAME, order=("right", "front", "back", "left"))
    assert any("other way round" in said for said in turned.warnings)
    # A width that is 12 cm off, with the length as it is, does not look swapped.
    wide = replace(FRAME, footprint_width_m=FRAME.footprint_width_m + 0.12)
    sensor = NavigationSettings.for_calibrated_sensor()
    told = calibrate_mount(recording, wide, order=order, settings=sensor).warnings
    (said,) = [text for text in told if "m, measured" in text]
    assert "other way round" not in said and "width" in said
    with pytest.raises(InputError, match="expected names out of"):
        calibrate_mount(recording, FRAME, order=("up",))


def test_tilt_across_a_corner_is_refused():
    path, _ = navigate_recording(tilt_recording())
    tilts, _ = find_tilts(path)
    # Turn the frame's attitude about the vertical during the second tilt only, by 40 deg.
    attitude = Rotation.from_quat(path.quaternion, scalar_first=True)
    up = Rotation.from_rotvec([0, 0, np.deg2rad(40)])
    span = tilts[1].span
    inside = np.zeros(len(path.time_s), bool)
    inside[span.start + 1 : span.stop - 1] = True
    lean = attitude[span.start].inv() * attitude
    turned = attitude[span.start] * (
        attitude[span.start].inv() * up * attitude[span.start]
    ) * lean * (attitude[span.start].inv() * up * attitude[span.start]).inv()  # fmt: skip
    mixed = np.where(inside[:, None], turned.as_quat(scalar_first=True), path.quaternion)
    with pytest.raises(InputError, match=r"(39|40|41) deg off"):
        find_tilts(changed(path, quaternion=mixed))


def test_a_movement_ends_in_the_middle_of_what_is_held_at_the_top():
    """Still at the foot, half way up (as hands change) and at the top: only the top counts."""
    up = np.r_[np.zeros(20), np.linspace(0, 0.3, 30), np.full(40, 0.3)]
    lean = np.r_[up, np.linspace(0.3, 0.6, 30), np.full(51, 0.6), np.linspace(0.6, 0, 60)]
    still = np.zeros(len(lean), bool)
    still[:20] = still[50:90] = still[120:171] = True
    assert _end_of_movement(lean, still, slice(0, len(lean))) == 145
    lean[170] = 0.61  # nothing held: the largest angle
    assert _end_of_movement(lean, np.zeros(len(lean), bool), slice(10, len(lean))) == 170


def test_a_tilt_lasts_from_the_last_rest_before_it_to_the_first_after():
    path, _ = navigate_recording(tilt_recording(0, "1", IDEAL))
    tilts, _ = find_tilts(path)
    up = path.rotation_imu_to_world()[:, 2]
    lean = np.arccos(np.clip(up @ up[int(np.argmax(path.still))], -1, 1))
    upright = path.still & (lean < np.deg2rad(2))
    assert len(tilts) == 4
    for tilt in tilts:
        span = tilt.span
        assert upright[span.start] and upright[span.stop - 1]
        assert not upright[span.start + 1 : span.stop - 1].any()
        assert span.start < tilt.top < span.stop and np.isclose(lean[tilt.top], tilt.angle_rad)
