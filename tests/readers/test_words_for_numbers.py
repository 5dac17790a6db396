"""A column of words that some library takes for numbers is refused as any other word."""

import numpy as np
import pandas as pd
import pytest
from test_dialects import OF_ONE, made, quietly

from mobility_imu.errors import InputError
from mobility_imu.readers.rests import read_rests
from mobility_imu.readers.table import parse_numbers
from mobility_imu.readers.velocities import read_velocities

COUNT = 60
NO_NUMBERS = ["TRUE", "true", "False", "1_0", "\u0661\u0662"]
"""pandas takes the first three for 1 and 0; Python takes the others for 10 and 12."""


def with_column(text, mark, place, word):
    """Table in whose rows one column holds nothing but a word, under the same names."""
    rows = text.rstrip().split("\n")
    for k in range(len(rows) - COUNT, len(rows)):
        cells = rows[k].split(mark)
        rows[k] = mark.join([*cells[:place], word, *cells[place + 1 :]])
    return "\n".join(rows)


def largest_file(path):
    if path.is_dir():
        return max((f for f in path.rglob("*.csv") if "ccel" in f.name or "sens" in f.name.lower()),
                   key=lambda f: f.stat().st_size)  # fmt: skip
    return path if path.exists() else path.with_name(f"{path.name}-Frame.txt")


WRITERS = [w for w in OF_ONE if w.__name__ not in ("movesense", "quoted_with_extras")]
"""Those whose rows can be taken apart at a mark."""


@pytest.mark.parametrize("write", WRITERS, ids=lambda w: w.__name__)
def test_what_is_said_of_a_word_is_said_of_every_word(tmp_path, write):
    path = write(made(count=COUNT), tmp_path)
    file = largest_file(path)
    coded = "utf-16" if write.__name__ == "utf16" else "utf-8"
    text = file.read_bytes().decode(coded)
    last = text.rstrip().rpartition("\n")[2]
    mark = next(mark for mark in "\t;," if mark in last)
    refused = 0
    for place in range(last.count(mark) + 1):
        said = {}
        for word in ("abc", *NO_NUMBERS):
            file.write_bytes(with_column(text, mark, place, word).encode(coded))
            try:
                quietly(path, expected=("frame",))
                said[word] = ""
            except InputError as error:
                said[word] = str(error).replace(f"'{word}'", "'abc'")
        if "number" in said["abc"] or not said["abc"]:
            assert set(said.values()) == {said["abc"]}, said
        assert all(said.values()) == bool(said["abc"]), said
        refused += "number" in said["abc"]
    assert refused >= 3, said


@pytest.mark.parametrize("rows", [3, 263_000])
@pytest.mark.parametrize("beside", ["2", "x"], ids=["numbers", "words"])
@pytest.mark.parametrize("word", NO_NUMBERS)
def test_a_column_with_words_in_some_rows(word, beside, rows):
    """The parser reads a long table in parts of 262,144 rows, each with a type of its own."""
    says = f"f: line {rows + 2}, column a: '{word}' is not a number"
    text = "a,b\n" + f"1,{beside}\n" * rows + f"{word},{beside}\n" * min(rows, 1000)
    with pytest.raises(InputError, match=says):
        parse_numbers(text, source="f", wanted=lambda name: name == "a" or beside == "2")


@pytest.mark.filterwarnings("error")
def test_a_part_of_a_table_that_holds_nothing_but_words():
    half = 262_144
    text = "a,b\n" + "1,2\n" * half + "TRUE,2\n" * 1000
    with pytest.raises(InputError, match=f"line {half + 2}, column a: 'TRUE' is not a number"):
        parse_numbers(text, source="f")


@pytest.mark.parametrize("place", range(3))
@pytest.mark.parametrize("word", NO_NUMBERS)
def test_velocities_and_rests_of_words(tmp_path, word, place):
    names = ["time_s", "linear_velocity_mps", "yaw_rate_degps"]
    table = pd.DataFrame({name: np.arange(50) / 100 for name in names}).astype(object)
    table[names[place]] = word
    table.assign(valid="TRUE").to_csv(tmp_path / "v.csv", index=False)
    with pytest.raises(InputError, match=f"line 2, column {names[place]}: '{word}' is not a num"):
        read_velocities(tmp_path / "v.csv")
    table = pd.DataFrame({"time_s": word, "stationary": [1] * 50})
    table.to_csv(tmp_path / "r.csv", index=False)
    with pytest.raises(InputError, match=f"line 2, column time_s: '{word}' is not a number"):
        read_rests(tmp_path / "r.csv", np.arange(50) / 100)
