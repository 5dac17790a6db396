"""Numbers behind the findings on the equations of Doan & Pham."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from mobility_imu.frames import FloatArray
from mobility_imu.reproduction.findings import Evidence
from mobility_imu.reproduction.walker.studies import FOOTPRINT
from mobility_imu.reproduction.walker.tables import (
    POSES,
    implied_headings,
    pose_translation,
    repaired_rotation,
)
from mobility_imu.walker.geometry import (
    TiltDirection,
    WalkerGeometry,
    rotation_world_to_imu,
)
from mobility_imu.walker.navigation import NavigationState, error_dynamics, imu_output
from mobility_imu.walker.tilt_equations import (
    arm_angle,
    position_four_tilts,
    position_two_tilts,
    quaternion_from_rotation,
    rotation_imu_to_body,
    tilt_quaternion,
)
from mobility_imu.walker.trajectory import walking_displacement

Evidences = tuple[Evidence, ...]
SEED = 2020


def _attitude(rng: np.random.Generator) -> FloatArray:
    x, y, z, w = Rotation.random(rng=rng).as_quat()
    return np.array([w, x, y, z])


def matrix_of_a_quaternion() -> Evidences:
    """K1: how far (1) is from a rotation, as our copy has it and with q(2)q(3)."""
    rng = np.random.default_rng(SEED)
    attitudes = np.array([_attitude(rng) for _ in range(200)])

    def defect(matrices: FloatArray) -> float:
        product = matrices @ np.swapaxes(matrices, 1, 2)
        return float(np.median(np.abs(product - np.eye(3)).max(axis=(1, 2))))

    return (
        Evidence(
            what="largest entry of |CC' − I| (0 for a rotation C), median of 200 attitudes",
            first_from="as our copy has it",
            first=defect(rotation_world_to_imu(attitudes, form="printed")),
            second_from="q(2)q(3) in both entries",
            second=defect(rotation_world_to_imu(attitudes)),
            truth=0.0,
            tolerance=1e-9,
        ),
    )


def _product(p: FloatArray, q: FloatArray) -> FloatArray:
    """Hamilton product, scalar first."""
    vector = p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:])
    return np.asarray(np.r_[p[0] * q[0] - p[1:] @ q[1:], vector])


def _error_columns() -> tuple[FloatArray, FloatArray, FloatArray]:
    """Derivatives of the error's rate by difference quotients, and the attitude behind them.

    The rate of (attitude error, velocity error) follows from (20) to (22) without approximation;
    its columns are those of A for gyroscope bias and accelerometer bias.

    Returns
    -------
    (6, 6) array (rows: attitude, velocity; columns: both biases), (4,) quaternion, (3,) force
    """
    rng = np.random.default_rng(SEED)
    q_hat, gyro, acc = _attitude(rng), rng.normal(size=3), np.array([0.4, -0.3, 9.8])
    back = q_hat * [1, -1, -1, -1]

    def rate(biases: FloatArray) -> FloatArray:
        # Error-free attitude at this instant: q = q_hat.
        rate_hat = 0.5 * _product(q_hat, np.r_[0, gyro])
        rate_true = 0.5 * _product(q_hat, np.r_[0, gyro - biases[:3]])
        attitude = _product(rate_hat * [1, -1, -1, -1], q_hat) + _product(back, rate_true)
        to_world = rotation_world_to_imu(q_hat).T
        return np.asarray(np.r_[attitude[1:], to_world @ (acc - biases[3:]) - to_world @ acc])

    step = 1e-6
    columns = [(rate(step * e) - rate(-step * e)) / (2 * step) for e in np.eye(6)]
    return np.array(columns).T, q_hat, acc


def sign_of_the_gyroscope_bias() -> Evidences:
    """K2: factor from the gyroscope's bias to the attitude error."""
    columns, q_hat, acc = _error_columns()
    printed = error_dynamics(q_hat, np.zeros(3), acc, form="printed")
    corrected = error_dynamics(q_hat, np.zeros(3), acc)
    return (
        Evidence(
            what="factor from the gyroscope's bias to the rate of the attitude error",
            first_from="as our copy has it",
            first=float(printed[0, 3]),
            second_from="from (20) to (22)",
            second=float(corrected[0, 3]),
            truth=float(columns[0, 0]),
            tolerance=1e-6,
        ),
    )


def accelerometer_bias() -> Evidences:
    """K10: norm of the block from the accelerometer's bias to the velocity error."""
    columns, q_hat, acc = _error_columns()
    printed = error_dynamics(q_hat, np.zeros(3), acc, form="printed")
    corrected = error_dynamics(q_hat, np.zeros(3), acc)
    truth = columns[3:, 3:]
    return (
        Evidence(
            what="largest difference of the block in A from finite differences",
            first_from="0, as our copy has it",
            first=float(np.abs(printed[9:12, 12:15] - truth).max()),
            second_from="−C'(q̂), the factor of the noise",
            second=float(np.abs(corrected[9:12, 12:15] - truth).max()),
            truth=0.0,
            tolerance=1e-6,
        ),
    )


