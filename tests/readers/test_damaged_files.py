"""Readers on damaged and hostile files: an InputError that names the file, or the right numbers."""

import gzip
import os
import threading
import warnings

import numpy as np
import pytest
from steps_taken import steps_of

from mobility_imu.errors import InputError
from mobility_imu.readers import read_recording, recording_files
from mobility_imu.readers.geometry import MOUNT_KEYS, SECTIONS, read_arrays, read_section
from mobility_imu.readers.settings import read_json_numbers
from mobility_imu.readers.streams import factor
from mobility_imu.readers.table import parse_numbers, read_text
from mobility_imu.readers.velocities import read_velocities
from mobility_imu.readers.wording import escaped, listed, quoted

HEADER = "time_s,frame_acc_x_mps2,frame_acc_y_mps2,frame_acc_z_mps2"
RECORDING = HEADER + "\n" + "".join(f"{k / 100},0.1,0.2,9.8\n" for k in range(20))


def write(path, text):
    path.write_text(text, encoding="utf-8", newline="")
    return path


def refused(reader, path, *arguments, **options):
    """Message of the error, which is in one line and names the file."""
    with pytest.raises(InputError) as error:
        reader(path, *arguments, **options)
    message = str(error.value)
    assert str(path) in message
    assert message.isprintable()
    return message


# Packed files


def test_every_byte_of_an_archive_may_be_damaged(tmp_path):
    """An archive with one bit changed is refused, or still holds the same text."""
    packed = gzip.compress(RECORDING.encode(), mtime=0)
    path = tmp_path / "r.csv.gz"
    same = 0
    for k in range(len(packed)):
        for bit in (0, 3, 7):
            broken = bytearray(packed)
            broken[k] ^= 1 << bit
            path.write_bytes(broken)
            try:
                same += read_text(path) == RECORDING
            except InputError as error:
                assert str(path) in str(error)
    assert same < 30  # bytes of the header that mean nothing


