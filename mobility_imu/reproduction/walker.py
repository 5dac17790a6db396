"""Walker (Doan & Pham): the printed tables against their own arithmetic.

The recordings behind the tables are not published, so what can be checked is the tables.
"""

from __future__ import annotations

from functools import partial
from typing import Literal

import numpy as np

from mobility_imu.frames import FloatArray
from mobility_imu.reproduction.claims import Claim
from mobility_imu.reproduction.published import load_published

POSES = ("1", "2", "3", "4", "5")
ROUNDING = "one unit of the last printed digit"


def pose_rotation(pose: str) -> FloatArray:
    """Printed rotation matrix of Table 1 for one mounting, (3, 3)."""
    cells = load_published("walker_table1")
    entries = cells[(cells["row"] == pose) & (cells["quantity"] == "rotation")]["value"]
    return entries.to_numpy(copy=True).reshape(3, 3)


def rotation_defect(pose: str) -> float:
    """How far the printed matrix of one mounting is from a rotation: largest abs(C C' - I)."""
    matrix = pose_rotation(pose)
    return float(np.abs(matrix @ matrix.T - np.eye(3)).max())


def pose_translation(pose: str, method: Literal[1, 2]) -> FloatArray:
    """Printed position of the IMU (Table 1) by the first or the second method, m, (3,)."""
    cells = load_published("walker_table1").set_index(["row", "column"])["value"]
    return np.array([cells[pose, f"T{method}[{axis}]"] for axis in "xyz"])


def runs(table: int, column: str) -> FloatArray:
    """Values of a column of Tables 2-4 in m, averages left out, (5 poses, 6 runs)."""
    cells = load_published(f"walker_table{table}")
    chosen = cells[(cells["column"] == column) & ~cells["row"].str.contains("average")]
    return chosen["value"].to_numpy().reshape(5, 6)


def lever_arm_ratio() -> FloatArray:
    """Difference of Tables 3 and 4 over that of the two positions of Table 1, (5 poses, 6 runs).

    By eq. (27) the closing errors of the two methods may differ by the change of heading times
    the difference of the positions: by nothing where a run ends with its first heading. A ratio
    of 1 in every run says that only one end of each walk was corrected for the lever arm.
    """
    apart = np.hypot(runs(3, "x") - runs(4, "x"), runs(3, "y") - runs(4, "y"))
    arm = [np.linalg.norm((pose_translation(p, 1) - pose_translation(p, 2))[:2]) for p in POSES]
    return apart / np.array(arm)[:, None]


def claims() -> list[Claim]:
    """Printed averages and matrices against what the printed rows give."""
    walker = partial(Claim, work="walker", basis="published numbers recomputed")
    digit = partial(walker, unit="m", tolerance=1e-4, tolerance_reason=ROUNDING)
    found = [
        digit(
            where=f"Table 2, pose {pose}",
            what="mean distance of six runs",
            published_value=printed,
            compute=partial(lambda k: runs(2, "distance_estimation")[k].mean(), k),
        )
        for k, (pose, printed) in enumerate(
            zip(POSES, (9.8097, 9.7307, 10.2814, 9.562, 9.6525), strict=True)
        )
    ]
    found += [
        digit(
            where="Table 2",
            what="mean distance error of 30 runs",
            published_value=0.3123,
            compute=lambda: float(np.abs(10 - runs(2, "distance_estimation")).mean()),
        ),
        digit(
            where="Table 3",
            what="mean closing error, first method",
            published_value=0.5170,
            compute=lambda: float(np.hypot(runs(3, "x"), runs(3, "y")).mean()),
        ),
        digit(
            where="Table 4",
            what="mean closing error, second method",
            published_value=0.5041,
            compute=lambda: float(np.hypot(runs(4, "x"), runs(4, "y")).mean()),
        ),
        digit(
            where="section 3, text",
            what="mean x error, second method",
            published_value=-0.33374,
            compute=lambda: float(runs(4, "x").mean()),
        ),
    ]
    found += [
        walker(
            where=f"Table 1, pose {pose}",
            what="largest entry of abs(C C' - I), 0 for a rotation",
            published_value=0.0,
            unit="-",
            compute=partial(rotation_defect, pose),
            tolerance=0.0015,
            tolerance_reason="rows are printed up to 0.0005 short of unit length",
        )
        for pose in POSES
    ]
    found.append(
        walker(
            where="Tables 1, 3, 4 with eq. 27",
            what="runs whose closing errors differ by the whole lever arm (eq. 27: none has to)",
            published_value=0,
            unit="of 30",
            compute=lambda: float((np.abs(lever_arm_ratio() - 1) < 0.01).sum()),
            tolerance=0,
            tolerance_reason="a count",
        )
    )
    return found
