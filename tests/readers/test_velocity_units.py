"""Velocity files: units of the clock, and of the velocities wherever their names state them."""

import numpy as np
import pytest

from mobility_imu.errors import InputError
from mobility_imu.readers.velocities import read_velocities

COUNT = 300


@pytest.fixture
def written(tmp_path):
    """A file of a steady drive at 100 Hz under given names."""

    def write(clock, linear="Linear velocity (m/s)", angular="Angular velocity (rad/s)", unit=1.0):
        rows = [f"{k / 100 / unit:.12g},1.8,0.5" for k in range(COUNT)]
        path = tmp_path / "v.csv"
        path.write_text("\n".join([f"{clock},{linear},{angular}", *rows]) + "\n")
        return path

    return write


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("time_s", 1.0), ("Time", 1.0), ("Temps (s)", 1.0), ("time (ms)", 1e-3),
        ("time_ms", 1e-3), ("Timestamp [us]", 1e-6), ("time in seconds", 1.0),
        ("Tiempo (minutos)", 60.0), ("Time (min)", 60.0), ("Time (h)", 3600.0),
    ],
)  # fmt: skip
def test_the_unit_of_the_clock_is_used(written, name, unit):
    found = read_velocities(written(name, unit=unit))
    assert abs(found.sampling_rate_hz - 100) < 1e-3
    assert np.allclose(found.time_s, np.arange(COUNT) / 100)


def test_a_clock_in_another_unit_is_refused(written):
    for name in ("Time (days)", "time (s) [ms]"):
        with pytest.raises(InputError, match="expected one unit of time"):
            read_velocities(written(name))


def test_a_count_of_rows_is_no_clock(written):
    for name in ("time index", "time_frame", "Time (sample)"):
        with pytest.raises(InputError, match="no time column"):
            read_velocities(written(name, unit=0.01))
        with pytest.warns(UserWarning, match="counted at 50 Hz"):
            found = read_velocities(written(name, unit=0.01), sampling_rate_hz=50)
        assert found.sampling_rate_hz == 50


def test_a_given_rate_has_to_fit_the_clock(written):
    assert read_velocities(written("time_s"), sampling_rate_hz=100.5).sampling_rate_hz == 100
    with pytest.raises(InputError, match="has 100 Hz, but 50 Hz is given"):
        read_velocities(written("time_s"), sampling_rate_hz=50)


@pytest.mark.parametrize("name", ["mph linear velocity", "knots_lin", "ft/s lin", "lin in mph"])
def test_units_that_are_not_known_are_refused_wherever_they_stand(written, name):
    with pytest.raises(InputError, match="no unit that is known for the linear"):
        read_velocities(written("time_s", name), units="m/s, rad/s")


@pytest.mark.parametrize(
    "name",
    [
        "km/h linear velocity", "km/h_lin", "kmh_lin_speed", "linear velocity km per h",
        "lin velocity in kilometers per hour", "vitesse lin. en kilomètres par heure",
    ],
)  # fmt: skip
def test_units_count_wherever_they_stand(written, name):
    found = read_velocities(written("time_s", name))
    assert np.allclose(found.linear_velocity_mps, 0.5)
    with pytest.raises(InputError, match="is in km/h, but --units says m/s"):
        read_velocities(written("time_s", name), units="m/s, rad/s")


@pytest.mark.parametrize(
    "name",
    ["deg/s angular velocity", "deg/s_ang", "yaw_deg_per_s", "yaw rate in degrees per second"],
)
def test_units_of_the_yaw_rate_count_wherever_they_stand(written, name):
    found = read_velocities(written("time_s", angular=name))
    assert np.allclose(found.yaw_rate_radps, np.deg2rad(0.5))


@pytest.mark.parametrize("name", ["linear velocity sd (m/s)", "yaw_rate_std_degps"])
@pytest.mark.parametrize("cell", ["inf", "nan", "", "-0.1"])
def test_velocities_without_a_standard_deviation_are_not_valid(written, name, cell):
    path = written("time_s")
    head, *rows = path.read_text().rstrip().split("\n")
    rows = [f"{row},{cell if k in (3, 4) else 0.1}" for k, row in enumerate(rows)]
    path.write_text("\n".join([f"{head},{name}", *rows, ""]))
    assert np.flatnonzero(~read_velocities(path).valid).tolist() == [3, 4]
