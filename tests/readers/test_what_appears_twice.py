"""Columns and keys that appear twice, and keys of blanks: refused by their names."""

import json
import time

import dialects
import pytest
from test_dialects import made, quietly

from mobility_imu.errors import InputError
from mobility_imu.readers.geometry import read_arrays, read_section
from mobility_imu.readers.recordings import understand
from mobility_imu.readers.sensor_logger import read_sensor_logger_file
from mobility_imu.readers.settings import read_json_numbers
from mobility_imu.readers.streams import Asked
from mobility_imu.readers.wording import listed
from mobility_imu.wheelchair import read_settings


def refused(reader, *arguments, **options):
    with pytest.raises(InputError) as told:
        reader(*arguments, **options)
    return str(told.value)


def again(text, key):
    """JSON in which the first object with a key has it once more."""
    begin = text.index(f'"{key}":')
    return f'{text[:begin]}"{key}": 5, {text[begin:]}'


@pytest.mark.parametrize("key", ["x", "Timestamp", "ArrayAcc"])
def test_a_key_of_movesense(tmp_path, key):
    path = dialects.movesense(made(), tmp_path)
    text = path.read_text()
    key = key if f'"{key}":' in text else "Acc"
    path.write_text(again(text, key))
    assert refused(quietly, path) == f"{path}: {key} appears twice in one object"


@pytest.mark.parametrize("key", ["acc_x", "timestamp"])
def test_a_key_of_json_samples(tmp_path, key):
    path = dialects.json_samples(made(), tmp_path)
    path.write_text(again(path.read_text(), key))
    assert refused(quietly, path) == f"{path}: {key} appears twice in one object"


def test_a_key_of_sensor_logger(tmp_path):
    text = again('[{"sensor":"Accelerometer", "x": 1}]', "x")
    says = "log.json: x appears twice in one object"
    assert refused(read_sensor_logger_file, text, "log.json", Asked()) == says


def test_a_late_key_among_many_is_found_at_once():
    """Each key was compared with all before it: minutes for an object of 100,000."""
    text = json.dumps({f"k{k}": k for k in range(100_000)})[:-1] + ', "k99999": 1}'
    begin = time.perf_counter()
    says = "log.json: k99999 appears twice in one object"
    assert refused(read_sensor_logger_file, f"[{text}]", "log.json", Asked()) == says
    assert time.perf_counter() - begin < 5


@pytest.mark.parametrize("digits", ["\u0661.\u0665", "1_0.5", True])
def test_numbers_of_json_that_are_texts(tmp_path, digits):
    path = dialects.json_samples(made(), tmp_path)
    samples = json.loads(path.read_text())
    path.write_text(json.dumps([sample | {"acc_x": digits} for sample in samples]))
    assert "sample 0: acc_x is" in refused(quietly, path)


@pytest.mark.parametrize(
    ("row", "says"),
    [
        (("Accelerometer,,,Gyroscope", "Accelerometer,,,Accelerometer"), "Accelerometer/X appears"),
        (("X,Y,Z,X,Y,Z", "X,Y,Y,X,Y,Z"), "Accelerometer/Y appears"),
    ],
)
def test_a_column_of_apdm_format_7(tmp_path, row, says):
    path = dialects.apdm_format_7(made(), tmp_path)
    path.write_text(path.read_text().replace(*row, 1))
    assert f"Frame/{says} twice" in refused(quietly, path)


def test_names_of_blanks_are_in_quotation_marks(tmp_path):
    assert listed(["", "a", " ", "b "]) == "'', a, ' ', 'b '"
    path = tmp_path / "g.toml"
    path.write_text('"" = 1\n" " = 2\n[walker]\na = 1\n')
    assert f"{path}: '', ' ' is unknown" in refused(read_section, path, "walker", ["a"])
    path.write_text('[walker]\na = 1\n[walker.""]\n')
    assert "walker.'' is unknown" in refused(read_section, path, "walker", ["a"])
    path.write_text('[walker]\na = 1\n"" = 2\n')
    assert "[walker]: '' is unknown" in refused(read_section, path, "walker", ["a"])
    path.write_text('[walker.mount]\n"\\t" = 2\n')
    assert "'\\t' is unknown" in refused(read_arrays, path, "walker.mount", {"a": ()})
    path.write_text('{"": "x"}')
    assert refused(read_json_numbers, path) == f"{path}: '' = 'x', expected a number"
    path.write_text('{" ": 1}')
    assert "' ' is not a setting" in refused(read_settings, path)
    path.write_text('{"": 1, "": 2}')
    assert refused(read_settings, path) == f"{path}: '' appears twice in one object"


@pytest.mark.parametrize("name", ["", " "])
def test_sensors_and_keys_of_a_map_that_are_blank(tmp_path, name):
    path = dialects.canonical(made(), tmp_path)
    where = tmp_path / "map.toml"
    clock = "[clock]\nrate_hz = 100\n"
    sensor = 'acc = ["a", "b", "c"]\nacc_unit = "g"\n'
    where.write_text(f'{clock}[sensors."{name}"]\n{sensor}')
    assert f"[sensors.'{name}']: a sensor's name is" in refused(understand, path, map_path=where)
    where.write_text(
        f'{clock}"{name}" = 1\n[sensors.frame]\nacc = ["a", "b", "c"]\nacc_unit = "g"\n'
    )
    assert f"[clock]: '{name}' is unknown" in refused(understand, path, map_path=where)


def test_a_column_without_a_name(tmp_path):
    path = dialects.canonical(made(), tmp_path)
    head, rest = path.read_text().split("\n", 1)
    path.write_text(f"{head.replace('frame_acc_y_mps2', '')}\n{rest}")
    assert "column '' is not known" in refused(quietly, path)
