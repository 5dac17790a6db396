"""Walking frame on the command line: files as people bring them."""

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
