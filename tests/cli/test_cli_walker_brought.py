"""Walking frame on the command line: files as people bring them."""

import numpy as np
import pandas as pd
from command_lines import CORRIDOR, calibrate, trajectory

TRUE_MOUNT = CORRIDOR / "true_mount.toml"


def test_rests_with_one_for_a_move_are_told_as_exchanged(tmp_path, works):
    works(*trajectory(mount=TRUE_MOUNT))
    path = pd.read_csv(tmp_path / "path.csv")
    path["stationary"] = 1 - path["stationary"]
    path.to_csv(tmp_path / "moves.csv", index=False)
    said = works(*trajectory(mount=TRUE_MOUNT), "--rests", "moves.csv").stderr
    assert "are 0 and 1 exchanged?" in said and "on its clock" not in said


def test_tilts_that_fit_several_orders_name_the_option(tmp_path, fails):
    tilts = pd.read_csv(CORRIDOR / "tilts.csv.gz")
    tilts[tilts["time_s"] < 12].to_csv(tmp_path / "two.csv", index=False)
    fails(*calibrate(tilts="two.csv"), says=["two.csv: ", "in which order (--order"])


def test_a_gyroscope_whose_unit_changes_is_named(tmp_path, fails):
    """Not as a frame that never rests, or as a foot."""
    table = pd.read_csv(CORRIDOR / "walk.csv.gz")
    rates = [name for name in table if "_gyr_" in name]
    table.loc[len(table) // 2 :, rates] *= 180 / np.pi
    table.to_csv(tmp_path / "walk.csv", index=False)
    line = trajectory(walk="walk.csv", mount=TRUE_MOUNT)
    said = fails(*line, says=["walk.csv: frame_gyr", "is it in deg/s there?"])
    assert "foot" not in said and "rest" not in said
