"""Walks and feet that were held back until the settings were fixed: two records, run once.

The walks of a frame that ``labelled-walks`` brings beside the sixteen of ``real_walks``, and the
feet with even numbers of ``foot-walks``. Rows are those of the studies of the others.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from mobility_imu.executors import run_all
from mobility_imu.reproduction.real_files import Numbers, held_study
from mobility_imu.reproduction.walker import real_feet, real_walks
from mobility_imu.reproduction.walker.real_walks_study import summarised

WALKS, FEET = real_walks.HELD_BACK, real_feet.HELD_BACK


def held_walks(executor: Any = None) -> Numbers | None:
    """Record ``held_walks``: steps of nine walks.

    Parameters
    ----------
    executor : anything with ``submit``; None computes in this process

    Returns
    -------
    dict with ``numbers`` and ``inputs``, or None if a recording is not here
    """

    def compute(folder: Path) -> Numbers:
        rows = run_all(real_walks.walk_row, [(folder, name) for name in WALKS], executor)
        return {"rows": [real_walks.kept(row) for row in rows], "summary": summarised(rows)}

    files = [*(f"{name}.csv.gz" for name in WALKS), "labelled_steps.csv", "mount.toml"]
    return held_study(real_walks.DATASET, "held_walks", lambda _: files, compute)


def held_feet(executor: Any = None) -> Numbers | None:
    """Record ``held_feet``: paths of 28 walks with a sensor on the foot.

    Parameters
    ----------
    executor : anything with ``submit``; None computes in this process

    Returns
    -------
    dict with ``numbers`` and ``inputs``, or None if a recording is not here
    """

    def compute(folder: Path) -> Numbers:
        rows = run_all(real_feet.foot_row, [(folder, name) for name in FEET], executor)
        summary = real_feet.feet_summary(rows)
        return {"rows": [real_feet.kept(row) for row in rows], "summary": summary}

    files = [f"foot_{name}{end}.csv.gz" for name in FEET for end in ("", "_truth")]
    return held_study(real_feet.DATASET, "held_feet", lambda _: files, compute)
