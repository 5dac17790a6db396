"""A plugin of pytest for :mod:`mutations`: fast tests run first, and the seconds of each are kept.

``MOBILITY_IMU_SECONDS`` names the file of the seconds. Files, and the tests in each, are sorted by
what they took before; tests that are new in it run first. Those that took longer than
``MOBILITY_IMU_SLOWEST`` seconds are left out.
"""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

_FILE = Path(os.environ["MOBILITY_IMU_SECONDS"])
_SLOWEST = float(os.environ.get("MOBILITY_IMU_SLOWEST", "inf"))
_before: dict[str, float] = json.loads(_FILE.read_text()) if _FILE.is_file() else {}
_now: dict[str, float] = {}


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Leave out what is slow; sort the files by their seconds, and the tests of each."""
    items[:] = [item for item in items if _before.get(item.nodeid, 0.0) <= _SLOWEST]
    of_file: dict[str, float] = {}
    for item in items:
        name = item.nodeid.split("::")[0]
        of_file[name] = of_file.get(name, 0.0) + _before.get(item.nodeid, 0.0)
    items.sort(
        key=lambda item: (
            of_file[item.nodeid.split("::")[0]],
            item.nodeid.split("::")[0],
            _before.get(item.nodeid, 0.0),
        )
    )


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Add up what setting up, running and tearing down took."""
    _now[report.nodeid] = _now.get(report.nodeid, 0.0) + report.duration


def pytest_sessionfinish(exitstatus: int) -> None:
    """Keep the seconds of a run in which all passed."""
    if exitstatus == 0:
        _FILE.write_text(json.dumps(_before | _now))
