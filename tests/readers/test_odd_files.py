"""What a name may lead to by accident: each ends in one sentence that says what to do."""

import gzip
import os
import zipfile

import dialects
import pytest
from test_dialects import OF_ONE, made, quietly
from test_sessions_apart import locked, packed

from mobility_imu.errors import InputError
from mobility_imu.readers import table
from mobility_imu.readers.recordings import understand
from mobility_imu.readers.table import read_text
from mobility_imu.readers.velocities import read_velocities

MAP = '[clock]\nrate_hz = 100\n[sensors.frame]\nacc = ["a", "b", "c"]\nacc_unit = "g"\n'


def refused(reader, *arguments, **options):
    with pytest.raises(InputError) as told:
        reader(*arguments, **options)
    assert str(told.value).isprintable()
    return str(told.value)


# Names


def test_what_is_no_file_is_named_once(tmp_path):
    for reader in (read_text, read_velocities):
        said = refused(reader, tmp_path)
        assert said == f"{tmp_path}: is a folder, expected a file"
    assert refused(read_text, "/dev/null") == "/dev/null: is a device or socket, expected a file"
    os.mkfifo(tmp_path / "pipe")
    assert refused(read_text, tmp_path / "pipe", again=True).count("pipe:") == 1


def test_a_hyphen_is_no_name_of_standard_input(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for reader in (understand, read_text, read_velocities):
        assert "standard input is read as /dev/stdin" in refused(reader, "-")
    assert "/dev/stdin" not in refused(read_text, "-", again=True)  # no pipe is read twice
    own = dialects.canonical(made(), tmp_path)
    assert "/dev/stdin" in refused(understand, own, map_path="-")
    own.rename(tmp_path / "-")  # somebody's file may have this name
    assert len(quietly("-")) == len(made())


@pytest.mark.parametrize("name", [b"\xe9.csv", b"n" * 251 + b".csv", "\u202e.csv".encode()])
def test_names_that_are_not_in_utf_8_or_long(tmp_path, name):
    path = os.path.join(tmp_path, os.fsdecode(name))
    os.rename(dialects.canonical(made(), tmp_path), path)
    assert len(quietly(path)) == len(made())


def test_a_sensor_of_a_file_without_a_name(tmp_path):
    path = dialects.canonical(made(), tmp_path)
    assert refused(understand, f"{path}#frame").endswith(
        f"; one sensor of a file is given a name, as in frame={path}#frame"
    )
    assert "as in" not in refused(understand, f"{path}x#frame")
    assert len(quietly(f"frame={path}#frame")) == len(made())


# Archives


def test_what_to_do_with_a_password(tmp_path):
    path = packed(dialects.sensor_logger(made(), tmp_path))
    path.write_bytes(locked(path.read_bytes()))
    assert refused(understand, path).endswith(
        "is locked with a password; unpack it and give the folder"
    )


def test_a_kind_of_packing_that_is_not_known(tmp_path):
    """As Windows packs large files, by Deflate64, whose number is 9."""
    path = packed(dialects.sensor_logger(made(), tmp_path))
    raw = path.read_bytes()
    for mark, at in ((b"PK\x03\x04", 8), (b"PK\x01\x02", 10)):
        head, *rest = raw.split(mark)
        raw = mark.join([head, *(part[: at - 4] + b"\x09" + part[at - 3 :] for part in rest)])
    path.write_bytes(raw)
    assert refused(understand, path).endswith("; unpack it and give the folder")


@pytest.mark.parametrize("inside", ["a.csv", "session.zip"])
def test_an_archive_with_something_else_in_it(tmp_path, inside):
    folder = tmp_path / "session"
    folder.mkdir()
    within = packed(dialects.sensor_logger(made(), folder))
    content = dialects.canonical(made(), tmp_path) if inside == "a.csv" else within
    with zipfile.ZipFile(tmp_path / "out.zip", "w") as out:
        out.write(content, inside)
    said = refused(understand, tmp_path / "out.zip")
    assert f"it holds {inside}; unpack it and give what is in it" in said


def test_an_archive_that_is_cut(tmp_path):
    path = packed(dialects.sensor_logger(made(), tmp_path))
    path.write_bytes(path.read_bytes()[:-30])
    assert "cannot be opened as an archive" in refused(understand, path)
    assert refused(understand, path).endswith("; is it complete?")


def test_a_file_that_is_packed_twice(tmp_path):
    path = dialects.canonical(made(), tmp_path)
    raw = gzip.compress(path.read_bytes())
    path.write_bytes(gzip.compress(raw))
    assert "is packed by gzip; unpack it" in refused(understand, path)
    for kept in (1, 5, 10, 30, len(raw) // 2, len(raw) - 8, len(raw) - 1):
        path.with_suffix(".gz").write_bytes(raw[:kept])
        assert "is it complete?" in refused(understand, path.with_suffix(".gz"))


def test_a_packed_file_that_is_larger_than_a_recording(tmp_path, monkeypatch):
    path = dialects.canonical(made(), tmp_path)
    content = path.read_bytes()
    path.write_bytes(gzip.compress(content))
    monkeypatch.setattr(table, "LARGEST_UNPACKED", len(content))
    assert len(quietly(path)) == len(made())
    monkeypatch.setattr(table, "LARGEST_UNPACKED", len(content) - 1)
    assert "too large for a recording" in refused(understand, path)


# NUL bytes


def tables(folder):
    """One file or more of a recording, each a text."""
    files = folder.rglob("*") if folder.is_dir() else [folder]
    return [file for file in files if file.is_file() and "meta" not in str(file).lower()]


@pytest.mark.parametrize("write", OF_ONE, ids=lambda w: w.__name__)
def test_a_file_whose_end_is_nul_bytes(tmp_path, write):
    """As a card leaves it where the device lost its power."""
    path = write(made(), tmp_path)
    path = path if path.exists() else path.with_name(f"{path.name}-Frame.txt")
    kept = {file: file.read_bytes() for file in tables(path)}
    for file, raw in kept.items():
        half = len(raw) // 4 * 2  # a whole character of UTF-16
        file.write_bytes(raw[:half] + b"\0" * (len(raw) - half))
    text = refused(understand, path, expected=("frame",))
    assert "NUL bytes" in text or (path.suffix == ".json" and "not valid JSON" in text), text
    for file, raw in kept.items():
        file.write_bytes(b"\0" * len(raw))
    assert "nothing but NUL bytes" in refused(understand, path, expected=("frame",))


def test_velocities_and_maps_with_nul_bytes(tmp_path):
    path = tmp_path / "v.csv"
    path.write_bytes(b"\0" * 100)
    assert "nothing but NUL bytes" in refused(read_velocities, path)
    path.write_bytes(b"time_s,linear (m/s),angular (rad/s)\n0,1,0\n0.1,1,0\n" + b"\0" * 500)
    assert "line 4" in refused(read_velocities, path)
    assert "NUL bytes" in refused(read_velocities, path)
    (tmp_path / "map.toml").write_text(MAP)
    path.write_bytes(b"a,b,c\n0,1,0\n0.1,1,0\n" + b"\0" * 500)
    assert "NUL bytes" in refused(understand, path, map_path=tmp_path / "map.toml")
