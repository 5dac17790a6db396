"""Simulations on the command line: the same seed, the same bytes; a failure leaves nothing."""

import subprocess
import sys

import numpy as np
import pandas as pd
import pytest
from command_lines import CORRIDOR, COURT


@pytest.mark.parametrize(("device", "folder"), [("wheelchair", COURT), ("walker", CORRIDOR)])
def test_simulation_repeats_and_is_what_is_bundled(tmp_path, works, device, folder):
    for name in ("one", "two"):
        works("simulate", device, "--seed", 1, "-o", tmp_path / name)
    files = sorted(path.name for path in (tmp_path / "one").iterdir())
    assert files == sorted(path.name for path in folder.iterdir())
    for name in files:
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "two" / name).read_bytes()
        if name.endswith(".csv.gz"):
            # Other builds of numpy may differ in the last printed digit.
            made, bundled = (pd.read_csv(f / name) for f in (tmp_path / "one", folder))
            assert np.allclose(made, bundled, atol=2e-6)


@pytest.mark.parametrize("device", ["scooter", "wheelchair", "walker"])
@pytest.mark.parametrize("seed", ["-1", "one", "1.5", "9" * 5000])
def test_seeds_that_are_none(fails, device, seed):
    fails("simulate", device, "--seed", seed, "-o", "folder", says=["--seed"])


@pytest.mark.parametrize("course", ["", "bogus", "Curves"])
def test_courses_that_are_none(fails, course):
    fails("simulate", "scooter", "--seed", 1, "--course", course, "-o", "folder", says=["curves"])


def test_a_large_seed_is_a_seed(works, tmp_path):
    works("simulate", "wheelchair", "--seed", 10**30, "-o", "deep/er")
    assert len(list((tmp_path / "deep" / "er").iterdir())) == 5


@pytest.mark.parametrize("device", ["scooter", "wheelchair", "walker"])
def test_an_empty_name_is_not_the_current_folder(fails, device):
    fails("simulate", device, "--seed", 1, "-o", "", says=["--output", "the name is empty"])


def test_simulations_work_without_the_reproduction(tmp_path):
    """The commands' module loads nothing of it, also while it works."""
    code = (
        "import sys; sys.modules['mobility_imu.reproduction'] = None\n"
        "from mobility_imu.__main__ import main\n"
        f"sys.argv = ['', 'simulate', 'walker', '--seed', '1', '-o', {str(tmp_path / 'new')!r},"
        " '--course', 'timed-up-and-go']\n"
        "main()"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
    assert len(list((tmp_path / "new").iterdir())) == 5
