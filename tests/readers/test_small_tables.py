"""Tables of rests and poses, as people and spreadsheets write them, and tables of nothing."""

import dialects
import numpy as np
import pandas as pd
import pytest
from test_dialects import made, quietly

from mobility_imu.cli.scooter import read_poses
from mobility_imu.errors import InputError
from mobility_imu.readers.actigraph import read_actigraph
from mobility_imu.readers.rests import read_rests
from mobility_imu.readers.streams import Asked

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


def test_a_table_of_shimmer_without_a_sensor(tmp_path):
    """A damaged line of the separator is taken for the names."""
    text = dialects.shimmer(made(), tmp_path).read_text()
    (tmp_path / "a.csv").write_text(text.replace('"sep=;"', '"sep=;{"'))
    with pytest.raises(InputError, match=r"no column Shimmer_\.\.\._CAL \(it has: sep="):
        quietly(tmp_path / "a.csv")


def test_a_table_of_androsensor_without_rows(tmp_path):
    path = dialects.androsensor(made(), tmp_path)
    path.write_text(path.read_text().partition("\n")[0] + "\n")
    with pytest.raises(InputError, match="a header, but no rows of data"):
        quietly(path)


def test_a_start_that_no_clock_has(tmp_path):
    """Where no row tells the time either."""
    head, rows = dialects.actigraph(made(), tmp_path).read_text().split("Timestamp,")
    rows = "\n".join(row.partition(",")[2] for row in f"Timestamp,{rows}".split("\n"))
    text = head.replace("08:58:00", f"08:58:{'9' * 30}") + rows
    with pytest.raises(InputError, match=r"a\.csv: 'Start Date .*' of the head are no date"):
        read_actigraph(text, "a.csv", Asked())


def test_a_row_of_units_that_is_too_short(tmp_path):
    path = dialects.apdm(made(), tmp_path)
    lines = path.read_text().split("\n")
    path.write_text("\n".join([*lines[:3], "s,m/s^2,m/s^2,m/s^2", *lines[4:]]))
    with pytest.raises(InputError, match="angular rate in '' is not known"):
        quietly(path)
