"""Recordings: converted, copied, read-only, checked once; picklable and of one line."""

import copy
import pickle
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from steps_taken import steps_of

from mobility_imu.errors import InputError
from mobility_imu.recording import Imu, Recording

STILL = np.tile([0.0, 0.0, 9.81], (200, 1))
TIME_S = np.arange(200) / 100


def recording(**sensors):
    sensors = sensors or {"frame": Imu(STILL, 0 * STILL), "lever": Imu(STILL)}
    return Recording(TIME_S, sensors, source="walk.csv")


DRESS = {
    "lists": lambda a: a.tolist(),
    "table": lambda a: pd.DataFrame(a, columns=list("xyz")),
    "objects": lambda a: a.astype(object),
    "float32": lambda a: a.astype(np.float32),
    "big-endian": lambda a: a.astype(">f8"),
    "by columns": np.asfortranarray,
    "every second": lambda a: np.repeat(a, 2, axis=0)[::2],
    "read-only": lambda a: np.frombuffer(a.tobytes()).reshape(a.shape),
}


@pytest.mark.parametrize("dress", DRESS)
def test_readings_are_converted(dress):
    made = recording(frame=Imu(DRESS[dress](STILL), DRESS[dress](0 * STILL)))
    for array in (made.sensor("frame").acc_mps2, made.gyroscope("frame")):
        assert array.dtype == np.float64 and array.dtype.isnative and array.flags.c_contiguous
    assert made.sensor("frame").acc_mps2 == pytest.approx(STILL)
    assert len(made.trim(0, 1)) == 100 and made.to_frame().shape == (200, 7)


def test_integers_are_readings():
    """Of int16 the largest size could not be held."""
    acc = np.tile(np.array([0, 0, -32768], np.int16), (200, 1))
    assert np.abs(Imu(acc).acc_mps2).max() == 32768
    assert len(recording(frame=Imu(np.tile([0, 0, 10], (200, 1))))) == 200


@pytest.mark.parametrize(
    "values",
    [
        *(None, 1.0, "text", [1, 2, 3], np.zeros((200, 2)), np.zeros((2, 200, 3)), 1j * STILL),
        *(STILL > 1, STILL.astype("M8[s]"), STILL.astype(str), [[1, 2], [3]]),
        np.ma.masked_array(STILL, STILL > 1),
    ],
    ids=lambda values: type(values).__name__,
)
def test_what_is_no_series_of_readings(values):
    with pytest.raises(InputError, match="acc_mps2: expected"):
        Imu(values, STILL)
    if values is not None:
        with pytest.raises(InputError, match="gyr_radps: expected"):
            Imu(STILL, values)
    with pytest.raises(InputError, match="like the others"):
        Imu(STILL, STILL[1:])


def test_no_later_change_of_the_input_reaches_a_recording():
    acc, gyr, clock = STILL.copy(), 0 * STILL, TIME_S.copy()
    sensors = {"frame": Imu(acc, gyr)}
    made = Recording(clock, sensors)
    acc[0, 0] = gyr[0, 0] = clock[1] = np.nan
    sensors["more"] = None
    assert np.isfinite(made.sensor("frame").acc_mps2).all() and made.time_s[1] == 0.01
    assert np.isfinite(made.gyroscope("frame")).all() and list(made.sensors) == ["frame"]


def test_a_recording_is_read_only():
    made = recording()
    for array in (made.time_s, made.sensor("frame").acc_mps2, made.gyroscope("frame")):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1
    with pytest.raises(TypeError):
        made.sensors["frame"] = Imu(STILL)
    with pytest.raises(AttributeError):
        made.time_s = TIME_S


def check_same(found, made):
    pd.testing.assert_frame_equal(found.to_frame(), made.to_frame())
    assert repr(found) == repr(made) and type(found) is type(made)
    with pytest.raises(ValueError, match="read-only"):
        found.sensor("frame").acc_mps2[0] = 1
    with pytest.raises(TypeError):
        found.sensors["frame"] = Imu(STILL)


@pytest.mark.parametrize(
    "way",
    [copy.copy, copy.deepcopy, lambda r: pickle.loads(pickle.dumps(r)), lambda r: r.trim(-1, 9)],
)
def test_copies_are_recordings_too(way):
    check_same(way(recording()), recording())


def later(given):
    return given.trim(0.5, np.inf)


def test_a_recording_goes_to_another_process_and_back():
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        check_same(pool.submit(later, recording()).result(), later(recording()))


def test_two_recordings_differ_unless_they_are_one():
    one, other = recording(), recording()
    assert one == one and one != other and len({one, other}) == 2
    assert one in [other, one] and Imu(STILL) != Imu(STILL)


def test_a_repr_is_one_line():
    assert repr(recording()) == (
        "Recording('walk.csv', 200 samples, 100 Hz, 1.99 s: frame[acc, gyr], lever[acc])"
    )
    assert repr(Imu(STILL)) == "Imu(acc_mps2[200 x 3], gyr_radps=None)"