def sign_of_the_lever_arm() -> Evidences:
    """K3: walking length by (25) at both ends, and by (28) with either sign."""
    rng = np.random.default_rng(SEED)
    first, last = Rotation.random(2, rng=rng).as_matrix()
    r_1, r_n, t, t_e = rng.normal(size=(4, 3))
    by_25 = (r_n - last @ (t + t_e)) - (r_1 - first @ (t + t_e))
    turned = last - first
    plus = r_n - r_1 + turned @ t - turned @ t_e
    return (
        Evidence(
            what="walking length of a made-up walk",
            first_from="(28) as our copy has it",
            first=float(np.linalg.norm(plus)),
            second_from="(28) with a minus",
            second=float(np.linalg.norm(walking_displacement(r_1, r_n, first, last, t, t_e))),
            truth=float(np.linalg.norm(by_25)),
            tolerance=1e-9,
            unit="m",
        ),
    )


def moment_of_the_initial_velocity() -> Evidences:
    """K7: error of pose 1's x by (16) to (19), for two moments of "the initial velocity"."""
    x, y, h = pose_translation("1", 1)
    half = FOOTPRINT.footprint_width_m / 2
    arms = {"back": np.arctan2(x, h), "right": np.arctan2(y + half, h)}
    lengths = {"back": float(np.hypot(x, h)), "right": float(np.hypot(y + half, h))}

    def error_mm(tilt_deg: float) -> float:
        seen = {}
        for name, arm in arms.items():
            outward, up = np.sin(arm - np.deg2rad(tilt_deg)), np.cos(arm - np.deg2rad(tilt_deg))
            seen[name] = arm_angle([-up, 0.0, outward])  # the IMU moves at right angles to the arm
        found = position_two_tilts(
            lengths["back"], lengths["right"], seen["back"], seen["right"], 2 * half
        )
        return float(1000 * (found - [x, y, h])[0])

    return (
        Evidence(
            what="error of the x of pose 1, exact arcs",
            first_from="velocity taken at a tilt of 1°",
            first=error_mm(1.0),
            second_from="velocity taken at a tilt of 3°",
            second=error_mm(3.0),
            tolerance=5.0,
            unit="mm",
        ),
    )


def what_the_rectangle_tests() -> Evidences:
    """K8: effect of an error of T of 0.1 m on the closing error, for two final headings."""
    wrong = [0.10, 0.0, 0.0]

    def effect_mm(turned_deg: float) -> float:
        last = Rotation.from_euler("z", turned_deg, degrees=True).as_matrix()
        args = (np.zeros(3), np.zeros(3), np.eye(3), last, pose_translation("1", 1))
        return float(
            1000 * np.linalg.norm(walking_displacement(*args, wrong) - walking_displacement(*args))
        )

    headings = np.rad2deg(implied_headings())
    late = np.abs(headings + 90) < 30

    return (
        Evidence(
            what="change of the closing error of a round, by an error of T of 100 mm",
            first_from="last corner turned: the round ends with its first heading",
            first=effect_mm(0.0),
            second_from="last corner not turned",
            second=effect_mm(270.0),
            tolerance=1.0,
            unit="mm",
        ),
        Evidence(
            what="rounds of thirty by final heading, if only the end was corrected (K6)",
            first_from="near a quarter turn from the first heading "
            f"(mean {headings[late].mean():.0f}°)",
            first=float(late.sum()),
            second_from="near the first heading",
            second=float((np.abs(headings) < 30).sum()),
            relation="first above",
        ),
    )


def place_of_the_scalar() -> Evidences:
    """K13: attitude by (1) from the quaternion of (11), in its own order and in that of (1)."""
    tilt = np.deg2rad(30)
    by_11 = tilt_quaternion([0.0, 1.0, 0.0], tilt)  # scalar first
    true = Rotation.from_rotvec([0.0, tilt, 0.0]).as_matrix().T

    def off_deg(scalar_first: FloatArray) -> float:
        matrix = rotation_world_to_imu(scalar_first)
        return float(np.rad2deg(Rotation.from_matrix(matrix @ true.T).magnitude()))

    # The package counts the scalar first. (1) takes the last of four numbers for the scalar.
    misread = np.r_[by_11[3], by_11[:3]]
    return (
        Evidence(
            what="error of the attitude that (1) gives for a quaternion of (11), tilt of 30°",
            first_from="four numbers in the order of (11)",
            first=off_deg(misread),
            second_from="scalar moved to the place where (1) has it",
            second=off_deg(by_11),
            truth=0.0,
            tolerance=1e-6,
            unit="deg",
        ),
    )


