"""Tables that went through a spreadsheet, and what messages advise where one cannot be read."""

import json
import re

import dialects
import numpy as np
import pytest
from test_dialects import COUNT, assert_same, made, quietly

from mobility_imu.errors import InputError
from mobility_imu.readers.layout import comma_separated
from mobility_imu.readers.recordings import understand

NUMBER = re.compile(r"[-+]?\d+\.\d+(e[-+]?\d+)?")
MAP = """
[clock]
column = "t"
unit = "s"
[sensors.frame]
acc = ["ax", "ay", "az"]
acc_unit = "m/s2"
gyr = ["gx", "gy", "gz"]
gyr_unit = "rad/s"
"""
NAMES = ["t", "ax", "ay", "az", "gx", "gy", "gz"]


def in_german(path):
    """The file as a spreadsheet with decimal commas saves it: rows are filled up."""
    lines = path.read_text().removeprefix("sep=,\n").splitlines()
    rows = [line.split(",") for line in lines]
    width = max(map(len, rows), default=0)
    text = ""
    for row in rows:
        cells = [c.replace(".", ",") if NUMBER.fullmatch(c.strip()) else c for c in row]
        text += ";".join(cells + [""] * (width - len(row))) + "\r\n"
    path.write_bytes(text.encode("cp1252"))


def xsens_mt(recording, folder):
    return dialects.xsens_mt(recording, folder, separator=",")


@pytest.mark.parametrize(
    "write",
    [
        dialects.canonical, xsens_mt, dialects.xsens_dot, dialects.lpms, dialects.ngimu,
        dialects.ximu3, dialects.apdm, dialects.apdm_format_7, dialects.actigraph,
        dialects.sensor_logger, dialects.phyphox, dialects.androsensor, dialects.physics_toolbox,
    ],
    ids=lambda w: w.__name__,
)  # fmt: skip
def test_every_format_that_was_saved_with_semicolons(tmp_path, write):
    recording = made()
    name = write(recording, tmp_path)
    for path in [*tmp_path.rglob("*.csv"), *tmp_path.rglob("*.txt")]:
        in_german(path)
    found = quietly(name, expected=("frame",))
    assert len(found) == COUNT
    assert_same(found, recording)


def test_only_tables_with_semicolons_are_changed():
    for text in ("a,b\n1.5,2\n", "Test Name:, a;b\n", "names\n1;2\n"):
        assert comma_separated(text) == text
    assert comma_separated("a;b\n1,5;2\n") == "a,b\n1.5,2\n"


def rows(separator, decimal=".", end="\n", tail="", names=True):
    frame = made().to_frame()
    lines = [separator.join(NAMES)] if names else []
    for row in frame.to_numpy():
        lines.append(separator.join(f"{v:.7f}".replace(".", decimal) for v in row))
    return end.join(line + tail for line in lines) + end


@pytest.fixture
def mapped(tmp_path):
    """What a map reads of a text."""

    def read(text, names=False):
        (tmp_path / "a.txt").write_bytes(text.encode())
        (tmp_path / "map.toml").write_text((f"names = {NAMES}\n" if names else "") + MAP)
        return understand(tmp_path / "a.txt", map_path=tmp_path / "map.toml").recording

    return read


@pytest.mark.parametrize(
    ("separator", "decimal"),
    [(";", ","), (";", "."), ("\t", ","), (",", "."), (" ", "."), ("  ", ",")],
)
@pytest.mark.parametrize("names", [True, False])
def test_a_map_finds_the_separator(mapped, separator, decimal, names):
    found = mapped(rows(separator, decimal, names=names), names=not names)
    assert len(found) == COUNT
    assert_same(found, made())


def test_a_map_finds_the_separator_before_empty_cells(mapped):
    assert_same(mapped(rows(";", ",", tail=";;;", names=False), names=True), made())


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r", "\r\r\n"])
@pytest.mark.parametrize("tail", ["", ",", ",,", ",,,"])
def test_line_ends_and_empty_columns(tmp_path, end, tail):
    path = dialects.canonical(made(), tmp_path)
    lines = path.read_text().splitlines()
    path.write_bytes("".join(line + tail + end for line in lines).encode())
    assert_same(quietly(path), made())
    # Without empty names above them, too.
    path.write_bytes((lines[0] + end + "".join(row + tail + end for row in lines[1:])).encode())
    assert_same(quietly(path), made())


