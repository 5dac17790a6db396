"""The walker's frames: two equations of the paper, and what a geometry file may say."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from mobility_imu.errors import InputError
from mobility_imu.walker.geometry import (
    TILT_DIRECTIONS,
    WalkerGeometry,
    rotation_body_to_world,
    rotation_world_to_imu,
)
from mobility_imu.walker.mount import WalkerMount

component = st.floats(-1, 1)


@given(st.tuples(component, component, component, component))
def test_eq1_is_the_rotation_of_the_quaternion(components):
    q = np.array(components)
    assume(np.linalg.norm(q) > 0.1)
    q /= np.linalg.norm(q)
    matrix = rotation_world_to_imu(q)
    # SciPy: scalar last, turns IMU components into world components. Tolerance: double precision.
    scipy_matrix = Rotation.from_quat(q[[1, 2, 3, 0]]).as_matrix()
    assert np.allclose(matrix, scipy_matrix.T, atol=1e-14)
    assert np.allclose(matrix, rotation_world_to_imu(-q), atol=1e-15)


def test_eq1_takes_many_quaternions_at_once():
    many = np.random.default_rng(0).normal(size=(4, 5, 4))
    many /= np.linalg.norm(many, axis=-1, keepdims=True)
    assert np.array_equal(rotation_world_to_imu(many)[2, 3], rotation_world_to_imu(many[2, 3]))


def test_eq1_printed_is_no_rotation():
    q = Rotation.random(2000, rng=np.random.default_rng(5)).as_quat()[:, [3, 0, 1, 2]]
    printed, right = rotation_world_to_imu(q, form="printed"), rotation_world_to_imu(q)
    defect = np.linalg.norm(printed @ printed.swapaxes(1, 2) - np.eye(3), axis=(1, 2))
    assert 0.9 < defect.mean() < 1.05  # 0.97 in the mean over all rotations
    assert np.linalg.det(printed).min() < 0.2
    # The two wrong entries, and nothing else.
    off = printed - right
    _, q1, q2, q3 = q.T
    assert np.allclose(off[:, 1, 2], 2 * q2 * (q1 - q3), atol=1e-14)
    assert np.allclose(off[:, 2, 1], 2 * q3 * (q1 - q2), atol=1e-14)
    off[:, 1, 2] = off[:, 2, 1] = 0
    assert not off.any()


def test_eq1_refuses_what_is_no_quaternion():
    with pytest.raises(InputError, match="four components"):
        rotation_world_to_imu([1.0, 0.0, 0.0])
    with pytest.raises(InputError, match="'corrected' or 'printed'"):
        rotation_world_to_imu([1.0, 0.0, 0.0, 0.0], form="fixed")
    with pytest.raises(InputError, match="of length 2, expected 1"):
        rotation_world_to_imu([[1.0, 0.0, 0.0, 0.0], [2.0, 0.0, 0.0, 0.0]])


@given(st.floats(-np.pi, np.pi))
def test_eq2_eq6_body_axes_are_columns(heading):
    forward = np.array([np.cos(heading), np.sin(heading), 0.0])
    matrix = rotation_body_to_world(forward)
    assert np.array_equal(matrix @ [1, 0, 0], forward)
    assert np.allclose(matrix @ [0, 1, 0], [-np.sin(heading), np.cos(heading), 0])  # left
    assert np.array_equal(matrix @ [0, 0, 1], [0, 0, 1])
    assert np.allclose(matrix, Rotation.from_euler("z", heading).as_matrix(), atol=1e-14)


@pytest.mark.parametrize("forward", [[1.0, 0.0, 0.1], [2.0, 0.0, 0.0], [1.0, 0.0]])
def test_forward_axis_is_a_horizontal_unit_vector(forward):
    with pytest.raises(InputError, match="horizontal unit vector"):
        rotation_body_to_world(forward)


@pytest.mark.parametrize("direction", TILT_DIRECTIONS)
def test_a_positive_tilt_lowers_the_side_it_is_named_after(direction):
    geometry = WalkerGeometry(0.60, 0.52)
    edge = geometry.edge(direction)
    outward = {
        "front": (1, 0, 0),
        "back": (-1, 0, 0),
        "right": (0, -1, 0),
        "left": (0, 1, 0),
    }[direction]
    top = edge.point_m + np.array([0, 0, 0.8])
    turn = Rotation.from_rotvec(np.deg2rad(30) * edge.axis)
    moved = edge.point_m + turn.apply(top - edge.point_m) - top
    assert moved @ outward > 0.3  # the top leans out over its edge
    centre = np.array([0.26, 0.0, 0.0])
    # The edge lies on that side of the footprint, on the floor, half a side from its middle.
    half = {"front": 0.26, "back": 0.26, "right": 0.30, "left": 0.30}[direction]
    assert np.isclose((edge.point_m - centre) @ outward, half)
    across = np.cross(edge.axis, [0.0, 0.0, 1.0])
    assert np.allclose((edge.point_m - centre) - half * np.array(outward), 0, atol=1e-12)
    assert np.isclose(abs(across @ outward), 1.0)
    lifted = edge.point_m + turn.apply(centre - edge.point_m)
    assert lifted[2] > 0  # and the footprint rises from the floor, it does not dive


def test_edge_names_are_checked():
    with pytest.raises(InputError, match="'front', 'back', 'right' or 'left'"):
        WalkerGeometry(0.60, 0.52).edge("up")


@pytest.mark.parametrize(
    ("width", "length", "message"),
    [
        (60, 0.52, r"footprint_width_m = 60.*in cm"),
        (0.60, 520, r"footprint_length_m = 520.*in mm"),
        (-0.6, 0.52, "footprint_width_m = -0.6"),
        (0.6, float("nan"), "footprint_length_m = nan"),
    ],
)
def test_geometry_refuses_impossible_lengths_and_guesses_the_unit(width, length, message):
    with pytest.raises(InputError, match=message):
        WalkerGeometry(width, length)


def test_geometry_from_toml(tmp_path):
    path = tmp_path / "g.toml"
    path.write_text("[walker]\nfootprint_width_m = 0.6\nfootprint_length_m = 0.52\n")
    assert WalkerGeometry.from_toml(path) == WalkerGeometry(0.60, 0.52)
    path.write_text("[walker]\nfootprint_width_m = 60\nfootprint_length_m = 0.52\n")
    with pytest.raises(InputError, match=r"g\.toml, \[walker\]: footprint_width_m = 60.*in cm"):
        WalkerGeometry.from_toml(path)
    path.write_text("[walker]\nfootprint_width_m = 0.6\n")
    with pytest.raises(InputError, match="footprint_length_m is missing"):
        WalkerGeometry.from_toml(path)
    path.write_text("[scooter]\n")
    with pytest.raises(InputError, match=r"no section \[walker\]"):
        WalkerGeometry.from_toml(path)


def test_mount_refuses_what_is_no_rotation_or_no_place():
    place = np.array([0.4, 0.1, 0.6])
    mirrored, scaled = np.diag([1.0, 1.0, -1.0]), 1.01 * np.eye(3)
    for matrix in (mirrored, scaled):
        with pytest.raises(InputError, match=r"rotation_imu_to_body: .* rotation matrix"):
            WalkerMount(matrix, place)
    for matrix in (np.eye(2), np.full((3, 3), np.nan)):
        with pytest.raises(InputError, match="rotation matrix of 3 x 3 numbers"):
            WalkerMount(matrix, place)
    with pytest.raises(InputError, match="in cm or mm"):
        WalkerMount(np.eye(3), 100 * place)
    with pytest.raises(InputError, match="translation_body_m: expected three components"):
        WalkerMount(np.eye(3), place[:2])
    with pytest.raises(InputError, match="translation_body_m: not a finite number"):
        WalkerMount(np.eye(3), [np.nan, 0, 0])


def test_mount_from_toml(tmp_path):
    path = tmp_path / "mount.toml"
    rows = Rotation.from_euler("xyz", [0.3, -1.0, 2.0]).as_matrix().round(9).tolist()
    section = "[walker.mount]\nrotation_imu_to_body = {}\ntranslation_body_m = {}\n"
    path.write_text(section.format(rows, [0.46, -0.21, 0.63]))
    mount = WalkerMount.from_toml(path)
    assert np.array_equal(mount.rotation_imu_to_body, rows)
    assert mount.translation_body_m.tolist() == [0.46, -0.21, 0.63]

    path.write_text(section.format([[1, 0, 0], [0, 1, 0], [0, 0, -1]], [0.46, -0.21, 0.63]))
    with pytest.raises(InputError, match=r"mount\.toml, \[walker\.mount\].*a mirror"):
        WalkerMount.from_toml(path)
    path.write_text(section.format(rows, [460, -210, 630]))
    with pytest.raises(InputError, match="in cm or mm"):
        WalkerMount.from_toml(path)
    path.write_text(section.format(rows, [0.46, -0.21]))
    with pytest.raises(InputError, match="translation_body_m: expected 3 numbers"):
        WalkerMount.from_toml(path)
    path.write_text("[walker]\nfootprint_width_m = 0.6\n")
    with pytest.raises(InputError, match=r"no section \[walker\.mount\].*calibrate"):
        WalkerMount.from_toml(path)