def transposes() -> Evidences:
    """K14: error of (7), as our copy has it and with both transposes."""
    rng = np.random.default_rng(SEED)
    body_to_world = Rotation.from_euler("z", 40, degrees=True).as_matrix()
    imu_to_body = Rotation.random(rng=rng).as_matrix()
    x, y, z, w = Rotation.from_matrix(body_to_world @ imu_to_body).as_quat()
    q_1 = np.array([w, x, y, z])

    def off_deg(matrix: FloatArray) -> float:
        return float(np.rad2deg(Rotation.from_matrix(matrix @ imu_to_body.T).magnitude()))

    as_in_2 = body_to_world @ rotation_world_to_imu(q_1).T
    turned = [
        float(np.rad2deg(Rotation.from_matrix(c.T @ c.T).magnitude()))
        for c in map(repaired_rotation, POSES[:4])
    ]
    wrong_way = tuple(
        Evidence(
            what=f"error of the attitude with the matrices of Table 1, {name} of poses 1 to 4",
            first_from="used as body to IMU",
            first=value,
            second_from="used as IMU to body",
            second=0.0,
            truth=0.0,
            tolerance=1.0,
            unit="deg",
        )
        for name, value in (("smallest", min(turned)), ("largest", max(turned)))
    )
    return (
        Evidence(
            what="error of the mount by (7), simulated, heading of the frame 40°",
            first_from="(2) put into (7): body to world",
            first=off_deg(as_in_2),
            second_from="lower index as the target: world to body",
            second=off_deg(rotation_imu_to_body(body_to_world, q_1)),
            truth=0.0,
            tolerance=1e-6,
            unit="deg",
        ),
        *wrong_way,
    )


def axis_of_a_tilt() -> Evidences:
    """K15: axis of a tilt about y by (10), for a matrix in either sense."""
    end_to_start = Rotation.from_rotvec([0.0, np.deg2rad(30), 0.0]).as_matrix()

    def axis_by_10(matrix: FloatArray) -> float:
        # Our function has the signs for a matrix from the end to the beginning; (10) the others.
        return float(np.sign(-quaternion_from_rotation(matrix)[2]))

    return (
        Evidence(
            what="direction of the axis along y of a tilt by +30°, signs of (10)",
            first_from="matrix from the end to the beginning, as the words before (9)",
            first=axis_by_10(end_to_start),
            second_from="matrix from the beginning to the end",
            second=axis_by_10(end_to_start.T),
            truth=1.0,
            tolerance=0.1,
        ),
    )


def _distances(x: float, y: float, h: float) -> dict[TiltDirection, float]:
    """Distances of an IMU from the four edges of the footprint, m."""
    width, length = FOOTPRINT.footprint_width_m, FOOTPRINT.footprint_length_m
    return {
        "front": float(np.hypot(length - x, h)),
        "back": float(np.hypot(x, h)),
        "right": float(np.hypot(y + width / 2, h)),
        "left": float(np.hypot(width / 2 - y, h)),
    }


def roots_without_a_side() -> Evidences:
    """K16: an IMU 50 mm behind the rear tips and one 100 mm beside them, by both forms of (15)."""
    places = {
        "x of an IMU behind the rear tips": (0, (-0.05, 0.10, 0.60)),
        "y of an IMU beside the footprint": (1, (0.20, 0.40, 0.60)),
    }
    rows = []
    for what, (axis, place) in places.items():
        distances = _distances(*place)
        rows.append(
            Evidence(
                what=f"{what}, exact distances",
                first_from="roots of (15)",
                first=float(position_four_tilts(distances, FOOTPRINT, form="printed")[axis]),
                second_from="differences of squares",
                second=float(position_four_tilts(distances, FOOTPRINT)[axis]),
                truth=place[axis],
                tolerance=1e-9,
                unit="m",
            )
        )
    return tuple(rows)


def direction_of_g() -> Evidences:
    """K17: reading of a level accelerometer at rest by (21), g upward or downward."""
    rest = NavigationState(
        np.array([1.0, 0.0, 0.0, 0.0]), np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3)
    )
    upward, _ = imu_output(rest, np.zeros(3), np.zeros(3))
    return (
        Evidence(
            what="vertical reading of a level accelerometer at rest, by (21)",
            first_from="g downward (gravitational acceleration)",
            first=float(-upward[2]),
            second_from='g upward ("the upward vertical vector")',
            second=float(upward[2]),
            tolerance=1.0,
            unit="m/s²",
        ),
    )


def lengths_by_tape() -> Evidences:
    """K18: height by the first method, edges measured right and 10 mm too long."""
    x, y, h = pose_translation("1", 1)
    width, length = FOOTPRINT.footprint_width_m, FOOTPRINT.footprint_length_m
    distances = _distances(x, y, h)
    longer = WalkerGeometry(footprint_width_m=width + 0.01, footprint_length_m=length + 0.01)
    return (
        Evidence(
            what="error of the height by (14), pose 1",
            first_from="AB and AD measured 10 mm too long",
            first=1000 * float(position_four_tilts(distances, longer)[2] - h),
            second_from="AB and AD measured exactly",
            second=1000 * float(position_four_tilts(distances, FOOTPRINT)[2] - h),
            truth=0.0,
            tolerance=0.5,
            unit="mm",
        ),
    )
