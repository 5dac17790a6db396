"""Maps, geometries, settings and velocity series that say what cannot be meant."""

import itertools
import warnings

import numpy as np
import pytest

from mobility_imu.errors import InputError
from mobility_imu.files import csv_bytes
from mobility_imu.readers import read_recording
from mobility_imu.readers.column_map import read_mapped
from mobility_imu.readers.geometry import read_arrays, read_section
from mobility_imu.readers.recordings import understand
from mobility_imu.readers.settings import read_json_numbers
from mobility_imu.readers.velocities import read_velocities

ROWS = [f"{k / 100},{0.1 * (k % 3)},0.2,9.8,0.01,0.02,0.03" for k in range(20)]
TABLE = "\n".join(["t,ax,ay,az,gx,gy,gz", *ROWS]) + "\n"
MAP = {
    "names": "",
    "column": 'column = "t"',
    "unit": 'unit = "s"',
    "first_row": "",
    "section": "[sensors.frame]",
    "acc": 'acc = ["ax", "ay", "az"]',
    "acc_unit": 'acc_unit = "m/s2"',
    "gyr": 'gyr = ["gx", "gy", "gz"]',
    "gyr_unit": 'gyr_unit = "rad/s"',
    "more": "",
}


def mapped(folder, table=TABLE, **changed):
    """Streams of a table by a map whose lines are changed."""
    lines = MAP | changed
    plan = folder / "m.toml"
    head = [lines.pop("names"), "[clock]"]
    plan.write_text("\n".join([*head, *lines.values()]))
    return read_mapped(table, "t.csv", plan)


def refused(folder, **changed):
    with pytest.raises(InputError) as error:
        mapped(folder, **changed)
    message = str(error.value)
    assert message.startswith((f"{folder / 'm.toml'}", "t.csv: ")) and message.isprintable()
    return message


# Maps


@pytest.mark.parametrize(
    ("changed", "column"),
    [
        ({"acc": 'acc = ["ax", "ay", "ay"]'}, "ay"),
        ({"acc": 'acc = ["ax", "ay", "-ay"]'}, "ay"),
        ({"gyr": 'gyr = ["ax", "ay", "az"]'}, "ax"),
        ({"acc": 'acc = ["ax", "ay", "t"]'}, "t"),
        (
            {"more": '[sensors.body]\nacc = ["gx", "-gy", "gz"]\nacc_unit = "g"', "gyr": ""}
            | {"acc": 'acc = ["ax", "ay", "gz"]'},
            "gz",
        ),
    ],
)
def test_a_map_uses_no_column_twice(tmp_path, changed, column):
    assert f"column '{column}' is named twice" in refused(tmp_path, **changed)


@pytest.mark.parametrize("name", ['"left wheel"', '""', "left-wheel", '"a.b"', '"a\\n"', '"é ü"'])
def test_a_map_names_no_sensor_that_a_canonical_table_cannot(tmp_path, name):
    message = refused(tmp_path, section=f"[sensors.{name}]")
    assert "letters, digits and _ only" in message
    twins = '[sensors.Frame]\nacc = ["gx", "gy", "gz"]\nacc_unit = "g"'
    assert "upper and lower case" in refused(tmp_path, gyr="", gyr_unit="", more=twins)


@pytest.mark.parametrize("name", ["x", "_", "acc", "frame_acc", "a__", "7", '"é"', "time_s"])
def test_what_a_map_names_is_read_again(tmp_path, name):
    (tmp_path / "t.csv").write_text(TABLE)
    mapped(tmp_path, section=f"[sensors.{name}]")
    found = understand(tmp_path / "t.csv", map_path=tmp_path / "m.toml").recording
    assert list(found.sensors) == [name.strip('"')]
    (tmp_path / "o.csv").write_bytes(csv_bytes(found.to_frame(), tmp_path / "o.csv"))
    assert list(read_recording(tmp_path / "o.csv").sensors) == list(found.sensors)


WRONG = [
    *('["s"]', "[]", "{}", "{a = 1}", "[{a = 1}]", "true", "1.5", "nan", "-inf", "2020-01-01"),
    *("12:00:00", '""', '"\\n"', '"-"', "0", "-3", "1" + 5000 * "0", "0x" + 5000 * "f"),
    *('["ax", "ay"]', '["ax", "ay", 3]', '[["ax"], "ay", "az"]', '["ax", "ay", ""]'),
]


@pytest.mark.parametrize(
    ("key", "value"),
    [
        *itertools.product(["column", "unit", "first_row"], WRONG),
        *itertools.product(["acc", "acc_unit", "gyr", "gyr_unit"], WRONG),
    ],
    ids=lambda text: text[:20],
)
def test_wrong_types_in_a_map(tmp_path, key, value):
    refused(tmp_path, **{key: f"{key} = {value}"})


@pytest.mark.parametrize("value", WRONG, ids=lambda text: text[:20])
def test_wrong_types_beside_the_clock(tmp_path, value):
    if value != "1.5":  # Hz that a sensor can have
        refused(tmp_path, column=f"rate_hz = {value}", unit="")
    if value not in ("[]", '["s"]', '["ax", "ay"]'):
        refused(tmp_path, names=f"names = {value}")
    for key in ("clock", "sensors"):
        with pytest.raises(InputError, match=r"m\.toml: "):
            (tmp_path / "m.toml").write_text(f"{key} = {value}\n")
            read_mapped(TABLE, "t.csv", tmp_path / "m.toml")
    refused(tmp_path, section=f"[sensors]\nbody = {value}\n[sensors.frame]")


