"""Scooter, exchanges: one half of both sensors under the other's name is told as that."""

import numpy as np
import pytest
from rides import FUSION, mount, ride, slow, turned

from mobility_imu.faults import half_of
from mobility_imu.scooter import SUZUKI_ET4D, RideSettings, find_faults
from mobility_imu.scooter.contradictions import contradictions
from mobility_imu.scooter.exchanges import exchanged_halves
from mobility_imu.simulation import faults as put
from mobility_imu.simulation.scooter import (
    COURSES,
    draw_driver,
    draw_scooter,
    simulate_parked,
    simulate_ride,
)
from mobility_imu.simulation.sensor import REAL

HALVES = ["gyr", "acc"]
OTHERS = sorted(COURSES.keys() - {"curves", "straight"})


def test_an_exchange_moves_one_half_of_both_and_undoes_itself():
    wrong = exchanged_halves(ride(), "gyr")
    assert np.array_equal(wrong.gyroscope("lever"), ride().gyroscope("body"))
    assert np.array_equal(wrong.gyroscope("body"), ride().gyroscope("lever"))
    back = exchanged_halves(wrong, "gyr")
    for name in ("lever", "body"):
        assert np.array_equal(wrong.sensor(name).acc_mps2, ride().sensor(name).acc_mps2)
        for half in HALVES:
            assert np.array_equal(half_of(back, name, half), half_of(ride(), name, half))


@pytest.mark.parametrize("half", HALVES)
@pytest.mark.parametrize("course", ["curves", "straight", *map(slow, OTHERS)])
@pytest.mark.parametrize("calibrated", [True, False])
def test_exchanged_halves_are_all_that_is_told(half, course, calibrated):
    wrong = exchanged_halves(ride(51, course), half)
    mounted = mount() if calibrated else None
    (found,) = contradictions(wrong, SUZUKI_ET4D, mounted).faults
    assert (found.code, found.sensor) == ("exchanged", f"lever_{half}, body_{half}")
    mended = found.repair(wrong)
    assert np.array_equal(half_of(mended, "lever", half), half_of(ride(51, course), "lever", half))


@pytest.mark.parametrize("half", HALVES)
def test_exchanged_halves_of_coarse_uncalibrated_sensors(half):
    sound = simulate_ride(
        COURSES["curves"], seed=53, unit=draw_scooter(53), driver=draw_driver(53), sensor=REAL
    )
    wrong = exchanged_halves(sound.recording, half)
    (found,) = find_faults(wrong, SUZUKI_ET4D, None, FUSION)
    assert (found.code, found.sensor) == ("exchanged", f"lever_{half}, body_{half}")


@pytest.mark.parametrize("pitch_deg", [0.0, 5.0])
def test_exchanged_gyroscopes_of_a_parked_recording(pitch_deg):
    """The lever turns on its hinges; where the body's gyroscope does so, it is the lever's."""
    parked = simulate_parked(
        pitch_rad=np.deg2rad(pitch_deg), bank_rad=0.0, seed=5, unit=draw_scooter(51)
    )
    (found,) = find_faults(exchanged_halves(parked, "gyr"), SUZUKI_ET4D)
    assert (found.code, found.sensor) == ("exchanged", "lever_gyr, body_gyr")


def test_the_sentence_says_what_where_and_what_to_do():
    wrong = exchanged_halves(ride(), "gyr")
    (found,) = find_faults(wrong, SUZUKI_ET4D, None, FUSION)
    assert found.sentence == (
        "simulated ride, curves: lever_gyr, body_gyr have each other's readings: each gyroscope "
        "fits the other sensor's accelerometer; exchange the gyr columns of both sensors, or look "
        "at how they were put together"
    )
    assert max(cost.largest for cost in found.costs) > 5
    (found,) = find_faults(wrong, SUZUKI_ET4D, None, RideSettings())
    assert found.sentence.endswith("the closed form does not use it")


@pytest.mark.parametrize("sensor", ["lever", "body"])
def test_a_sensor_turned_by_half_a_turn_is_no_exchange(sensor):
    (found,) = contradictions(turned(ride(), sensor, "z", 180), SUZUKI_ET4D, mount()).faults
    assert (found.code, found.sensor, found.size) == ("turned", sensor, 180)


def test_sensors_with_each_others_names_are_told_as_whole():
    (found,) = contradictions(put.exchange(ride(), "lever", "body"), SUZUKI_ET4D, None).faults
    assert (found.code, found.sensor) == ("exchanged", "lever, body")
    # Both halves, one after the other, are the whole.
    both = exchanged_halves(exchanged_halves(ride(), "gyr"), "acc")
    (found,) = contradictions(both, SUZUKI_ET4D, None).faults
    assert found.sensor == "lever, body"
