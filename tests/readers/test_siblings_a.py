"""Tables of numbers whose rows lost a cell, or go on behind a quotation mark; ends of lines."""

import numpy as np
import pytest

from mobility_imu.errors import InputError
from mobility_imu.readers.recordings import understand
from mobility_imu.readers.rests import read_rests
from mobility_imu.readers.table import decoded, parse_numbers

NAMES = [
    "time_s",
    *(f"frame_acc_{a}_mps2" for a in "xyz"),
    *(f"frame_gyr_{a}_radps" for a in "xyz"),
]


def cells(count=40):
    return [[f"{k / 100:.2f}", "0.1", "0.2", "9.8", "0.01", "0.02", "0.03"] for k in range(count)]


def written(path, rows, names=NAMES, mark=",", end=""):
    path.write_text("\n".join(mark.join(row) + end for row in [names, *rows]) + "\n")
    return path


def parsed(rows, text=("note",)):
    return parse_numbers(
        "\n".join([",".join(rows[0]), *rows[1:]]), source="f.csv", wanted=lambda n: n not in text
    )


@pytest.mark.parametrize("flag", ["0", ""])
@pytest.mark.parametrize("lost", range(8))
@pytest.mark.parametrize("mark", [",", ";", "\t"])
def test_a_row_that_lost_a_cell_before_a_column_that_is_not_read(tmp_path, flag, lost, mark):
    rows = [[*row, flag] for row in cells()]
    del rows[20][lost]
    path = written(tmp_path / "lost.csv", rows, [*NAMES, "flag"], mark)
    with pytest.raises(InputError, match=r"lost\.csv: line 22 has 7 of 8 cells"):
        understand(path)


@pytest.mark.parametrize("further", [(), ("0",), ("",)])
@pytest.mark.parametrize("row", [0, 20, 39])
def test_a_row_that_lost_a_cell_where_rows_end_with_a_separator(tmp_path, further, row):
    rows = [[*cells, *further] for cells in cells()]
    names = [*NAMES, "flag"][: 7 + len(further)]
    assert len(understand(written(tmp_path / "all.csv", rows, names, end=",")).recording) == 40
    del rows[row][3]
    path = written(tmp_path / "lost.csv", rows, names, end=",")
    with pytest.raises(InputError, match=f"line {row + 2} has {len(names) - 1} of {len(names)} "):
        understand(path)


def test_a_row_with_a_cell_too_many_before_an_empty_one():
    rows = [["a", "b", "note"], *["1,2,"] * 5, "1,1,2,", *["1,2,"] * 5]
    with pytest.raises(InputError, match="line 7 has 4 of 3 cells"):
        parsed(rows)


def test_cells_of_text_that_are_empty_or_say_nothing():
    rows = [["a", "b", "note"], "1,2,x", "3,4,", '5,6,"p, q"', "7,8,NA", '9,10,""', "11,12,"]
    assert np.array_equal(parsed(rows).numbers, np.arange(1, 13).reshape(6, 2))


def test_rests_that_lost_a_cell(tmp_path):
    lines = ["time_s,stationary,note", *(f"{k / 100},1,5" for k in range(100))]
    lines[50] = "1,5"
    path = tmp_path / "rests.csv"
    path.write_text("\n".join(lines))
    with pytest.raises(InputError, match="line 51 has 2 of 3 cells"):
        read_rests(path, np.arange(100) / 100)


@pytest.mark.parametrize("marks", [(50,), (50, 70), (50, 60, 70), (50, 98)])
@pytest.mark.parametrize("where", ['"lap', '"', ' "lap', '"a""b', '"a" b,"c', '5" x,"c'])
def test_a_quotation_mark_that_is_not_closed_on_its_line(marks, where):
    head = ["a", "note", "more"]
    rows = [f"{k},x,y" for k in range(100)]
    for k in marks:
        rows[k] = f"{k},{where}" if "," in where else f"{k},x,{where}"
    with pytest.raises(InputError, match=r"f\.csv: line 52: a quotation mark is not closed"):
        parsed([head, *rows], ("note", "more"))


def test_rests_beside_an_open_quotation_mark(tmp_path):
    lines = ["time_s,note,stationary", *(f"{k / 100},,1" for k in range(100))]
    lines[50], lines[70] = '0.49,"ramp 1,1', '0.69,",1'
    path = tmp_path / "rests.csv"
    path.write_text("\n".join(lines))
    with pytest.raises(InputError, match=r"rests\.csv: line 51: a quotation mark"):
        read_rests(path, np.arange(100) / 100)


def test_quotation_marks_that_are_closed_or_part_of_a_cell():
    rows = ['1,"x, y"', '2,5" wheel', "", '3,"a ""b"""', '4, "c" ', " ", '5,""', '"6",x"y"']
    table = parsed([["a", "note"], *rows])
    assert np.array_equal(table.numbers[:, 0], range(1, 7))


@pytest.mark.parametrize("last", ["\n", "\r\n", "\r", "", "\r\n\n"])
@pytest.mark.parametrize("count", [2, 40])
def test_carriage_returns_with_another_end_of_the_file(last, count):
    lines = ["a,b", *["1,2"] * count]
    text = decoded(("\r".join(lines) + last).encode(), "f.csv")
    assert len(parse_numbers(text, source="f.csv")) == count


def test_carriage_returns_behind_lines_of_a_head():
    lines = "# one\n# two\n" + "\r".join(["a,b", *["1,2"] * 40]) + "\n"
    assert "\r" not in decoded(lines.encode(), "f.csv")


@pytest.mark.parametrize("end", ["\r\n", "\r\r\n", "\n"])
def test_ends_of_lines_that_are_left_as_they_are(end):
    text = end.join(["a,b", *["1,2"] * 40]) + end
    assert decoded(text.encode(), "f.csv") == text