def test_sections_of_a_map_in_two_brackets(tmp_path):
    assert refused(tmp_path, section="[[sensors.frame]]").endswith(
        "write [sensors.frame], not [[sensors.frame]]"
    )
    (tmp_path / "m.toml").write_text('[[clock]]\ncolumn = "t"\n[sensors.frame]\n')
    with pytest.raises(InputError, match=r"write \[clock\], not \[\[clock\]\]"):
        read_mapped(TABLE, "t.csv", tmp_path / "m.toml")


@pytest.mark.parametrize("last", ['"note"', '""', '"a,b"', '"say \\"no\\""', '" "'])
def test_columns_stay_in_place_whatever_an_unused_one_is_called(tmp_path, last):
    """A counter in front and a last column without a name are no index."""
    rows = "".join(f"{k + 1},{row},7\n" for k, row in enumerate(ROWS))
    names = f'names = ["n", "t", "ax", "ay", "az", "gx", "gy", "gz", {last}]'
    (stream,) = mapped(tmp_path, rows, names=names)
    assert np.allclose(stream.time_s, np.arange(20) / 100)
    assert np.allclose(stream.acc_mps2[:, 2], 9.8)
    swapped = names.replace('"n", ', "").replace(f", {last}", f', {last}, "n"')
    first = "".join(f"{row},7,{k + 1}\n" for k, row in enumerate(ROWS))
    assert np.allclose(mapped(tmp_path, first, names=swapped)[0].acc_mps2[:, 2], 9.8)


# Geometries and settings


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("[[walker]]\na = 1\n", "write [walker], not [[walker]]"),
        ("walker = 3\n", "write [walker], not walker = 3"),
        (
            "[walker]\na = 1\n[[walker.mount]]\nx = 1\n",
            "write [walker.mount], not [[walker.mount]]",
        ),
        ("[walker]\na = 1\nmount = 2\n", "write [walker.mount], not walker.mount = 2"),
    ],
)
def test_a_section_that_is_none_says_how_it_is_written(tmp_path, text, says):
    path = tmp_path / "g.toml"
    path.write_text(text)
    for read in (
        lambda: read_section(path, "walker", ["a"]),
        lambda: read_arrays(path, "walker.mount", {"x": ()}),
    ):
        with pytest.raises(InputError) as error:
            read()
        assert str(error.value) == f"{path}: {says}"


def test_settings_name_the_key_of_the_file(tmp_path):
    path = tmp_path / "s.json"
    for value in ("NaN", "1e400", "-Infinity"):
        path.write_text(f'{{"seuilVitLinAbs": {value}}}')
        with pytest.raises(InputError, match=r"s\.json: seuilVitLinAbs = -?(nan|inf), expected"):
            read_json_numbers(path)


# Velocities


def series(folder, *names, factors=(1.0, 1.0)):
    """Velocities of 200 samples at 100 Hz, with time columns in units of their own."""
    times = (np.arange(200) / 100 / factor for factor in factors)
    table = np.column_stack([*times, np.ones(200), np.zeros(200)])
    head = ",".join([*names, "linear_velocity_mps", "yaw_rate_degps"])
    path = folder / "v.csv"
    np.savetxt(path, table, delimiter=",", header=head, comments="", fmt="%.9g")
    return path


def test_time_columns_that_contradict_each_other(tmp_path):
    path = series(tmp_path, "time_s", "Time (ms)", factors=(1, 2e-3))
    with pytest.raises(InputError, match=r"time_s counts 1\.99 s .* Time \(ms\) counts 0\.995 s"):
        read_velocities(path)
    path = series(tmp_path, "time_s", "time_of_lap", factors=(1, 3))
    with pytest.warns(UserWarning, match="time_of_lap counts 0.66.* the first is taken"):
        assert read_velocities(path).sampling_rate_hz == 100


@pytest.mark.parametrize(
    ("second", "factor"),
    [("Time (ms)", 1e-3), ("timestamp", 1e-9), ("time_min", 60), ("time (%)", 0.0199)],
)
def test_time_columns_that_agree(tmp_path, second, factor):
    path = series(tmp_path, "time_s", second, factors=(1, factor))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert read_velocities(path).sampling_rate_hz == 100


@pytest.mark.parametrize("name", ["time_tick_10ms", "Time ticks", "time_tick_10_ms"])
def test_a_column_of_ticks_is_no_clock(tmp_path, name):
    path = series(tmp_path, name, factors=(0.01,))
    with pytest.raises(InputError, match=rf"no time column \({name} is taken as a count\)"):
        read_velocities(path)
    with pytest.warns(UserWarning, match="counted at 50 Hz"):
        assert read_velocities(path, sampling_rate_hz=50).sampling_rate_hz == 50
    beside = series(tmp_path, "time_s", name, factors=(1, 0.01))
    assert read_velocities(beside).sampling_rate_hz == 100


def test_units_of_time_with_a_number(tmp_path):
    with pytest.raises(InputError, match="expected one unit of time"):
        read_velocities(series(tmp_path, "time_10ms", factors=(0.01,)))
    for name in ("time_ticks_ms", "time2_ms"):
        path = series(tmp_path, name, factors=(1e-3,))
        assert read_velocities(path).sampling_rate_hz == 100
