"""An accelerometer without gravity: an axis is dead, or gravity was taken out."""

import dialects
import numpy as np
import pytest
from test_dialects import made, quietly

from mobility_imu.errors import InputError
from mobility_imu.frames import STANDARD_GRAVITY_MPS2
from mobility_imu.readers import read_recording
from mobility_imu.recording import Imu, Recording

NAMES = ("frame", "left_wheel")


def upright(spoil):
    """Two sensors that stand upright, the second with readings that are spoiled."""
    rng = np.random.default_rng(3)
    acc = rng.normal([0, 0, STANDARD_GRAVITY_MPS2], 0.05, (400, 3))
    half = rng.normal(0, 0.01, (400, 3))
    return np.arange(400) / 100, {
        "frame": Imu(acc, half),
        "left_wheel": Imu(spoil(acc.copy()), half),
    }


def table(path, time_s, sensors):
    columns = {"time_s": time_s}
    for name, imu in sensors.items():
        for half, unit in (("acc", "mps2"), ("gyr", "radps")):
            for axis, values in zip("xyz", getattr(imu, f"{half}_{unit}").T, strict=True):
                columns[f"{name}_{half}_{axis}_{unit}"] = values
    rows = np.column_stack(list(columns.values()))
    np.savetxt(path, rows, delimiter=",", header=",".join(columns), comments="", fmt="%.6f")
    return path


def with_axis(axis, value):
    def spoil(acc):
        acc[:, axis] = value
        return acc

    return spoil


@pytest.mark.parametrize("value", [0.0, -0.5])
def test_a_dead_axis_is_named_and_no_gravity_that_was_taken_out(tmp_path, value):
    path = table(tmp_path / "static.csv", *upright(with_axis(2, value)))
    with pytest.raises(InputError) as error:
        quietly(path)
    assert f"static.csv: left_wheel_acc_z is {value:g} m/s² throughout" in str(error.value)
    assert "it is dead" in str(error.value) and "taken out" not in str(error.value)


@pytest.mark.parametrize(
    ("more", "left"),
    [((), "seat is left out, since it is"), (("back",), "seat, back are left out, since they are")],
)
def test_what_is_filled_is_told_once_where_sensors_are_left_out(tmp_path, more, left):
    """Without the sensor that is refused, the others are read a second time."""
    time_s, sensors = upright(lambda acc: acc)
    frame = sensors["frame"]
    in_g = Imu(frame.acc_mps2 / STANDARD_GRAVITY_MPS2, frame.gyr_radps)
    sensors |= dict.fromkeys(("seat", *more), in_g)
    kept = np.r_[:200, 205:400]
    gap = {k: Imu(one.acc_mps2[kept], one.gyr_radps[kept]) for k, one in sensors.items()}
    path = table(tmp_path / "static.csv", time_s[kept], gap)
    with pytest.warns(UserWarning) as told:
        read_recording(path, fill_gaps_s=1.0, expected=NAMES)
    said = [str(one.message) for one in told]
    assert sum("1 gap(s) filled in" in text for text in said) == 1
    assert sum(f"; {left} not needed" in text for text in said) == 1
    whole = {name: gap["frame"] for name in (*NAMES, "seat", *more)}
    path = table(tmp_path / "whole.csv", time_s[kept], whole)
    with pytest.warns(UserWarning, match=r"1 gap\(s\) filled in") as told:
        read_recording(path, fill_gaps_s=1.0, expected=NAMES)
    assert len(told) == 1


def test_sensors_with_stamps_of_their_own_have_dead_axes_too(tmp_path):
    whole = made(("lever", "body"), count=1000)
    acc = np.array(whole.sensor("body").acc_mps2)
    upward = int(np.argmax(np.abs(acc).mean(axis=0)))
    path = dialects.lpms(whole, tmp_path)
    head, *rows = path.read_text().rstrip().split("\n")
    names = [name.strip().lower() for name in head.split(",")]
    place = next(k for k, name in enumerate(names) if name.startswith(f"acc{'xyz'[upward]}"))
    cells = [row.split(",") for row in rows]
    for row in cells:
        if row[0] == "2":
            row[1], row[place] = str(float(row[1]) + 0.004), "0.0"
    path.write_text("\n".join([head, *map(",".join, cells), ""]))
    with pytest.raises(InputError, match=rf"body_acc_{'xyz'[upward]} is 0 m/s² throughout"):
        quietly(path, expected=("lever", "body"))


@pytest.mark.parametrize(
    ("spoil", "says"),
    [
        (lambda acc: acc - (0, 0, STANDARD_GRAVITY_MPS2), "was gravity taken out"),
        (lambda acc: np.zeros_like(acc), "was gravity taken out"),  # all: nothing was recorded
        (lambda acc: acc / STANDARD_GRAVITY_MPS2, "looks like g"),
    ],
)
def test_gravity_without_a_dead_axis_is_told_as_before(tmp_path, spoil, says):
    with pytest.raises(InputError, match=says):
        quietly(table(tmp_path / "a.csv", *upright(spoil)))


def test_a_dead_axis_beside_gravity_is_left_to_the_look_at_faults(tmp_path):
    time_s, sensors = upright(with_axis(0, 0.0))
    assert isinstance(quietly(table(tmp_path / "a.csv", time_s, sensors)), Recording)
