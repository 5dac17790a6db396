"""Tables of rests and poses, as people and spreadsheets write them."""

import numpy as np
import pandas as pd
import pytest

from mobility_imu.cli.scooter import read_poses
from mobility_imu.readers.rests import read_rests

TIME_S = np.arange(600) / 100
RESTS = TIME_S < 3
POSES_DEG = [(0.0, 0.0), (30.5, 0.0), (-30.5, 20.0)]
DRESSES = {
    "plain": {},
    "German spreadsheet": {"sep": ";", "decimal": ","},
    "tabs": {"sep": "\t"},
    "UTF-16": {"encoding": "utf-16"},
    "quoted": {"quoting": 1},
}


@pytest.mark.parametrize("dress", DRESSES)
def test_rests_with_a_column_of_words(tmp_path, dress):
    table = pd.DataFrame({"time_s": TIME_S, "stationary": RESTS.astype(int), "note": "by eye"})
    table.to_csv(tmp_path / "r.csv", index=False, **DRESSES[dress])
    assert np.array_equal(read_rests(tmp_path / "r.csv", TIME_S), RESTS)


@pytest.mark.parametrize("dress", DRESSES)
def test_poses_with_a_column_of_words(tmp_path, dress):
    table = pd.DataFrame(POSES_DEG, columns=["steering_deg", "throttle_deg"]).assign(pose="stop")
    table.to_csv(tmp_path / "p.csv", index=False, **DRESSES[dress])
    np.testing.assert_allclose(np.rad2deg(read_poses(tmp_path / "p.csv")), POSES_DEG)
