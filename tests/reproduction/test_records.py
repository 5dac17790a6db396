"""Each record is of the code that stands here: what quotes a number of it is not out of date."""

import pytest

from mobility_imu.reproduction import recorded


@pytest.mark.parametrize("name", recorded.STUDIES)
def test_a_record_is_of_this_code(name):
    assert not recorded.is_stale(name), f"python -m mobility_imu.reproduction.recorded {name}"
