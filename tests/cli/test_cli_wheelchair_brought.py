"""Commands of the wheelchair on inputs as people bring them."""

import json

import numpy as np
import pandas as pd
import pytest
from command_lines import COURT, velocity, velocity_csv


def with_wrist(path, folder):
    """A recording beside whose chair a dead sensor was recorded; returns its name."""
    table = pd.read_csv(path)
    for axis in "xyz":
        table[f"wrist_acc_{axis}_mps2"] = 9.8 * (axis == "z")
        table[f"wrist_gyr_{axis}_radps"] = 0.0
    name = path.name.removesuffix(".gz")
    table.to_csv(folder / name, index=False)
    return name


def test_strict_looks_at_no_sensor_that_is_not_the_chairs(tmp_path, works):
    names = {
        part: with_wrist(COURT / f"{part}.csv.gz", tmp_path)
        for part in ("court", "static", "straight")
    }
    done = works(
        *velocity(names["court"], static=names["static"], straight=names["straight"]), "--strict"
    )
    assert "wrist_" not in done.stderr


@pytest.mark.parametrize(("segment_s", "says"), [(1e-9, "less than one frame"), (1e9, "frames")])
def test_a_segment_that_is_none_is_the_settings_fault(tmp_path, fails, segment_s, says):
    velocity_csv(tmp_path / "v.csv")
    (tmp_path / "s.json").write_text(json.dumps({"segment_s": segment_s}))
    line = fails(
        "wheelchair", "tasks", "v.csv", "--settings", "s.json", "-o", "k.csv",
        says=["s.json: segment_s", says],
    )  # fmt: skip
    assert "v.csv" not in line and "its times" not in line


def test_a_window_longer_than_a_trial_names_the_trial(tmp_path, fails):
    fails(
        *velocity(), "--filter", "moving-average", "--filter-window", "999",
        says=["static.csv.gz: --filter-window 999: longer than the"],
    )  # fmt: skip


def test_turns_on_the_spot_print_no_number_that_is_none(tmp_path, works):
    from mobility_imu.simulation.sensor import MTI_1
    from mobility_imu.simulation.wheelchair import Leg, random_mounting, simulate_court
    from mobility_imu.wheelchair import WheelchairGeometry

    chair = WheelchairGeometry.from_degrees(
        3, wheel_radius_left_m=0.305, wheel_radius_right_m=0.305, track_m=0.58
    )
    legs = {
        "static": (Leg(1, 3.0),),
        "straight": (Leg(1, 1.0), Leg(2, 5.0, 1.2), Leg(1, 1.0)),
        "spot": (Leg(1, 2.0), Leg(4, 4.0, 0, 300), Leg(1, 2.0), Leg(4, 4.0, 0, -300), Leg(1, 2.0)),
    }
    for k, (name, course) in enumerate(legs.items()):
        court = simulate_court(
            course, chair, random_mounting(900_002), seed=900_010 + k, unit_seed=1, model=MTI_1
        )
        court.recording.to_frame().to_csv(tmp_path / f"{name}.csv", index=False)
    chair.to_toml(tmp_path / "g.toml")
    done = works(
        "wheelchair", "check", "spot.csv", "--static", "static.csv", "--straight", "straight.csv",
        "--geometry", "g.toml",
    )  # fmt: skip
    assert "nan" not in done.stdout
    assert "right over left radius      not found" in done.stdout
    assert np.isclose(
        float(done.stdout.partition("fits the turns   ")[2].split()[0]), 0.58, atol=0.02
    )