def test_an_empty_last_cell_is_not_taken_for_an_empty_column(tmp_path):
    path = dialects.canonical(made(), tmp_path)
    lines = [line + ",," for line in path.read_text().splitlines()]
    lines[50] = ",".join(lines[50].split(",")[:-3]) + ",,,"
    path.write_text("\n".join(lines))
    with pytest.raises(InputError, match=r"line 51, column frame_gyr_z_radps: expected a number"):
        quietly(path)
    lines[50] = ",".join(lines[50].split(",")[:-3]) + ",,"
    path.write_text("\n".join(lines))
    with pytest.raises(InputError, match=r"line 51 has 6 of 7 cells; was the file cut short"):
        quietly(path)


def test_the_columns_of_the_file_are_listed(mapped):
    with pytest.raises(InputError, match=r"no column az \(it has: t, ax, ay, a_z, gx, gy, gz\)"):
        mapped(rows(",").replace("az", "a_z"))


def test_a_row_that_lacks_a_number_is_named_with_what_to_do(mapped):
    text = rows(",").split("\n")
    text[7] = re.sub(r",[^,]*$", ",NaN", text[7])
    with pytest.raises(
        InputError,
        match=r"line 8, column gz: .* remove the row; --fill-gaps-s .* bridges gaps of up to 60 s",
    ):
        mapped("\n".join(text))
    with pytest.raises(InputError, match="line 7, column gz"):
        mapped("\n".join(text[1:]), names=True)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda t: np.delete(t, slice(50, 90), axis=0), "gap of 0.41 s .* give --fill-gaps-s"),
        (lambda t: np.insert(t, 50, t[50], axis=0), "appears twice .* remove one of the two rows"),
        (lambda t: np.roll(t, 50, axis=0), "runs backwards .* sort the rows, or cut the recording"),
    ],
)
def test_a_clock_that_is_refused_comes_with_what_to_do(tmp_path, change, says):
    frame = made().to_frame()
    table = type(frame)(change(frame.to_numpy()), columns=frame.columns)
    table.to_csv(tmp_path / "a.csv", index=False)
    with pytest.raises(InputError, match=says):
        quietly(tmp_path / "a.csv")


def test_decimal_commas_between_commas_come_with_what_to_do(mapped):
    with pytest.raises(InputError, match=r"decimal commas\? Then separate the cells by semicolons"):
        mapped(rows(",", ","))


def test_a_map_that_contradicts_a_name_is_told(tmp_path):
    """The map counts, for names of some loggers are wrong; but the difference is said."""
    text = rows(",").replace("t,ax,ay,az,gx", "t (ms),ax (m/s^2),ay,az,gx [°/s]")
    (tmp_path / "a.txt").write_text(text)
    plan = MAP.replace('"t"', '"t (ms)"').replace('"ax"', '"ax (m/s^2)"')
    (tmp_path / "map.toml").write_text(plan.replace('"gx"', '"gx [°/s]"'))
    clock, gyr = sorted(understand(tmp_path / "a.txt", map_path=tmp_path / "map.toml").warnings)[
        ::-1
    ]
    assert "column t (ms) states ms, but map.toml says s, which is taken" in clock
    assert "column gx [°/s] states deg/s, but map.toml says rad/s, which is taken" in gyr


@pytest.mark.parametrize(
    "write",
    [
        dialects.canonical, dialects.lpms, dialects.ximu3, dialects.apdm, dialects.shimmer,
        dialects.actigraph, dialects.physics_toolbox,
        dialects.sensor_logger, dialects.phyphox, dialects.apdm_format_7,
    ],
    ids=lambda w: w.__name__,
)  # fmt: skip
@pytest.mark.parametrize("cell", ["", "NaN", "inf"])
def test_a_cell_without_a_number_is_named_by_its_line(tmp_path, write, cell):
    given = write(made(), tmp_path)
    path = given / "Gyroscope.csv" if given.is_dir() else given
    lines = path.read_text().split("\n")
    mark = max(";,", key=lines[100].count)
    cells = lines[100].split(mark)
    cells[3] = cell
    lines[100] = mark.join(cells)
    path.write_text("\n".join(lines))
    says = rf"{path.name}: line 101, column .*\(1 such row.*--fill-gaps-s"
    with pytest.raises(InputError, match=says):
        quietly(given, expected=("frame",))


