"""Columns of truth values and of words beside numbers, as pandas, R and spreadsheets write them."""

import numpy as np
import pandas as pd
import pytest

from mobility_imu.errors import InputError
from mobility_imu.readers.rests import read_rests
from mobility_imu.readers.velocities import read_velocities

TIME_S = np.arange(300) / 100
GOOD = TIME_S < 2
WORDS = [
    ("True", "False"), ("TRUE", "FALSE"), ("T", "F"), ("yes", "no"), ("1", "0"), ("1.0", "0.0"),
    ("VRAI", "FAUX"), ("oui", "non"), ("VERDADERO", "FALSO"), ("sí", "no"), ("TRUE", "NA"),
    ("yes", ""),
]  # fmt: skip
DRESSES = [{}, {"sep": ";", "decimal": ","}, {"quoting": 1}, {"sep": "\t"}]


def velocities(path, valid, dress=None, **more):
    table = {"time_s": TIME_S, "linear_velocity_mps": 1.25, "yaw_rate_degps": 30.5}
    pd.DataFrame(table | more | {"valid": valid}).to_csv(path, index=False, **dress or {})
    return path


@pytest.mark.parametrize("dress", DRESSES)
@pytest.mark.parametrize("words", WORDS)
def test_validity_is_read_in_words(tmp_path, words, dress):
    if words == ("TRUE", "NA"):  # as R writes what is missing
        dress = dress | {"quoting": 0}
    path = velocities(tmp_path / "v.csv", np.where(GOOD, *words), dress)
    assert np.array_equal(read_velocities(path).valid, GOOD)


@pytest.mark.parametrize("dress", DRESSES)
@pytest.mark.parametrize("words", WORDS[:10])
def test_rests_are_read_in_words(tmp_path, words, dress):
    table = pd.DataFrame({"time_s": TIME_S, "stationary": np.where(GOOD, *words)})
    table.to_csv(tmp_path / "r.csv", index=False, **dress)
    assert np.array_equal(read_rests(tmp_path / "r.csv", TIME_S), GOOD)


@pytest.mark.parametrize("dress", DRESSES)
def test_numbers_are_not_read_cell_by_cell(tmp_path, monkeypatch, dress):
    """That takes seven times as long: half a second for an hour at 100 Hz."""
    monkeypatch.setattr("mobility_imu.readers.flags.cells_of", None)
    path = velocities(tmp_path / "v.csv", GOOD.astype(int), dress)
    assert np.array_equal(read_velocities(path).valid, GOOD)
    table = pd.DataFrame({"time_s": TIME_S, "stationary": GOOD.astype(float)})
    table.to_csv(tmp_path / "r.csv", index=False, **dress)
    assert np.array_equal(read_rests(tmp_path / "r.csv", TIME_S), GOOD)


@pytest.mark.parametrize("word", ["WAHR", "maybe", "ok"])
def test_a_word_that_says_neither_is_named_with_its_line(tmp_path, word):
    path = velocities(tmp_path / "v.csv", np.where(GOOD, "yes", word))
    says = rf"v\.csv: line 202, column valid: got '{word}', expected 1 or 0, TRUE or FALSE"
    with pytest.raises(InputError, match=says):
        read_velocities(path)
    table = pd.DataFrame({"time_s": TIME_S, "stationary": np.where(GOOD, "yes", word)})
    table.to_csv(tmp_path / "r.csv", index=False)
    with pytest.raises(InputError, match=r"r\.csv: line 202, column stationary: got"):
        read_rests(tmp_path / "r.csv", TIME_S)