@pytest.mark.parametrize(
    "broken",
    [
        lambda z: z[:10] + b"\x07" + z[11:],
        lambda z: z[:-4],
        lambda z: z[: len(z) // 2],
        lambda z: z[:3],
        lambda z: z[:-8] + bytes(8),
        lambda z: z + b"\x1f\x8b more",
        lambda z: z + z[:15],
        lambda z: b"time_s," + z,
    ],
    ids=["block", "end", "half", "start", "checksum", "behind", "second", "before"],
)
def test_damaged_archives_are_named(tmp_path, broken):
    path = tmp_path / "r.csv.gz"
    path.write_bytes(broken(gzip.compress(RECORDING.encode())))
    assert "is it complete?" in refused(read_recording, path)


def test_archives_of_several_parts_are_read(tmp_path):
    path = tmp_path / "r.csv.gz"
    one, other = RECORDING[:100].encode(), RECORDING[100:].encode()
    path.write_bytes(gzip.compress(one) + gzip.compress(other))
    assert len(read_recording(path)) == 20


# What else a name can lead to


@pytest.mark.parametrize("name", ["n" * 300, "n" * 5000, "none/n", "nul\x00.csv", "ride.csv/below"])
def test_names_that_lead_nowhere(tmp_path, name):
    write(tmp_path / "ride.csv", RECORDING)
    for reader in (read_recording, read_text, read_velocities):
        with pytest.raises(InputError):
            reader(tmp_path / name)
    assert recording_files(tmp_path / name) == []


def test_devices_and_folders_are_refused(tmp_path):
    for reader in (read_text, read_velocities, read_json_numbers):
        assert "folder" in refused(reader, tmp_path)
        assert "device" in refused(reader, "/dev/zero")  # it never ends
    assert "device" in refused(read_recording, "/dev/zero")
    assert "is a folder" in refused(read_recording, tmp_path)


@pytest.mark.skipif(
    os.geteuid() == 0 and "RIGHTS_GIVEN_UP" not in os.environ,
    reason="a superuser may do everything; test_rights.py runs it without that",
)
def test_files_that_may_not_be_read(tmp_path):
    path = write(tmp_path / "r.csv", RECORDING)
    path.chmod(0)
    assert "Permission denied" in refused(read_recording, path)
    (tmp_path / "closed").mkdir(mode=0)
    assert "Permission denied" in refused(read_recording, tmp_path / "closed" / "r.csv")
    assert "no permission" in refused(read_recording, tmp_path / "closed")


def test_a_pipe_is_read(tmp_path):
    """As in ``mobility-imu wheelchair tasks <(command)``."""
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    writer = threading.Thread(target=pipe.write_text, args=(RECORDING,))
    writer.start()
    assert len(read_recording(pipe)) == 20
    writer.join()


def test_a_geometry_is_no_pipe(tmp_path):
    """Its sections are read one after the other: the second time, a pipe would never end."""
    os.mkfifo(tmp_path / "pipe")
    assert "is a pipe" in refused(read_section, tmp_path / "pipe", "walker", ["a"])
    assert "is a pipe" in refused(read_arrays, tmp_path / "pipe", "walker.mount", {"a": (3,)})


def test_files_of_a_recording(tmp_path):
    path = write(tmp_path / "r.csv", RECORDING)
    assert recording_files(path) == [path]
    parts = [write(tmp_path / f"Trial-{s}.txt", "") for s in ("Frame", "Left", "Right")]
    assert sorted(recording_files(tmp_path / "Trial")) == parts


@pytest.mark.parametrize(
    ("begin", "says"),
    [
        (b"\x89HDF\r\n\x1a\n\x00\x00\x00\x00", "is an HDF5 file, as APDM's programs write it"),
        (b"PK\x03\x04\x14\x00\x06\x00", "is an archive or a workbook"),
        (b"MATLAB 5.0 MAT-file, Platform: GLNXA64", "is a MATLAB file"),
        (b"MATLAB 7.3 MAT-file, Platform: GLNXA64", "is a MATLAB file"),
        (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", "is a workbook of an older Excel"),
    ],
)
def test_what_is_no_text_is_to_be_exported(tmp_path, begin, says):
    path = tmp_path / "20260101-walk.h5"
    path.write_bytes(begin + bytes(500))
    for reader in (read_recording, read_velocities, read_text):
        assert f"{says}; export it as CSV" in refused(reader, path)


# Tables


def test_reading_in_threads_leaves_the_processs_warnings_alone(tmp_path):
    path = write(tmp_path / "r.csv", RECORDING)
    before = list(warnings.filters)
    readers = [
        threading.Thread(target=lambda: [read_recording(path) for _ in range(15)]) for _ in range(8)
    ]
    for reader in readers:
        reader.start()
    for reader in readers:
        reader.join()
    assert warnings.filters == before


ROWS = ["1,2", "3,4", "5,6"]


@pytest.mark.parametrize("row", [0, 1, 2])
@pytest.mark.parametrize("extra", [",7", ",7,8", ",7,8,9,10", ",nan,8", ",,7"])
def test_no_cell_beyond_the_header_is_dropped(row, extra):
    rows = list(ROWS)
    rows[row] += extra
    with pytest.raises(InputError, match=rf"f\.csv: line {row + 2} has \d of 2 cells"):
        parse_numbers("a,b\n" + "\n".join(rows), separator=",", source="f.csv")


@pytest.mark.parametrize("row", [0, 1, 2])
def test_no_cell_is_taken_for_missing(row):
    rows = list(ROWS)
    rows[row] = rows[row][:1]
    with pytest.raises(InputError, match=rf"line {row + 2} has 1 of 2 cells; was the file cut"):
        parse_numbers("a,b\n" + "\n".join(rows), separator=",", source="f.csv")


@pytest.mark.parametrize(
    "text",
    [
        "a,b\n1,2\n3,4\n5,6",
        "a,b,\n1,2,\n3,4,\n5,6,\n",
        "a,b\n1,2\n\n3,4\n5,6\n",
        'a,b\n"1",2\n3,"4"\n5,6',
        "a,b\r\n1,2\r\n3,4\r\n5,6",
    ],
)
def test_tables_that_are_in_order(text):
    table = parse_numbers(text, separator=",", source="f.csv")
    assert table.numbers.tolist() == [[1, 2], [3, 4], [5, 6]]
    assert len(table) == 3
    assert table.columns(["B", "a"]).tolist() == [[2, 1], [4, 3], [6, 5]]


@pytest.mark.parametrize(
    "cell",
    ["1_000", "٣", "0x10", "1e", "--1", "NA", "null", '"1', "1\x00", "1d3", "1\u00a0", "\u20071"],
)
def test_text_that_is_no_number(cell):
    with pytest.raises(InputError, match=r"f\.csv: line 3, column b: '.*' is not a number"):
        parse_numbers(f"a,b\n1,2\n3,{cell}\n", separator=",", source="f.csv")


def test_a_point_among_decimal_commas():
    with pytest.raises(InputError, match=r"line 3, column b: '4\.5' is not a number with a dec"):
        parse_numbers("a;b\n1,5;2,5\n3,5;4.5\n", separator=";", source="f.csv")


def test_work_grows_with_the_number_of_columns(tmp_path):
    """Three times the columns, three times the steps; nine times if each looked at all others."""

    def steps(sensors):
        names = [f"s{k}_acc_{axis}_mps2" for k in range(sensors) for axis in "xyz"]
        rows = [",".join([f"{t}", *(["5.7"] * len(names))]) for t in (0, 0.01, 0.02)]
        path = write(tmp_path / "wide.csv", "\n".join([",".join(["time_s", *names]), *rows]))
        assert len(read_recording(path).sensors) == sensors
        return steps_of(read_recording, path)

    assert steps(300) < 3.1 * steps(100)


def test_long_cells_and_many_names_are_quoted_in_part(tmp_path):
    path = write(tmp_path / "r.csv", RECORDING.replace("0.05,", f"{'x' * 10**6},"))
    message = refused(read_recording, path)
    assert "line 7, column time_s: 'xxx" in message and len(message) < len(str(path)) + 150
    names = ",".join(f"c{k}" for k in range(1000))
    path = write(tmp_path / "v.csv", f"{names}\n{','.join(['1'] * 1000)}\n")
    message = refused(read_velocities, path)
    assert "c0, c1, c2, c3, c4, c5, c6, c7, c8, c9 and 990 more" in message


@pytest.mark.parametrize("char", "\x1b\x07\x7f\x9b\u202e\u2028\ufeff")
def test_characters_that_act_on_a_terminal_are_escaped(tmp_path, char):
    cell = write(tmp_path / "c.csv", RECORDING.replace("0.05,", f"0{char}[2J,"))
    head = write(tmp_path / "h.csv", RECORDING.replace("frame_acc_x", f"fr{char}ame_acc_x"))
    unknown = write(tmp_path / "u.csv", f"a{char}x,b\n1,2\n")
    for path in (cell, head, unknown):
        assert escaped(char) in refused(read_recording, path)
    assert escaped(char) in refused(read_velocities, unknown)


def test_wording():
    assert quoted("short") == "short"
    assert quoted("7" * 61) == "7" * 60 + "..."
    assert len(quoted("\x1b" * 60)) == 63
    assert listed([]) == ""
    assert listed(["a"] * 10) == ", ".join("a" * 10)
    assert listed(["a"] * 11).endswith("and 1 more")


def test_capital_letters_in_the_name_of_the_clock(tmp_path):
    path = write(tmp_path / "r.csv", RECORDING.replace("time_s", "Time_s"))
    assert len(read_recording(path)) == 20


# Clocks


@pytest.mark.parametrize("rate", [0, -100, np.nan, np.inf, 1e9, "100", True, [100], 10**400])
def test_sampling_rates_that_are_none(tmp_path, rate):
    path = write(tmp_path / "r.csv", RECORDING)
    assert "sampling rate" in refused(read_recording, path, sampling_rate_hz=rate)
    series = write(tmp_path / "v.csv", "linear,angular\n1,2\n1,2\n")
    assert "sampling rate" in refused(read_velocities, series, sampling_rate_hz=rate)


@pytest.mark.parametrize("length", [-1, np.nan, np.inf, 61, "1", None, True, [1]])
def test_gaps_that_cannot_be_filled(tmp_path, length):
    path = write(tmp_path / "r.csv", RECORDING)
    with pytest.raises(InputError, match="gaps to be filled up to"):
        read_recording(path, fill_gaps_s=length)


def test_no_more_samples_are_filled_in_than_there_are(tmp_path):
    """A clock of nanosecond steps with one gap of a minute: sixty thousand million samples."""
    rows = [f"{k * 1e-9 + 59 * (k > 9):.9f},0.1,0.2,9.8" for k in range(20)]
    path = write(tmp_path / "r.csv", "\n".join([HEADER, *rows]))
    assert "samples would be filled in" in refused(read_recording, path, fill_gaps_s=60)


@pytest.mark.parametrize("factor", [1e300, 1e307, 1e-310, 1e-12])
def test_clocks_of_velocities_that_are_none(tmp_path, factor):
    rows = [f"{k * factor},1,2" for k in range(-9, 9)]
    path = write(tmp_path / "v.csv", "\n".join(["time_s,linear (m/s),angular (deg/s)", *rows]))
    refused(read_velocities, path)


# Xsens


def export(folder, *, rate="// Update Rate: 100.0Hz\n", counter=None):
    """Three exports, of which the frame's has another rate or counter."""
    counts = [str(k) for k in range(20)]
    for word in ("Left", "Right", "Frame"):
        own = counts if counter is None or word != "Frame" else counter(list(counts))
        head = "PacketCounter\tAcc_X\tAcc_Y\tAcc_Z\tGyr_X\tGyr_Y\tGyr_Z\n"
        rows = "".join(f"{k}\t0.1\t0.2\t9.8\t0.1\t0.2\t0.3\n" for k in own)
        text = (rate if word == "Frame" else "// Update Rate: 100.0Hz\n") + head + rows
        write(folder / f"Trial-{word}.txt", text)
    return folder / "Trial"


@pytest.mark.parametrize(
    "rate",
    ["...", "0.0Hz", "0", "", "-60Hz", "nan", "60.0.0Hz", "1e9", "fast", "9" * 400, "60 kHz"],
)
def test_update_rates_that_are_none(tmp_path, rate):
    prefix = export(tmp_path, rate=f"// Update Rate: {rate}\n")
    assert "Update Rate:" in refused(read_recording, prefix)


@pytest.mark.parametrize("rate", ["60.0Hz", "60", "60,0 Hz", " 60Hz "])
def test_update_rates_as_they_are_written(tmp_path, rate):
    prefix = export(tmp_path, rate=f"// Update Rate: {rate}\n")
    with pytest.raises(InputError, match=r"different rates \(\[60.0, 100.0\] Hz\)"):
        read_recording(prefix)


def test_two_update_rates_in_one_file(tmp_path):
    twice = "// Update Rate: 100.0Hz\n// Update Rate: 60.0Hz\n"
    assert "appears twice" in refused(read_recording, export(tmp_path, rate=twice))
    assert len(read_recording(export(tmp_path, rate="// Update Rate: 100Hz\n" * 2))) == 20


@pytest.mark.parametrize("value", ["", "nan", "inf", "-1", "1.5", "1e300", "9" * 30])
@pytest.mark.parametrize("row", [0, 5, 19])
def test_packet_counters_that_are_none(tmp_path, value, row):
    prefix = export(tmp_path, counter=lambda c: [*c[:row], value, *c[row + 1 :]])
    with pytest.raises(
        InputError, match=rf"Trial-Frame\.txt: the packet counter is .* row {row + 1}"
    ):
        read_recording(prefix)


# Geometry and settings


def test_the_sections_are_those_that_the_devices_read(tmp_path):
    """Each device finds its section, and each mount its keys, in a file that has all of them."""
    from mobility_imu.scooter import ScooterGeometry
    from mobility_imu.scooter.mount import ScooterMount
    from mobility_imu.walker import WalkerGeometry, WalkerMount
    from mobility_imu.wheelchair import WheelchairGeometry

    eye = "[[1, 0, 0], [0, 1, 0], [0, 0, 1]]"
    values = {"translation_body_m": "[0.4, 0.0, 0.6]", "translation_sd_m": "[0.1, 0.1, 0.1]"}
    values["rotation_sd_rad"] = "[0.1, 0.1, 0.1]"
    values["sd_rad"] = "[0.1, 0.1, 0.1, 0.1, 0.1, 0.1]"
    mounts = [
        f"[{name}]\n" + "".join(f"{key} = {values.get(key, eye)}\n" for key in keys)
        for name, keys in MOUNT_KEYS.items()
    ]
    text = (
        "[scooter]\nsteering_inclination_deg = 20\nlever_inclination_deg = 9\n"
        "[wheelchair]\ncamber_deg = 19\nwheel_radius_left_m = 0.3\nwheel_radius_right_m = 0.3\n"
        "track_m = 0.8\n[walker]\nfootprint_width_m = 0.6\nfootprint_length_m = 0.5\n"
    )
    path = write(tmp_path / "all.toml", text + "".join(mounts))
    assert set(SECTIONS) == {line[1:-1] for line in path.read_text().split("\n") if "[" in line[:1]}
    for device in (ScooterGeometry, WheelchairGeometry, WalkerGeometry):
        device.from_toml(path)
    assert ScooterMount.from_toml(path).sd_rad.tolist() == 6 * [0.1]
    assert WalkerMount.from_toml(path).rotation_sd_rad.tolist() == [0.1, 0.1, 0.1]


@pytest.mark.parametrize(
    "text",
    [
        "x = " + 5000 * "[" + 5000 * "]",
        "[walker]\na = 1" + 5000 * "0",
        "[walker]\na = 0b" + 20000 * "1",
        "[walker]\na = [0x" + 5000 * "f" + "]",
        "[walker]\na = 1" + 310 * "0",
        "[walker]\na = true",
        "[walker]\na = '1'",
        "[walker]\na = 1e999x",
        "[walker]\na = 1\n[Walker]\nb = 1",
        "[walker]\na = 1\nb = 2",
        "[walker]\na = {b = 1, c = [1, 2]}",
    ],
    ids=lambda text: text[:30],
)
def test_geometry_that_is_none(tmp_path, text):
    path = write(tmp_path / "g.toml", text)
    assert len(refused(read_section, path, "walker", ["a"])) < len(str(path)) + 250


@pytest.mark.parametrize(
    "value",
    [
        *("[1, 2]", "[1, 2, 3, 4]", "1", "[[1, 2, 3]]", "[1, 2, true]", "[1, 2, '3']"),
        *("[1, 2, nan]", "[1, 2, 1" + 310 * "0" + "]", "[1, 2, [3]]", "{a = 1}", "[]"),
    ],
    ids=lambda value: value[:20],
)
def test_vectors_that_are_none(tmp_path, value):
    path = write(tmp_path / "g.toml", f"[walker.mount]\ntranslation_body_m = {value}\n")
    message = refused(read_arrays, path, "walker.mount", {"translation_body_m": (3,)})
    assert message.endswith("translation_body_m: expected 3 numbers")


def test_settings_are_numbers_or_null(tmp_path):
    path = write(tmp_path / "s.json", '{"a": 1, "b": 2.5, "c": null}')
    assert read_json_numbers(path) == {"a": 1.0, "b": 2.5, "c": None}


@pytest.mark.parametrize(
    "text",
    [
        *('{"a": "1"}', '{"a": true}', '{"a": [1]}', '{"a": 1, "a": 2}', "[1]", "1", "{"),
        *('{"a": NaN}', '{"a": -Infinity}', '{"a": 1e400}'),
        *('{"a": 1} x', 100_000 * "[", 100_000 * '{"a":'),
        *('{"a": 1' + 310 * "0" + "}", '{"a": 1' + 5000 * "0" + "}"),
    ],
    ids=lambda text: text[:20],
)
def test_settings_that_are_none(tmp_path, text):
    assert len(refused(read_json_numbers, write(tmp_path / "s.json", text))) < 400


def test_the_search_for_a_wrong_cell_grows_with_the_number_of_rows():
    """Slow and thorough only when something is wrong: the last of a thousand rows."""
    header = ",".join(f"c{k}" for k in range(10))

    def search(count, last="x"):
        rows = (count - 1) * [",".join(10 * ["1.5"])] + [",".join([*(9 * ["1.5"]), last])]
        parse_numbers("\n".join([header, *rows, ""]), separator=",", source="f.csv")

    def refused_search(count):
        with pytest.raises(InputError, match=f"line {count + 1}, column c9: 'x' is not a number"):
            search(count)

    sound = steps_of(search, 1000, "1.5")
    small, large = (steps_of(refused_search, count) for count in (333, 1000))
    assert large < 3.1 * small
    # 5 s for a million cells, at 20 million steps a second.
    assert sound < large / 5 and large < 100 * 10 * 1000


@pytest.mark.parametrize(("separator", "guess"), [(",", True), (";", False), ("\t", False)])
def test_decimal_commas_are_guessed_where_there_can_be_any(separator, guess):
    rows = [["a", "b"], ["1", "2"], ["3", "4", "5"]]
    text = "\n".join(separator.join(row) for row in rows)
    with pytest.raises(InputError, match="has 3 of 2 cells") as error:
        parse_numbers(text, separator=separator, source="f.csv")
    assert ("decimal commas" in str(error.value)) == guess


# Units of velocities


def velocities(folder, linear, angular, rows="0,1.5,-90\n0.01,1.5,-90\n"):
    return write(folder / "v.csv", f"time_s,{linear},{angular}\n{rows}")


@pytest.mark.parametrize(
    ("linear", "angular", "says"),
    [
        ("linear", "angular (deg/s)", "column linear states no unit that is known"),
        ("linear (m/s)", "angular", "column angular states no unit that is known"),
        (
            "linear velocity (-)",
            "yaw_rate left/right",
            r"column linear velocity \(-\) states no unit that is known",
        ),
    ],
)
def test_a_unit_of_a_velocity_is_asked_for(tmp_path, linear, angular, says):
    path = velocities(tmp_path, linear, angular)
    with pytest.raises(InputError, match=f"{says}.*--units 'm/s, deg/s'"):
        read_velocities(path)
    given = read_velocities(path, units="m/s, deg/s")
    assert given.linear_velocity_mps == pytest.approx(1.5)
    assert given.yaw_rate_radps == pytest.approx(-np.pi / 2)


@pytest.mark.parametrize(
    ("linear", "angular", "unit"),
    [
        ("linear (deg/s)", "angular (deg/s)", "deg/s"),
        ("linear_degps", "angular (deg/s)", "degps"),
        ("linear (m/s)", "yaw rate m/s2", "m/s2"),
        ("Linear velocity (mph)", "angular (deg/s)", "mph"),
        ("linear_mph", "angular", "mph"),
        ("linear [kt]", "angular (deg/s)", "kt"),
        ("linear_mph_smoothed", "angular (deg/s)", "mph"),
        ("linear (m/s)", "yaw_deg", "deg"),
        ("linear ft/min", "angular (deg/s)", "ft/min"),
        ("linear (m/s)", "angular (grad/s)", "grad/s"),
        ("linear (m/s)", "angular (rpm)", "rpm"),
        ("linear (m/s)", "yaw_rpm", "rpm"),
        ("linear (m/s)", "angular (m/s)", "m/s"),
        ("linear (smoothed)", "angular (deg/s)", "smoothed"),
    ],
)
def test_a_unit_that_a_name_states_is_not_replaced(tmp_path, linear, angular, unit):
    path = velocities(tmp_path, linear, angular)
    for units in (None, "m/s, deg/s"):
        with pytest.raises(InputError, match=rf"states '{unit}', no unit that is known for"):
            read_velocities(path, units=units)


def test_two_velocities_of_which_one_states_its_unit(tmp_path):
    found = read_velocities(velocities(tmp_path, "linear", "angular (deg/s)"), units="m/s, deg/s")
    assert found.linear_velocity_mps == pytest.approx(1.5)
    assert found.yaw_rate_radps == pytest.approx(-np.pi / 2)


@pytest.mark.parametrize(
    ("quantity", "unit", "value"),
    [
        ("gyr", "degrees/s", np.pi / 180), ("gyr", "deg.s-1", np.pi / 180),
        ("gyr", "°·s⁻¹", np.pi / 180), ("gyr", "dps", np.pi / 180), ("gyr", "rads", 1),
        ("gyr", "mradps", 1e-3), ("acc", "m·s⁻²", 1), ("acc", "m/(s^2)", 1),
        ("acc", "M.S-2", 1), ("acc", "mps2", 1), ("acc", "m/s²", 1),
        ("acc", "m s^-2", 1), ("speed", "km.h-1", 1 / 3.6), ("speed", "mmps", 1e-3),
    ],
)  # fmt: skip
def test_one_table_of_units(quantity, unit, value):
    assert factor(quantity, unit, "a.csv") == pytest.approx(value, rel=1e-12)
    for other in {"acc", "gyr", "speed"} - {quantity}:
        with pytest.raises(InputError, match=r"is not known; expected"):
            factor(other, unit, "a.csv")


@pytest.mark.parametrize("head", ["", "sep=;\n", "\n", "sep=,\n\n"])
def test_lines_of_velocities_are_counted_as_an_editor_does(tmp_path, head):
    rows = ["0,1,2", "0.01,1,2", "", "0.02,{},2", "{},1,2"]
    for cells, says in ((("", "0.03"), "column linear"), (("99", "0.03"), "column linear")):
        text = head + "time_s,linear (m/s),angular (deg/s)\n" + "\n".join(rows).format(*cells)
        separator = ";" if "sep=;" in head else ","
        path = write(tmp_path / "v.csv", text.replace(",", separator).replace("sep=;;", "sep=;"))
        line = head.count("\n") + 5
        assert f"line {line}, {says}" in refused(read_velocities, path)
    text = head + "time_s,linear (m/s),angular (deg/s)\n" + "\n".join(rows).format("1", "0.09")
    path = write(tmp_path / "v.csv", text.replace("sep=;", "sep=,"))
    assert f"at line {head.count(chr(10)) + 6}, expected even" in refused(read_velocities, path)


@pytest.mark.parametrize(
    ("linear", "mps"),
    [
        ("linear (m/s)", 1.5), ("lin_mps", 1.5), ("linear [m.s-1]", 1.5), ("linear m s^-1", 1.5),
        ("linear (km/h)", 1.5 / 3.6), ("linear_kmh", 1.5 / 3.6), ("linear (km.h-1)", 1.5 / 3.6),
        ("linear (cm/s)", 0.015), ("linear (mm/s)", 0.0015), ("linear (m·s⁻¹)", 1.5),
        ("linear (smoothed) m / s", 1.5), ("lin_mps_smoothed", 1.5),
    ],
)  # fmt: skip
def test_units_of_a_speed(tmp_path, linear, mps):
    found = read_velocities(velocities(tmp_path, linear, "angular (deg/s)"))
    assert found.linear_velocity_mps == pytest.approx(mps, rel=1e-12)


@pytest.mark.parametrize(
    ("angular", "radps"),
    [
        ("angular (deg/s)", -np.pi / 2), ("yaw_rate_degps", -np.pi / 2), ("yaw °/s", -np.pi / 2),
        ("angular (rad/s)", -30.0), ("yaw_rate_radps", -30.0), ("angular (mrad/s)", -0.03),
        ("angular (º.s-1)", -np.pi / 2),
    ],
)  # fmt: skip
def test_units_of_a_yaw_rate(tmp_path, angular, radps):
    rows = "0,1,{0}\n0.01,1,{0}\n".format(-30 if "rad" in angular else -90)
    found = read_velocities(velocities(tmp_path, "linear (m/s)", angular, rows))
    assert found.yaw_rate_radps == pytest.approx(radps, rel=1e-12)


def test_a_unit_that_is_given_and_stated_must_be_one(tmp_path):
    for name in ("linear_mps (km/h)", "linear_kmh_mps"):
        with pytest.raises(InputError, match="states two units"):
            read_velocities(velocities(tmp_path, name, "angular (deg/s)"))
    path = velocities(tmp_path, "linear (m/s)", "angular (deg/s)")
    with pytest.raises(InputError, match=r"angular \(deg/s\) is in deg/s, but --units says rad/s"):
        read_velocities(path, units="m/s, rad/s")
    for wrong in ("m/s", "deg/s, m/s", "m/s, deg/s, s", "", 3, "m/s, rpm"):
        with pytest.raises(InputError, match=r"units: got .*'m/s, deg/s'"):
            read_velocities(path, units=wrong)


@pytest.mark.parametrize(
    ("rows", "says"),
    [
        ("0,1,2\n0.01,1e6,2\n", r"line 3, column linear \(m/s\): 1e\+06 m/s, more than any chair"),
        ("0,1,2\n0.01,1,-5000\n", r"line 3, column angular \(deg/s\): -5000 deg/s, more"),
    ],
)
def test_a_single_velocity_that_no_chair_has(tmp_path, rows, says):
    with pytest.raises(InputError, match=says):
        read_velocities(velocities(tmp_path, "linear (m/s)", "angular (deg/s)", rows))
