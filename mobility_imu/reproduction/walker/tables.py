"""Walker (Doan & Pham): the printed tables against their own arithmetic.

The recordings behind the tables are not published, so what can be checked is the tables.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from mobility_imu.frames import FloatArray
from mobility_imu.reproduction.published import load_published
from mobility_imu.walker.mount import WalkerMount

POSES = ("1", "2", "3", "4", "5")
PRINT_DEFECT = 0.0015
"""Largest abs(C C' - I) that the print alone explains, rows being up to 0.0005 short of 1."""
CLOSING_COLUMN = {3: "distance", 4: "position"}
"""Header of the closing error's length in Tables 3 and 4, as our text copy has it."""


class EntryRepair(NamedTuple):
    """One entry of a printed matrix, and what it has to be.

    Parameters
    ----------
    row, column : int, counted from 0
    printed, value : float, as printed, and as recomputed
    distance : float, of the repaired matrix from the nearest rotation (Frobenius)
    """

    row: int
    column: int
    printed: float
    value: float
    distance: float


def pose_rotation(pose: str) -> FloatArray:
    """Printed rotation matrix of Table 1 for one mounting, (3, 3).

    Parameters
    ----------
    pose : "1" to "5"
    """
    cells = load_published("walker_table1")
    entries = cells[(cells["row"] == pose) & (cells["quantity"] == "rotation")]["value"]
    return np.array(entries, float).reshape(3, 3)


def rotation_defect(pose: str) -> float:
    """How far the printed matrix of one mounting is from a rotation: largest abs(C C' - I).

    Parameters
    ----------
    pose : "1" to "5"
    """
    matrix = pose_rotation(pose)
    return float(np.abs(matrix @ matrix.T - np.eye(3)).max())


def nearest_rotation(matrix: FloatArray) -> FloatArray:
    """Rotation nearest to a matrix in the sense of Frobenius (by its singular values).

    Parameters
    ----------
    matrix : (3, 3) array

    Returns
    -------
    (3, 3) array
    """
    left, _, right = np.linalg.svd(matrix)
    turn = np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
    return np.asarray(left @ turn @ right)


def rotation_distance(matrix: FloatArray) -> float:
    """Frobenius distance of a matrix from the nearest rotation.

    Parameters
    ----------
    matrix : (3, 3) array
    """
    return float(np.linalg.norm(matrix - nearest_rotation(matrix)))


def best_repair(matrix: FloatArray) -> EntryRepair:
    """Change of one single entry that brings a matrix nearest to a rotation.

    Parameters
    ----------
    matrix : (3, 3) array

    Returns
    -------
    EntryRepair
        All nine entries are tried, each with its best value in [-1, 1].
    """
    from scipy.optimize import minimize_scalar

    found = []
    for row, column in np.ndindex(3, 3):

        def distance(value: float, row: int = row, column: int = column) -> float:
            changed = matrix.copy()
            changed[row, column] = value
            return rotation_distance(changed)

        best = minimize_scalar(distance, bounds=(-1, 1), method="bounded", options={"xatol": 1e-7})
        printed = float(matrix[row, column])
        found.append(EntryRepair(row, column, printed, float(best.x), float(best.fun)))
    return min(found, key=lambda repair: repair.distance)


def repaired_rotation(pose: str) -> FloatArray:
    """Rotation of Table 1 for one mounting, an entry that does not fit repaired, (3, 3).

    Where the matrix is no rotation within its own precision (poses 1 and 2 in our text copy), the
    one entry is recomputed that makes it one; then the nearest rotation is taken. In that order:
    projecting pose 2 unrepaired gives a rotation that is 4.8 degrees off.

    Parameters
    ----------
    pose : "1" to "5"

    Returns
    -------
    (3, 3) array, a rotation; what the paper prints as C_b^I is IMU to body

    Examples
    --------
    >>> repaired_rotation("2")[0].round(3).tolist()
    [0.331, -0.606, -0.723]
    """
    matrix = pose_rotation(pose)
    if rotation_defect(pose) > PRINT_DEFECT:
        repair = best_repair(matrix)
        matrix[repair.row, repair.column] = repair.value
    return nearest_rotation(matrix)


def pose_mount(pose: str) -> WalkerMount:
    """Mounting of one pose as we take it for the truth in simulations.

    That is our choice, an assumption: the rotation of :func:`repaired_rotation` with the position
    by the paper's first method. Nobody measured the true ones, and the second method's positions
    lie 0.14 m away on average. Simulations take the same from
    :data:`mobility_imu.simulation.levels.MOUNTS`.

    Parameters
    ----------
    pose : "1" to "5"

    Returns
    -------
    WalkerMount
    """
    return WalkerMount(repaired_rotation(pose), pose_translation(pose, 1))


def pose_translation(pose: str, method: Literal[1, 2]) -> FloatArray:
    """Printed position of the IMU (Table 1) by the first or the second method, m, (3,).

    Parameters
    ----------
    pose : "1" to "5"
    method : 1 or 2
    """
    cells = load_published("walker_table1").set_index(["row", "column"])["value"]
    return np.array([cells[pose, f"T{method}[{axis}]"] for axis in "xyz"])


def runs(table: int, column: str) -> FloatArray:
    """Values of a column of Tables 2-4 in m, averages left out, (5 poses, 6 runs).

    Parameters
    ----------
    table : 2, 3 or 4
    column : its header
    """
    cells = load_published(f"walker_table{table}")
    chosen = cells[(cells["column"] == column) & ~cells["row"].str.contains("average")]
    return np.array(chosen["value"], float).reshape(5, 6)


def lever_arm_ratio() -> FloatArray:
    """Difference of Tables 3 and 4 over that of the two positions of Table 1, (5 poses, 6 runs).

    By eq. (27) the closing errors of the two methods may differ by the change of heading times
    the difference of the positions: by nothing where a run ends with its first heading. A ratio
    of 1 in every run says that only one end of each walk was corrected for the lever arm.
    """
    apart = np.hypot(runs(3, "x") - runs(4, "x"), runs(3, "y") - runs(4, "y"))
    arm = [np.linalg.norm((pose_translation(p, 1) - pose_translation(p, 2))[:2]) for p in POSES]
    return apart / np.array(arm)[:, None]


def implied_headings() -> FloatArray:
    """Heading of the walker at the end of each round, from Tables 1, 3 and 4, rad, (5, 6).

    If the tabulated error is r_N - C_N T - r_1 (only the end corrected for the lever arm), then
    the tables differ by -C_N (T1 - T2), and the direction of that vector gives the heading C_N
    in the tables' axes. If instead only the start were corrected, the same numbers plus pi would
    be the headings at the start.
    """
    apart = (runs(3, "x") - runs(4, "x")) + 1j * (runs(3, "y") - runs(4, "y"))
    arm = np.array([(pose_translation(p, 1) - pose_translation(p, 2))[:2] for p in POSES])
    return np.asarray(np.angle(-apart / (arm[:, 0] + 1j * arm[:, 1])[:, None]))


def closing_with_arm(table: Literal[3, 4], heading_rad: ArrayLike = 0.0) -> FloatArray:
    """Closing errors with the lever arm added at the start, m, (5 poses, 6 runs).

    Parameters
    ----------
    table : 3 (first method) or 4 (second)
    heading_rad : (...) array, rad, assumed heading of the walker at the start in the tables' axes

    Returns
    -------
    (..., 5, 6) array, length of (x, y) + R(heading) T_xy
    """
    arm = np.array([pose_translation(p, 1 if table == 3 else 2) for p in POSES])
    turned = np.exp(1j * np.asarray(heading_rad, float))[..., None] * (arm[:, 0] + 1j * arm[:, 1])
    return np.asarray(np.abs(runs(table, "x") + 1j * runs(table, "y") + turned[..., None]))


def printed_average(table: Literal[2, 3, 4], column: str, pose: str | None = None) -> float:
    """Printed average of a column of Tables 2-4, for one pose or over all.

    Parameters
    ----------
    table : 2, 3 or 4
    column : its header
    pose : "1" to "5"; None for the average over all
    """
    cells = load_published(f"walker_table{table}").set_index(["row", "column"])["value"]
    return float(cells["average" if pose is None else f"{pose}/average", column])