@pytest.mark.parametrize(
    ("clock", "says"),
    [
        (TIME_S[:0], "0 sample"),
        (TIME_S[:1], "1 sample"),
        (TIME_S[::-1], "runs backwards at sample 1"),
        (np.where(TIME_S > 1, TIME_S + 1, TIME_S), "gap of 1.01 s after 1 s"),
        (np.where(TIME_S == 1, 0.99, TIME_S), "appears twice"),
        (np.where(TIME_S == 1, np.nan, TIME_S), "sample 100 is nan"),
        (TIME_S * 1e-320, "steps of"),
        (TIME_S[:-1], "expected shape (199, 3)"),
        (pd.date_range("2026", periods=200), "got dates"),
        (TIME_S.astype(str), "got text"),
        (None, "expected"),
        (TIME_S[:, None], "one time series"),
    ],
)
def test_clocks_that_are_none(clock, says):
    with pytest.raises(InputError) as error:
        Recording(clock, {"frame": Imu(STILL)}, source="walk.csv")
    assert str(error.value).startswith("walk.csv: ") and says in str(error.value)


@pytest.mark.parametrize(
    "sensors",
    [None, {}, [Imu(STILL)], {"frame": STILL}, {"frame": None}, {1: Imu(STILL)}, {"": Imu(STILL)}],
    ids=lambda sensors: type(sensors).__name__,
)
def test_sensors_that_are_none(sensors):
    with pytest.raises(InputError) as error:
        Recording(TIME_S, sensors, source="walk.csv")
    message = str(error.value)
    assert message.startswith("walk.csv: ") and "\n" not in message and len(message) < 150


@pytest.mark.parametrize("quantity", ["acc", "gyr"])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_readings_that_are_not_finite_are_named(quantity, value):
    broken = (STILL if quantity == "acc" else 0 * STILL).copy()
    broken[7, 1] = value
    imu = Imu(broken) if quantity == "acc" else Imu(STILL, broken)
    with pytest.raises(InputError, match=rf"walk\.csv: frame_{quantity}_y: sample 7 is {value}"):
        recording(frame=imu)


@pytest.mark.parametrize(
    ("factor", "says"),
    [
        (1 / 9.81, "looks like g"),
        (1000 / 9.81, "milli-g"),
        (1e3, "mm/s²"),
        (10, "fast wheel"),
        (0.01, "gravity taken out"),
        (1e300, "mm/s²"),
        (0, "gravity taken out"),
    ],
)
def test_other_units_are_guessed(factor, says):
    with pytest.raises(InputError, match=says):
        recording(frame=Imu(factor * STILL))


@pytest.mark.parametrize("value", [4001, -1e5, 1e30, 1.7e308])
def test_readings_that_no_sensor_gives_are_named(value):
    broken = STILL.copy()
    broken[7, 1] = value
    with pytest.raises(InputError, match=r"walk\.csv: frame_acc_y is .* \(sample 7\), more than"):
        recording(frame=Imu(broken))


def test_rates_in_degrees_are_guessed():
    with pytest.raises(InputError, match="looks like deg/s"):
        recording(frame=Imu(STILL, np.full_like(STILL, 90.0)))


@pytest.mark.parametrize("name", ["body", "", None, 1, [], {}])
def test_the_sensors_that_there_are_are_listed(name):
    with pytest.raises(InputError, match=r"walk\.csv: no sensor .* \(it has: frame, lever\)"):
        recording().sensor(name)
    with pytest.raises(InputError, match="no gyroscope columns"):
        recording().gyroscope("lever")
    assert recording().gyroscope("frame").shape == (200, 3)


@pytest.mark.parametrize("ends", [(5, 9), (1, 0), (np.nan, 1), ("0", 1), (None, 1), (0, 0.001)])
def test_ends_that_leave_nothing(ends):
    with pytest.raises(InputError):
        recording().trim(*ends)


@pytest.mark.parametrize("rate", [0, -1, np.nan, np.inf, 1e9, "100", None, 0.1])
def test_rates_that_none_can_have(rate):
    with pytest.raises(InputError):
        recording().resample(rate)


def test_another_rate():
    made = recording().resample(50.0)
    assert len(made) == 100 and made.sampling_rate_hz == 50.0
    assert made.gyroscope("frame").shape == (100, 3)


def test_a_source_may_be_a_path():
    made = Recording(TIME_S, {"frame": Imu(STILL)}, source=Path("walk.csv"))
    check_same(pickle.loads(pickle.dumps(made)), made)


def test_checks_and_copies_look_at_no_row_by_itself():
    """A day at 100 Hz: nine million rows would take minutes if rows were looked at one by one."""

    def steps(count):
        acc = np.tile(STILL[:1], (count, 1))
        return steps_of(lambda: Recording(np.arange(count) / 100, {"frame": Imu(acc, 0 * acc)}))

    steps(50)  # what is imported late
    # 450 rows more, and not half a step for each; numpy chooses its ways by size.
    assert steps(500) < steps(50) + 450 / 2
