"""Numbers behind the findings on the tables and the text of Doan & Pham."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from mobility_imu.frames import FloatArray
from mobility_imu.reproduction.findings import Evidence, Relation, quoted
from mobility_imu.reproduction.walker.tables import (
    POSES,
    PRINT_DEFECT,
    best_repair,
    lever_arm_ratio,
    nearest_rotation,
    pose_rotation,
    pose_translation,
    printed_average,
    repaired_rotation,
    runs,
)
from mobility_imu.walker.trajectory import walking_displacement

Evidences = tuple[Evidence, ...]
ROUNDING_M = 1e-4
"""One unit of the last digit that Tables 2 to 4 print."""


def _entry(pose: str) -> Evidence:
    printed = pose_rotation(pose)
    repair = best_repair(printed)
    mended = printed.copy()
    mended[repair.row, repair.column] = repair.value

    def defect(matrix: FloatArray) -> float:
        return float(np.abs(matrix @ matrix.T - np.eye(3)).max())

    return Evidence(
        what=f"largest entry of |CC' − I| (0 for a rotation C), pose {pose}",
        first_from=f"entry ({repair.row + 1},{repair.column + 1}) = {repair.printed:.4f}",
        first=defect(printed),
        second_from=f"{repair.value:.4f} in its place",
        second=defect(mended),
        truth=0.0,
        tolerance=PRINT_DEFECT,
    )


def entry_of_pose_1() -> Evidences:
    """K4: defect of the matrix of pose 1, and its largest entry."""
    printed = float(np.abs(pose_rotation("1")).max())
    mended = abs(best_repair(pose_rotation("1")).value)
    return (
        _entry("1"),
        Evidence(
            what="excess over 1 of the largest size of an entry",
            first_from="as in the paper",
            first=max(printed - 1, 0.0),
            second_from="repaired",
            second=max(mended - 1, 0.0),
            truth=0.0,
            tolerance=1e-4,
        ),
    )


def entry_of_pose_2() -> Evidences:
    """K11: defect of the matrix of pose 2, and how far its nearest rotation is off."""
    printed, repaired = pose_rotation("2"), repaired_rotation("2")

    def off_deg(matrix: FloatArray) -> float:
        turn = Rotation.from_matrix(nearest_rotation(matrix) @ repaired.T)
        return float(np.rad2deg(turn.magnitude()))

    return (
        _entry("2"),
        Evidence(
            what="angle between the nearest rotation and the repaired one",
            first_from="matrix as our copy has it",
            first=off_deg(printed),
            second_from="matrix repaired",
            second=off_deg(repaired),
            truth=0.0,
            tolerance=0.01,
            unit="deg",
        ),
    )


def two_averages() -> Evidences:
    """K5: two averages against the mean of their rows."""
    pose_5 = runs(2, "distance_estimation")[4]
    x_errors = runs(4, "x")
    return (
        Evidence(
            what="mean of six distances, pose 5",
            first_from="Table 2, as our copy has it",
            first=printed_average(2, "distance_estimation", "5"),
            second_from="recomputed, to four digits",
            second=round(float(pose_5.mean()), 4),
            truth=float(pose_5.mean()),
            tolerance=ROUNDING_M,
            unit="m",
        ),
        Evidence(
            what="mean x error of thirty rounds, second method",
            first_from="text of section 3, as our copy has it",
            first=quoted("K5", r"(-0\.33374) m"),
            second_from="Table 4",
            second=printed_average(4, "x"),
            truth=float(x_errors.mean()),
            tolerance=ROUNDING_M,
            unit="m",
        ),
    )


def difference_of_tables_3_and_4() -> Evidences:
    """K6: what the tables differ by, over the lever arm between the two positions."""
    ratio = lever_arm_ratio()
    # (27) with the heading of the start at the end: both ends are moved alike.
    same_heading = np.linalg.norm(
        walking_displacement(np.zeros(3), np.zeros(3), np.eye(3), np.eye(3), [0.1, 0.1, 0.0])
    )
    expected: tuple[tuple[str, float, Relation], ...] = (
        ("(27), a round that ends with its first heading", float(same_heading), "apart"),
        ("lever arm subtracted at one end only", 1.0, "together"),
    )
    ratios = tuple(
        Evidence(
            what="difference of the two closing errors, divided by the length of T1 − T2, "
            f"horizontal: {name} of thirty rounds",
            first_from=source,
            first=first,
            second_from="Tables 1, 3 and 4",
            second=float(value),
            tolerance=0.007,
            relation=relation,
        )
        for source, first, relation in expected
        for name, value in (("smallest", ratio.min()), ("largest", ratio.max()))
    )
    arms = [
        float(np.mean([np.hypot(*pose_translation(pose, method)[:2]) for pose in POSES]))
        for method in (1, 2)
    ]
    printed = [printed_average(3, "distance"), printed_average(4, "position")]
    lengths = tuple(
        Evidence(
            what=f"mean length of the horizontal lever arm, and mean closing error, method {k + 1}",
            first_from="lever arm, Table 1",
            first=arms[k],
            second_from=f"closing error, as published in Table {k + 3}",
            second=printed[k],
            tolerance=0.1,
            unit="m",
            relation="first below",
        )
        for k in range(2)
    )
    return (*ratios, *lengths)


def poses_in_the_corridor() -> Evidences:
    """K9: poses behind the corridor's averages."""
    distance = runs(2, "distance_estimation")
    stated = quoted("K9", r"error is ([0-9.]+) m")
    errors = np.abs(distance - 10)
    return (
        Evidence(
            what="poses in the corridor experiment",
            first_from='text of section 3 ("only set at pose 1")',
            first=1.0,
            second_from="Table 2",
            second=float(len(distance)),
            tolerance=0.5,
        ),
        Evidence(
            what="average distance error of the text",
            first_from="walks of pose 1 only",
            first=float(errors[0].mean()),
            second_from="walks of all five poses",
            second=float(errors.mean()),
            truth=stated,
            tolerance=ROUNDING_M,
            unit="m",
        ),
    )