@pytest.mark.parametrize("words", [False, True], ids=["numbers", "words"])
@pytest.mark.parametrize(
    "number", ["0.5", "2", "-1", "inf", "-inf", "1e-9", "0.9999999", "1_0", "\u0661"]
)
def test_a_number_that_says_neither_is_named_with_its_line(tmp_path, number, words):
    flags = np.where(GOOD, "yes" if words else "1", number)
    path = velocities(tmp_path / "v.csv", flags)
    says = rf"line 202, column {{}}: got '{number}', expected 1 or 0, TRUE or FALSE"
    with pytest.raises(InputError, match=says.format("valid")):
        read_velocities(path)
    pd.DataFrame({"time_s": TIME_S, "stationary": flags}).to_csv(tmp_path / "r.csv", index=False)
    with pytest.raises(InputError, match=says.format("stationary")):
        read_rests(tmp_path / "r.csv", TIME_S)


def test_where_a_rest_is_not_told(tmp_path):
    flags = np.where(GOOD, 1.0, np.nan)
    pd.DataFrame({"time_s": TIME_S, "stationary": flags}).to_csv(tmp_path / "r.csv", index=False)
    with pytest.raises(InputError, match="line 202, column stationary: is empty, expected 1 or 0"):
        read_rests(tmp_path / "r.csv", TIME_S)


@pytest.mark.parametrize(
    ("time", "says"),
    [
        ("", "line 12, column time_s: expected a number, got nothing, NaN or infinity"),
        ("-inf", "line 12, column time_s: expected a number, got nothing, NaN or infinity"),
        ("0.05", "line 12: time_s does not increase from the row before"),
        ("0.09", "line 12: time_s does not increase from the row before"),
    ],
)
def test_times_of_rests_are_named_with_their_line(tmp_path, time, says):
    times = [str(t) for t in TIME_S]
    times[10] = time
    pd.DataFrame({"time_s": times, "stationary": 1}).to_csv(tmp_path / "r.csv", index=False)
    with pytest.raises(InputError, match=rf"r\.csv: {says}"):
        read_rests(tmp_path / "r.csv", TIME_S)


@pytest.mark.parametrize("word", ["1", "TRUE"])
@pytest.mark.parametrize(
    "name", ["time_s", "Time_S", "linear_velocity_mps", "yaw_rate_degps", "linear_sd", "valid"]
)
def test_a_column_of_velocities_that_stands_twice(tmp_path, name, word):
    velocities(tmp_path / "v.csv", word, linear_sd=0.1)
    head, *rows = (tmp_path / "v.csv").read_text().splitlines()
    place = head.split(",").index(name.lower())
    rows = [f"{row},{row.split(',')[place]}" for row in rows]
    (tmp_path / "v.csv").write_text("\n".join([f"{head},{name}", *rows]))
    with pytest.raises(InputError, match=f"column {name.lower()} appears twice"):
        read_velocities(tmp_path / "v.csv")


def test_rests_without_their_column_or_with_two(tmp_path):
    table = pd.DataFrame({"time_s": TIME_S, "note": "by eye"})
    table.to_csv(tmp_path / "r.csv", index=False)
    with pytest.raises(InputError, match=r"no column stationary \(it has: time_s, note\)"):
        read_rests(tmp_path / "r.csv", TIME_S)
    table.assign(stationary=1, Stationary=0).to_csv(tmp_path / "r.csv", index=False)
    with pytest.raises(InputError, match="column stationary appears twice"):
        read_rests(tmp_path / "r.csv", TIME_S)


@pytest.mark.parametrize("dress", DRESSES)
def test_columns_of_words_beside_velocities_are_passed_over(tmp_path, dress):
    """As the table of tasks has them."""
    words = {"task_code": 3, "task": "tight rotation", "note": "a, b; c"}
    path = velocities(tmp_path / "v.csv", 1, dress, **words)
    found = read_velocities(path)
    assert found.valid.all() and np.allclose(found.linear_velocity_mps, 1.25)


def test_columns_that_are_missing_are_told_with_those_of_the_file(tmp_path):
    (tmp_path / "v.csv").write_text("task,what\nstatic,1\n")
    with pytest.raises(InputError, match=r"no column for the linear .*\(columns: task, what\)"):
        read_velocities(tmp_path / "v.csv")
