"""The package as it is imported: light, and each module there when it is first used."""

import subprocess
import sys

import pytest

import mobility_imu


def test_modules_are_loaded_when_they_are_first_used():
    code = """
import sys, mobility_imu
assert not {"numpy", "scipy", "pandas", "typer"} & set(sys.modules)
assert {"scooter", "wheelchair", "walker", "readers", "cli"} <= set(dir(mobility_imu))
assert "numpy" not in sys.modules
assert mobility_imu.scooter.SUZUKI_ET4D is not None
assert mobility_imu.scooter is sys.modules["mobility_imu.scooter"]
assert "mobility_imu.wheelchair" not in sys.modules
from mobility_imu import rotations, wheelchair
assert wheelchair.Task is not None and rotations is mobility_imu.rotations
"""
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert (found.returncode, found.stderr) == (0, "")


@pytest.mark.parametrize("name", ["scoter", "_compiled_", "__wrapped__", "scooter.angles", ""])
def test_names_that_are_no_modules(name):
    with pytest.raises(AttributeError, match="has no attribute"):
        getattr(mobility_imu, name)
    assert not hasattr(mobility_imu, name)


def test_nothing_is_loaded_before_an_interrupt_is_caught():
    """Ctrl-C in the first hundredths of a second: the entry point itself loads no library."""
    code = """
import sys
before = set(sys.modules)
import mobility_imu.__main__
print(sorted(set(sys.modules) - before - {"__future__"}))
"""
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert found.stdout.strip() == "['mobility_imu', 'mobility_imu.__main__']", found.stderr
