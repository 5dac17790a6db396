"""Files of kinds that are not read: named by their content, with what to do, under any name."""

import bz2
import gzip
import io
import lzma
import pickle
import sqlite3
import tarfile
import zipfile

import dialects
import numpy as np
import pandas as pd
import pytest
from test_dialects import made
from test_odd_files import refused

from mobility_imu.readers.geometry import read_section
from mobility_imu.readers.kinds import what_to_do
from mobility_imu.readers.recordings import understand
from mobility_imu.readers.rests import read_rests
from mobility_imu.readers.settings import read_json_numbers
from mobility_imu.readers.table import read_text
from mobility_imu.readers.velocities import read_velocities

EXPORT = "; export it as CSV and read that"
UNPACK = "; unpack it and read what is in it"
CSV = b"time_s,frame_acc_x_mps2\n0,1\n1,2\n"


def zipped(**files):
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive:
        for name, content in files.items():
            archive.writestr(name.replace("__", "/").replace("_dot_", "."), content)
    return file.getvalue()


def tar(mode):
    file = io.BytesIO()
    with tarfile.open(fileobj=file, mode=mode) as archive:
        member = tarfile.TarInfo("ride.csv")
        member.size = len(CSV)
        archive.addfile(member, io.BytesIO(CSV))
    return file.getvalue()


def saved(save):
    file = io.BytesIO()
    save(file, np.arange(9.0))
    return file.getvalue()


def database():
    with sqlite3.connect(":memory:") as base:
        base.execute("create table t (a)")
        return base.serialize()


KINDS = {
    "tar": (tar("w"), "is a tar archive" + UNPACK),
    "tar.gz": (tar("w:gz"), "is a tar archive" + UNPACK),
    "tar.bz2": (tar("w:bz2"), "is packed by bzip2" + UNPACK),
    "zip": (zipped(ride_dot_csv=CSV), "is a ZIP archive" + UNPACK),
    "empty zip": (zipped(), "is a ZIP archive" + UNPACK),
    "7z": (b"7z\xbc\xaf\x27\x1c" + bytes(50), "is packed by 7-Zip" + UNPACK),
    "rar": (b"Rar!\x1a\x07\x00" + bytes(50), "is packed by RAR" + UNPACK),
    "lz4": (b"\x04\x22\x4d\x18" + bytes(50), "is packed by LZ4" + UNPACK),
    "xz of csv": (lzma.compress(CSV), "is packed by xz" + UNPACK),
    "bzip2 in gzip": (gzip.compress(bz2.compress(CSV)), "is packed by bzip2" + UNPACK),
    "npy": (saved(np.save), "is an array of NumPy (.npy)" + EXPORT),
    "npz": (saved(np.savez), "is an archive of NumPy's arrays (.npz)" + EXPORT),
    "pickle": (pickle.dumps({"acc": [1.0, 2.0]}), "is a pickle of Python" + EXPORT),
    "pickle in gzip": (gzip.compress(pickle.dumps([1])), "is a pickle of Python" + EXPORT),
    "parquet": (b"PAR1" + bytes(99) + b"PAR1", "is a Parquet table" + EXPORT),
    "feather": (b"ARROW1\0\0" + bytes(99), "is a Feather table" + EXPORT),
    "rds": (gzip.compress(b"X\n\0\0\0\x03" + bytes(9)), "is data of R (.rds)" + EXPORT),
    "sqlite": (database(), "is a database of SQLite" + EXPORT),
    "mat": (b"MATLAB 5.0 MAT-file, Platform: GLNXA64" + bytes(99), "is a MATLAB file" + EXPORT),
    "hdf5": (b"\x89HDF\r\n\x1a\n" + bytes(99), "is an HDF5 file, as APDM's programs"),
    "xlsx": (zipped(xl__workbook_dot_xml="<x/>"), "is a workbook of Excel" + EXPORT),
    "ods": (zipped(mimetype="a", content_dot_xml="<x/>"), "is a workbook or document of Lib"),
    "docx": (zipped(word__document_dot_xml="<x/>"), "is a document of Word" + EXPORT),
    "gt3x": (zipped(info_dot_txt="a", log_dot_bin="b"), "is a recording of ActiGraph (.gt3x)"),
    "pdf": (b"%PDF-1.4\n%\xe2\xe3\xcf\xd3\n", "is a PDF; expected a text file"),
    "pdf of text": (b"%PDF-1.4\n1 0 obj\n", "is a PDF; expected a text file"),
    "rtf": (b"{\\rtf1\\ansi time_s}", "is a document in RTF; expected a text file"),
    "png": (b"\x89PNG\r\n\x1a\n" + bytes(20), "is a picture; expected a text file"),
    "html": (b"\n<!DOCTYPE HTML><html>Sign in</html>", "is a web page; download the file itself"),
    "lfs": (b"version https://git-lfs.github.com/spec/v1\noid sha256:0\n", "a pointer of Git LFS"),
}


