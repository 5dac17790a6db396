"""Scooter, mended readings: what was not lost stays, and what cannot come back is refused."""

import numpy as np
import pytest
from rides import ride

from mobility_imu.errors import InputError
from mobility_imu.runs import runs_of
from mobility_imu.scooter import SUZUKI_ET4D
from mobility_imu.scooter.mended import carried, cut_axes, lengthened, stretched
from mobility_imu.simulation import faults as put


def cut_rows(values, limit):
    return (np.abs(values) == limit).any(axis=1)


def test_an_axis_that_is_not_cut_keeps_its_readings():
    """Flags are of samples: only axes at the end of the range are mended."""
    for sensor, limit in (("lever", 9.0), ("body", 9.0)):
        faulty = put.clip(ride(), sensor, "acc", limit)
        was = faulty.sensor(sensor).acc_mps2
        flags = cut_rows(was, limit)
        back = lengthened(faulty, sensor, flags).sensor(sensor).acc_mps2
        at_end = np.abs(was) == limit
        assert (back[~at_end] == was[~at_end]).all()
        assert np.abs(back[at_end]).max() > limit + 0.5
    faulty = put.clip(ride(), "body", "gyr", 0.2)
    was = faulty.gyroscope("body")
    back = stretched(faulty, "body", cut_rows(was, 0.2), SUZUKI_ET4D, None).gyroscope("body")
    at_end = np.abs(was) == 0.2
    assert (back[~at_end] == was[~at_end]).all() and (back[at_end] != was[at_end]).any()


def test_the_bow_over_a_cut_peak_is_highest_in_its_middle():
    faulty = put.clip(ride(), "body", "gyr", 0.2)
    was = faulty.gyroscope("body")
    back = stretched(faulty, "body", cut_rows(was, 0.2), SUZUKI_ET4D, None).gyroscope("body")
    bows = 0
    for axis, other in zip(was.T, back.T, strict=True):
        for run in runs_of(np.abs(axis) == 0.2):
            assert np.allclose(other[run], other[run][::-1], rtol=1e-12)
            bows += np.ptp(other[run]) > 0.05
    assert bows > 1


def test_a_peak_of_two_samples_is_not_cut():
    values = np.zeros((20, 3))
    values[3:6, 0], values[10:12, 1], values[14:18, 2] = -5.0, 5.0, 4.0
    flags = (values != 0).any(axis=1)
    ((axis, readings, limit, at_end),) = cut_axes(values, flags)
    assert (axis, limit) == (0, 5.0) and (readings == values[:, 0]).all()
    assert np.flatnonzero(at_end).tolist() == [3, 4, 5]
    values[18, 0] = 50.0
    assert len(list(cut_axes(values, flags))) == 1  # a spike is no wider range
    values[17:, 0] = 5.5
    assert list(cut_axes(values, flags)) == []


@pytest.mark.parametrize("start_s", [0.0, 0.2])
def test_without_a_reading_beside_a_loss_nothing_comes_back(start_s):
    faulty = put.freeze(ride(), "lever", "acc", start_s, 100.0)
    flags = ride().time_s >= start_s
    with pytest.raises(InputError, match="lever_acc has no reading beside a loss"):
        carried(faulty, "lever", flags, SUZUKI_ET4D, None)
