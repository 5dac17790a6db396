"""Constants that the fusion learns: an error that no sensor has is named, of the right sensor."""

import numpy as np
import pytest
from rides import FUSION, mount, ride
from scipy.stats import norm

from mobility_imu.scooter import SUZUKI_ET4D, FusionSettings, estimate_ride, fusion
from mobility_imu.scooter.fusion_constants import (
    UNLIKELY_SDS,
    constant_deviations,
    unlikely_constant,
)
from mobility_imu.scooter.fusion_filter import ARMS, BODY, CONSTANTS

SIZES = FusionSettings()


def test_every_constant_has_the_deviation_of_its_kind():
    sd = constant_deviations(SIZES)
    assert sd.shape == (CONSTANTS,) and np.array_equal(sd[:BODY], sd[BODY:ARMS])
    assert (sd[:3] == SIZES.acc_offset_sd_mps2).all() and (sd[3:6] == SIZES.acc_scale_sd).all()
    assert (sd[6:9] == SIZES.misalignment_sd_rad).all() and (sd[9:12] == SIZES.gyr_scale_sd).all()
    assert (sd[12:15] == SIZES.bias_sd_radps).all() and (sd[15:18] == SIZES.axes_apart_sd_rad).all()
    assert (sd[ARMS:] == SIZES.lever_arm_sd_m).all()


def test_how_often_a_sound_recording_is_told_of_by_chance():
    """Of the constants, those are judged that are told at twice the limit, one at a time."""
    judged = 0
    for place in range(CONSTANTS):
        learned = np.zeros(CONSTANTS)
        learned[place] = 2 * UNLIKELY_SDS * constant_deviations(SIZES)[place]
        judged += len(unlikely_constant(learned, SIZES))
    assert judged == 24
    assert 1 / (judged * 2 * norm.sf(UNLIKELY_SDS)) == pytest.approx(660, abs=5)


@pytest.mark.parametrize("calibrated", [True, False])
def test_sound_rides_stay_far_below_the_limit(calibrated, monkeypatch):
    """At less than half of it: what a ride learns follows from its noise, seeds differ."""
    learned = []

    def watched(constants, settings):
        sd = constant_deviations(settings)[:ARMS].reshape(2, -1, 3)
        learned.append(np.abs(constants[:ARMS].reshape(2, -1, 3) / sd)[:, :4].max())
        return ()

    monkeypatch.setattr(fusion, "unlikely_constant", watched)
    estimate_ride(ride(), SUZUKI_ET4D, mount() if calibrated else None, FUSION)
    assert learned and 0 < max(learned) < UNLIKELY_SDS / 2


@pytest.mark.parametrize(
    ("place", "words"),
    [
        (0, "lever's accelerometer's offset is off by 5 times what is assumed (axis x)"),
        (5, "lever's accelerometer's scale is off by 5 times what is assumed (axis z)"),
        (BODY + 7, "body's turn is off by 5 times what is assumed (axis y)"),
        (BODY + 9, "body's gyroscope's scale is off by 5 times what is assumed (axis x)"),
        (12, None),
        (BODY + 15, None),
        (ARMS, None),
    ],
)
def test_an_error_that_no_sensor_has_is_named(place, words):
    """Offsets of gyroscopes show at rest, and lever arms are what the mounting makes them."""
    for times, told in ((-5.0, words is not None), (3.9, False)):
        learned = np.zeros(CONSTANTS)
        learned[place] = times * constant_deviations(SIZES)[place]
        found = unlikely_constant(learned, SIZES)
        assert len(found) == told
        assert not told or words in found[0]
