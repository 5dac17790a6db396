"""Walker: the equations of the calibration against plane geometry."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from walker_recordings import FRAME

from mobility_imu.errors import InputError
from mobility_imu.reproduction.walker.tables import pose_mount
from mobility_imu.walker.geometry import TILT_DIRECTIONS, rotation_body_to_world
from mobility_imu.walker.tilt_equations import (
    arm_angle,
    distance_to_edge,
    forward_axis,
    imu_height,
    position_four_tilts,
    position_gain,
    position_two_tilts,
    quaternion_from_rotation,
    rotation_imu_to_body,
    tilt_angle,
    tilt_displacement,
    tilt_quaternion,
    tilt_rotation,
)

# Inside the footprint and clear of its edges, where the printed eq. 15 is valid too.
PLACES = st.tuples(
    st.floats(0.02, 0.50), st.floats(-0.28, 0.28), st.floats(0.1, 0.9)
)  # fmt: skip


def edge_distances(place):
    """Distances of a place from the four edges, by plane geometry."""
    x, y, z = place
    width, length = FRAME.footprint_width_m, FRAME.footprint_length_m
    return {
        "front": np.hypot(length - x, z),
        "back": np.hypot(x, z),
        "right": np.hypot(y + width / 2, z),
        "left": np.hypot(width / 2 - y, z),
    }


def tilted(place, direction, angle):
    """Place of a point of the frame after a tilt, and the tilt's rotation."""
    edge = FRAME.edge(direction)
    turn = Rotation.from_rotvec(angle * edge.axis)
    return edge.point_m + turn.apply(np.asarray(place) - edge.point_m), turn.as_matrix()


@given(PLACES, st.sampled_from(TILT_DIRECTIONS), st.floats(0.2, 0.8))
@settings(max_examples=50, deadline=None)
def test_eq3_eq13_chord_and_angle_give_the_distance(place, direction, angle):
    end, _ = tilted(place, direction, angle)
    chord = tilt_displacement([place, end])
    assert np.isclose(
        distance_to_edge(np.linalg.norm(chord), angle), edge_distances(place)[direction]
    )


def test_eq3_points_forward_in_a_backward_tilt():
    end, _ = tilted((0.3, 0.1, 0.6), "back", 0.5)
    assert tilt_displacement([(0.3, 0.1, 0.6), end])[0] > 0


@given(PLACES, st.floats(-3, 3), st.floats(0.2, 0.8))
@settings(max_examples=30, deadline=None)
def test_eq4_eq5_forward_axis_of_a_turned_frame(place, heading, angle):
    end, _ = tilted(place, "back", angle)
    to_world = Rotation.from_rotvec([0, 0, heading])
    axis = forward_axis(to_world.apply(tilt_displacement([place, end])))
    assert np.allclose(axis, [np.cos(heading), np.sin(heading), 0], atol=1e-9)
    with pytest.raises(InputError, match="no horizontal part"):
        forward_axis([0, 0, 0.1])


@given(st.integers(0, 10**6), st.floats(-3, 3))
@settings(max_examples=30, deadline=None)
def test_eq7_recovers_the_mounting(seed, heading):
    """Printed without the transpose it does not: it composes body-to-world with IMU-to-world."""
    mounting = Rotation.random(random_state=seed)
    world = rotation_body_to_world([np.cos(heading), np.sin(heading), 0.0])
    q = (Rotation.from_matrix(world) * mounting).as_quat(scalar_first=True)
    assert np.allclose(rotation_imu_to_body(world, q), mounting.as_matrix(), atol=1e-12)
    printed = world @ Rotation.from_quat(q, scalar_first=True).as_matrix()
    assert abs(np.sin(heading)) < 0.1 or not np.allclose(printed, mounting.as_matrix(), atol=0.05)