@pytest.mark.parametrize("write", [dialects.sensor_logger, dialects.phyphox])
def test_a_time_without_a_number_is_named_by_its_line(tmp_path, write):
    folder = write(made(), tmp_path)
    path = folder / "Gyroscope.csv"
    lines = path.read_text().split("\n")
    cells = lines[100].split(",")
    cells[1 if "seconds_elapsed" in lines[0] else 0] = ""
    lines[100] = ",".join(cells)
    path.write_text("\n".join(lines))
    with pytest.raises(InputError, match=r"Gyroscope\.csv: line 101, column .*\(1 such row"):
        quietly(folder)


@pytest.mark.parametrize("key", ["ax", "t"])
def test_a_sample_of_json_without_a_number_is_named(tmp_path, key):
    keys = ["t", "ax", "ay", "az"]
    rows = [dict(zip(keys, (k / 100, 0.1, 0.2, 9.8), strict=True)) for k in range(300)]
    rows[99][key] = float("nan")
    (tmp_path / "a.json").write_text(json.dumps(rows))
    (tmp_path / "map.toml").write_text(
        '[clock]\ncolumn = "t"\nunit = "s"\n[sensors.frame]\nacc = ["ax", "ay", "az"]\n'
        'acc_unit = "m/s2"\n'
    )
    with pytest.raises(InputError, match=rf"a\.json: sample 99, column {key}: .*--fill-gaps-s"):
        understand(tmp_path / "a.json", map_path=tmp_path / "map.toml")


@pytest.mark.parametrize("cell", ["", "nan"])
def test_a_row_without_the_number_of_its_sensor_is_named(tmp_path, cell):
    path = dialects.lpms(made(), tmp_path)
    lines = path.read_text().split("\n")
    lines[100] = cell + lines[100][lines[100].index(",") :]
    path.write_text("\n".join(lines))
    with pytest.raises(InputError, match=r"line 101, column SensorId: .*\(1 such row"):
        quietly(path)


@pytest.mark.parametrize("note", ["a; b, c", "slowly, then fast", "1, 2 and 3"])
def test_a_comma_in_a_note_is_no_decimal_comma(tmp_path, note):
    """What is wrong is named where it is, not the first number with a point."""
    table = made().to_frame().assign(note=note)
    table.to_csv(tmp_path / "a.csv", index=False, quoting=2)
    lines = (tmp_path / "a.csv").read_text().splitlines()
    lines[100] = lines[100].replace(",", ",x", 1)
    (tmp_path / "a.csv").write_text("\n".join(lines))
    with pytest.raises(InputError, match=r"line 101, column frame_acc_x_mps2: 'x[-0-9.]*' is not"):
        understand(tmp_path / "a.csv")


@pytest.mark.parametrize("end", [";", ";;;;;;", " ", "; ; ;"])
@pytest.mark.parametrize("write", [dialects.excel_sep_line, dialects.shimmer])
def test_a_line_that_names_the_separator_may_be_filled_up(tmp_path, write, end):
    path = write(made(), tmp_path)
    head, rest = path.read_text().split("\n", 1)
    path.write_text(head + end + "\n" + rest)
    assert_same(quietly(path, expected=("frame",)), made(), tolerance=1e-4)


def test_blanks_behind_quoted_cells_belong_to_no_cell(tmp_path):
    path = dialects.quoted_with_extras(made(), tmp_path)
    path.write_text("".join(f"{line}  \n" for line in path.read_text().splitlines()))
    assert_same(quietly(path), made())


@pytest.mark.parametrize("blank", ["\n", "\r\n \r\n"])
def test_blank_lines_among_the_comments_of_an_export(tmp_path, blank):
    name = dialects.xsens_mt(made(), tmp_path)
    (path,) = tmp_path.glob("*.txt")
    text = path.read_text()
    path.write_text(blank + text.replace("\n", "\n" + blank, 1), newline="")
    assert_same(quietly(name, expected=("frame",)), made(), tolerance=1e-4)


@pytest.mark.parametrize(
    ("column", "says"),
    [(-1, "'{}' is no date"), (0, "{}' is not a finite number")],
)
def test_lines_of_androsensor_are_counted_as_an_editor_does(tmp_path, column, says):
    path = dialects.androsensor(made(), tmp_path)
    lines = path.read_text().splitlines()
    for cell in ("x", ""):
        cells = lines[100].split(",")
        cells[column] = cell
        changed = [*lines[:50], "", "", *lines[50:100], ",".join(cells), *lines[101:]]
        path.write_text("\n".join(changed))
        with pytest.raises(InputError) as error:
            understand(path)
        assert "line 103" in str(error.value)
        assert says.format(cell) in str(error.value)