@pytest.mark.parametrize("name", ["r.csv", "r.dat", "r.csv.gz", "r"])
@pytest.mark.parametrize("kind", KINDS)
def test_a_kind_that_is_not_read_is_named(tmp_path, kind, name):
    path = tmp_path / name
    content, says = KINDS[kind]
    path.write_bytes(content)
    for reader in (understand, read_text, read_velocities):
        assert says in refused(reader, path)
    assert says in refused(read_rests, path, np.arange(3.0))


@pytest.mark.parametrize("kind", KINDS)
def test_under_the_name_of_an_archive(tmp_path, kind):
    """That of a file in it is looked for, or it is named."""
    path = tmp_path / "r.zip"
    content, says = KINDS[kind]
    path.write_bytes(content)
    said = refused(understand, path)
    if content.startswith(b"PK") and "ZIP archive" in says:
        assert "without a session that is known" in said
    elif content.startswith(b"\x1f\x8b"):
        assert "is packed by gzip" in said
    else:
        assert says in said


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (CSV, "is a text, no archive; rename it to .csv"),
        (b"", "the file is empty"),
        (b" ", "empty"),
    ],
)
def test_texts_under_the_name_of_an_archive(tmp_path, content, says):
    (tmp_path / "r.zip").write_bytes(content)
    assert says in refused(understand, tmp_path / "r.zip")


@pytest.mark.parametrize("kind", ["npy", "xlsx", "parquet", "mat", "sqlite"])
def test_settings_and_geometry_are_not_to_be_exported(tmp_path, kind):
    path = tmp_path / "g.toml"
    path.write_bytes(KINDS[kind][0])
    assert refused(read_section, path, "walker", ["a"]).endswith("; expected TOML")
    assert refused(read_json_numbers, path).endswith("; expected JSON")


@pytest.mark.parametrize("sensor", ["PAR1", "FEA1", "ARROW1", "RIFF", "GIF8", "TDSm", "BZh"])
def test_a_name_of_a_column_may_begin_as_a_kind(tmp_path, sensor):
    """Those that begin with letters hold bytes that no text has, too."""
    path = dialects.canonical(made(), tmp_path)
    table = pd.read_csv(path).rename(columns=lambda name: name.replace("frame_", f"{sensor}_"))
    table[[*table.columns[1:], "time_s"]].to_csv(path, index=False)
    assert path.read_text().startswith(sensor)
    assert list(understand(path).recording.sensors) == [sensor]


def test_texts_are_none_of_these_kinds(tmp_path):
    for write in (dialects.canonical, dialects.xsens_mt, dialects.apdm, dialects.movesense):
        path = write(made(count=20), tmp_path)
        path = path if path.exists() else path.with_name(f"{path.name}-Frame.txt")
        assert what_to_do(path.read_bytes()) == ""
    for text in (
        b" " * 257 + b"ustar",
        b"",
        b"P",
        b"version,1\n",
        b"PAR\n",
        b"<x>\n",
        b"time_s.\n",
        b"\x80abc.",
    ):
        assert what_to_do(text) == ""


@pytest.mark.parametrize(
    "text", ['{"time_s": [0, 1]}', '[{"time_s": 0}]', '{\n "a": 1\n}', "[[0, 1]]"]
)
def test_json_is_no_table(tmp_path, text):
    (tmp_path / "v.csv").write_text(text)
    for reader, more in ((read_velocities, ()), (read_rests, (np.arange(3.0),))):
        assert "is JSON, expected a table" in refused(reader, tmp_path / "v.csv", *more)
    (tmp_path / "v.csv").write_text("[s] time,{a}\n0,1\n")
    assert "JSON" not in refused(read_velocities, tmp_path / "v.csv")


def test_what_is_neither_a_text_nor_known(tmp_path):
    (tmp_path / "r.bin").write_bytes(bytes(range(1, 256)))
    assert f"not a text file (byte 127){EXPORT}" in refused(understand, tmp_path / "r.bin")
    assert "(byte 127); expected TOML" in refused(read_section, tmp_path / "r.bin", "walker", ["a"])