def difference_of_the_methods() -> Evidences:
    """K12: second minus first method in the mean closing error, over all walks and by pose."""
    first, second = (np.hypot(runs(t, "x"), runs(t, "y")).mean(axis=1) for t in (3, 4))
    by_pose = second - first
    return (
        Evidence(
            what="mean closing error, second method minus first method",
            first_from="all thirty rounds",
            first=float(by_pose.mean()),
            second_from="pose that differs most",
            second=float(by_pose[np.abs(by_pose).argmax()]),
            tolerance=0.05,
            unit="m",
        ),
        Evidence(
            what="the same difference, by pose",
            first_from="pose that is best for the second method",
            first=float(by_pose.min()),
            second_from="pose that is worst for the second method",
            second=float(by_pose.max()),
            unit="m",
            relation="first below",
        ),
        Evidence(
            what="distance of the two positions (mean), and difference of the mean closing errors",
            first_from="distance of T1 and T2, Table 1",
            first=float(np.mean([_apart(pose) for pose in POSES])),
            second_from="difference of the mean closing errors",
            second=float(abs(by_pose.mean())),
            unit="m",
            relation="first above",
        ),
    )


def _apart(pose: str) -> float:
    return float(np.linalg.norm(pose_translation(pose, 1) - pose_translation(pose, 2)))


def accuracy_and_error() -> Evidences:
    """K19: the same results as points of accuracy and as a ratio of errors."""
    before, now = quoted("K19", r"approximately ([0-9.]+)% in"), quoted("K19", r"and ([0-9.]+)% in")
    return (
        Evidence(
            what="result now divided by the result before (98.3 %, [10])",
            first_from="as accuracies",
            first=now / before,
            second_from="as errors",
            second=(100 - now) / (100 - before),
            tolerance=0.1,
        ),
    )


def dimension_of_a_quaternion() -> Evidences:
    """K20: numbers in a quaternion by two sentences of the text."""
    return (
        Evidence(
            what="components of a quaternion",
            first_from="after (21)",
            first=quoted("K20", r"hat\{q\} \\in R\^([0-9])"),
            second_from="section 2.2.1",
            second=quoted("K20", r"\$q \\in R\^([0-9])"),
            truth=4.0,
            tolerance=0.5,
        ),
    )
