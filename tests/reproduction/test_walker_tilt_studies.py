"""What the walker's chapters on the calibration compute: small studies of simulated tilts."""

import numpy as np
import pytest

from mobility_imu.reproduction.walker.studies import FOOTPRINT, LEVELS, calibration_study
from mobility_imu.reproduction.walker.tables import pose_mount, pose_translation
from mobility_imu.reproduction.walker.tilt_studies import (
    edge_distances,
    first_part,
    gain_table,
    late_velocity_bias,
    source_table,
    table_1_simulated,
    tilt_paths,
    tilts_on_a_slope,
)
from mobility_imu.simulation.walker import Imperfections
from mobility_imu.walker.calibration import calibrate_mount
from mobility_imu.walker.tilt_equations import position_four_tilts


@pytest.fixture(scope="module")
def tilted():
    return tilt_paths((0,), LEVELS["data sheet"], poses=("1", "4"))


@pytest.mark.parametrize("place", [(0.3, 0.1, 0.6), (-0.05, 0.35, 0.6)])
def test_distances_from_the_edges_give_the_place_back(place):
    found = position_four_tilts(edge_distances(place), FOOTPRINT)
    np.testing.assert_allclose(found, place, atol=1e-12)


def test_a_root_magnifies_errors_near_the_rear_edge():
    gains = gain_table()
    assert list(gains.index) == list("12345")
    assert gains["x, paper's root"].idxmax() == "5" and gains["x, ours"].max() < 2.5


def test_a_late_velocity_pulls_the_position_back_by_its_height_times_the_angle(tilted):
    bias = late_velocity_bias(tilted, (2.0, 6.0))
    assert bias["printed"].shape == (2, 3)
    height = np.mean([pose_translation(pose, 1)[2] for pose in ("1", "4")])
    change = bias["printed"][1, 0] - bias["printed"][0, 0]
    assert change == pytest.approx(-height * np.deg2rad(4), rel=0.15)
    assert np.abs(bias["corrected"]).max() < 0.006


def test_opposite_edges_cancel_tips_that_turn_on_their_rims():
    sizes = {"none": Imperfections(), "rims": Imperfections(ferrule_edge_m=0.03)}
    table = source_table((0,), sizes)
    assert list(table.index) == ["none", "rims"]
    grown = table.loc["rims"] - table.loc["none"]
    assert grown["all samples"] < 2 < 20 < grown["method 2, tilt added back"]


def test_simulated_table_1_has_the_papers_positions_beside_ours():
    one = calibration_study((0,), {"realistic": LEVELS["realistic"]})
    table = table_1_simulated(one)
    first = [float(v) for v in table.loc["1", "paper T1 (= truth), m"].split(", ")]
    np.testing.assert_allclose(first, pose_translation("1", 1), atol=0.005)
    apart = [pose_translation("2", 1), pose_translation("2", 2)]
    expected = 1000 * np.linalg.norm(apart[0] - apart[1])
    assert table.loc["2", "paper |T1−T2|, mm"] == pytest.approx(expected)
    assert (table["ours, mm"] > 0).all() and set(table["form"]) <= {"paper's", "no root: without"}


def test_a_part_of_a_recording_ends_where_it_is_told_to(tilted):
    whole = tilted[0].run.recording
    part = first_part(whole, 5.0)
    assert part.time_s[-1] < 5.0 <= whole.time_s[len(part)]
    np.testing.assert_array_equal(part.gyroscope("frame"), whole.gyroscope("frame")[: len(part)])


def test_a_slope_moves_what_takes_gravity_for_the_bodys_vertical():
    sloping = tilts_on_a_slope(2.0).recording
    mount = calibrate_mount(sloping, FOOTPRINT).mount
    true = pose_mount("1").translation_body_m
    off = mount.translation_body_m[0] - true[0]
    assert off == pytest.approx(-true[2] * np.deg2rad(2), abs=0.002)