@given(st.integers(0, 10**6), st.sampled_from(TILT_DIRECTIONS), st.floats(0.1, 1.0))
@settings(max_examples=30, deadline=None)
def test_eq8_to_eq12_angle_and_axis_of_a_tilt(seed, direction, angle):
    mounting = Rotation.random(random_state=seed)
    _, turn = tilted((0.3, 0.1, 0.6), direction, angle)
    world = rotation_body_to_world([0.6, 0.8, 0.0])
    end = (Rotation.from_matrix(world @ turn) * mounting).as_quat(scalar_first=True)
    found = quaternion_from_rotation(tilt_rotation(world, end, mounting.as_matrix()))
    assert np.allclose(found, tilt_quaternion(FRAME.edge(direction).axis, angle), atol=1e-9)
    assert np.isclose(tilt_angle(found), angle) and np.isclose(
        tilt_angle(found, form="printed"), angle
    )


def test_eq10_refuses_half_a_turn():
    with pytest.raises(InputError, match="half a turn"):
        quaternion_from_rotation(np.diag([1.0, -1.0, -1.0]))


def test_eq12_arc_cosine_is_blind_near_zero():
    """At 1e-9 rad the scalar part rounds to 1: the printed form says 0."""
    small = tilt_quaternion([0, 1, 0], 1e-9)
    assert tilt_angle(small, form="printed") == 0.0
    assert np.isclose(tilt_angle(small), 1e-9, rtol=1e-9)
    # Rounding may leave a scalar part beyond 1: no turn, or a whole one.
    assert tilt_angle([1 + 1e-12, 0, 0, 0], form="printed") == 0.0
    assert np.isclose(tilt_angle([-1 - 1e-12, 0, 0, 0], form="printed"), 2 * np.pi)
    with pytest.raises(InputError, match="angle_rad"):
        distance_to_edge(0.1, 0.0)


@given(PLACES)
@settings(max_examples=50, deadline=None)
def test_eq14_eq15_give_the_place_back(place):
    distances = edge_distances(place)
    assert np.isclose(imu_height(distances, FRAME), place[2], atol=1e-7)
    for form in ("corrected", "printed"):
        assert np.allclose(position_four_tilts(distances, FRAME, form=form), place, atol=1e-5), form


def test_eq15_printed_loses_the_sign_outside_the_footprint():
    outside = (-0.05, 0.35, 0.6)
    distances = edge_distances(outside)
    assert np.allclose(position_four_tilts(distances, FRAME), outside)
    assert np.allclose(
        position_four_tilts(distances, FRAME, form="printed"), [0.05, 0.30, 0.6], atol=1e-9
    )
    with pytest.raises(InputError, match="more than the distance to the back edge"):
        wrong = {**edge_distances((0.05, 0.0, 0.6)), "back": 0.59}
        position_four_tilts(wrong, FRAME, form="printed")
    with pytest.raises(InputError, match="no triangle"):
        imu_height({**distances, "right": 0.1, "left": 0.1}, FRAME)


def test_eq15_magnifies_errors_where_x_is_small():
    gain = [
        position_gain(edge_distances(pose_mount("5").translation_body_m), FRAME, form=form)[0]
        for form in ("printed", "corrected")
    ]
    assert gain[0] > 4 and gain[1] < 2


@given(PLACES, st.floats(0.0, 0.15))
@settings(max_examples=50, deadline=None)
def test_eq16_to_eq19_give_the_place_back_at_any_small_tilt(place, theta):
    """With the tilt added back; without it the place is off by distance times theta."""
    arms, printed = {}, {}
    for direction in ("back", "right"):
        edge = FRAME.edge(direction)
        here, _ = tilted(place, direction, theta)
        velocity = np.cross(edge.axis, here - edge.point_m)
        arms[direction] = arm_angle(velocity, tilt_rad=theta)
        printed[direction] = arm_angle(velocity)
    d = edge_distances(place)
    width = FRAME.footprint_width_m
    found = position_two_tilts(d["back"], d["right"], arms["back"], arms["right"], width)
    assert np.allclose(found, place, atol=1e-7)
    naive = position_two_tilts(d["back"], d["right"], printed["back"], printed["right"], width)
    assert np.isclose(
        np.hypot(naive[0] - place[0], d["back"] * np.cos(printed["back"]) - place[2]),
        2 * d["back"] * np.sin(theta / 2),
        atol=1e-7,
    )
    with pytest.raises(InputError, match="without a direction"):
        arm_angle([0.0, 0.0, 0.0])
