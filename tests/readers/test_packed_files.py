"""Archives of every kind of compression, whole and damaged, and JSON however it begins."""

import bz2
import codecs
import json
import lzma
import random
import warnings
import zipfile

import dialects
import pytest
from test_dialects import assert_same, made, quietly

from mobility_imu.errors import InputError
from mobility_imu.readers.recordings import understand

METHODS = {
    "stored": zipfile.ZIP_STORED,
    "deflate": zipfile.ZIP_DEFLATED,
    "bzip2": zipfile.ZIP_BZIP2,
    "lzma": zipfile.ZIP_LZMA,
}


@pytest.fixture(params=METHODS)
def archive(request, tmp_path):
    """A phone's session, packed in one of the ways that the format knows."""
    (tmp_path / "session").mkdir()
    folder = dialects.sensor_logger(made(), tmp_path / "session")
    path = tmp_path / "session.zip"
    with zipfile.ZipFile(path, "w", METHODS[request.param]) as out:
        for file in sorted(folder.rglob("*.csv")):
            out.write(file, file.relative_to(folder))
    return path


def test_archives_of_every_compression_are_read(archive):
    assert_same(quietly(archive, expected=("frame",)), made())


def test_damaged_archives_of_every_compression_are_refused_in_one_line(archive):
    whole = archive.read_bytes()
    rng = random.Random(1)
    refused = 0
    for k in range(60):
        raw = bytearray(whole)
        if k % 3:
            raw[rng.randrange(len(raw))] ^= 1 << rng.randrange(8)
        else:
            del raw[rng.randrange(len(raw)) :]
        archive.write_bytes(raw)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                understand(archive, expected=("frame",))
            except InputError as error:
                refused += 1
                assert str(archive) in str(error)
                assert str(error).isprintable()
    assert refused > 30  # names, dates and comments may be damaged


@pytest.mark.parametrize(
    ("pack", "kind"),
    [
        (lzma.compress, "xz"),
        (lambda raw: lzma.compress(raw)[:50], "xz"),
        (bz2.compress, "bzip2"),
        (lambda raw: b"7z\xbc\xaf\x27\x1c" + raw, "7-Zip"),
        (lambda raw: b"Rar!\x1a\x07\x01\x00" + raw, "RAR"),
        (lambda raw: b"\x28\xb5\x2f\xfd" + raw, "Zstandard"),
    ],
    ids=["xz", "cut xz", "bzip2", "7z", "rar", "zstd"],
)
def test_other_packed_files_are_named(tmp_path, pack, kind):
    path = tmp_path / "ride.csv"
    path.write_bytes(pack(dialects.canonical(made(), tmp_path).read_bytes()))
    with pytest.raises(InputError, match=rf"ride\.csv: is packed by {kind}; unpack it"):
        understand(path)


def test_a_name_in_gz_may_lead_to_a_file_that_a_browser_unpacked(tmp_path):
    """A server may send a packed file which the browser unpacks under the packed one's name."""
    path = tmp_path / "own.csv.GZ"
    dialects.canonical(made(), tmp_path).rename(path)
    assert_same(quietly(path), made())


# JSON


@pytest.mark.parametrize("bom", [b"", codecs.BOM_UTF8], ids=["plain", "mark"])
@pytest.mark.parametrize(
    "before",
    ["", " ", "\t", "\n", "\r\n", "\n\n  ", "\ufeff", "\n\ufeff ", " \ufeff\n"],
    ids=ascii,
)
@pytest.mark.parametrize("write", [dialects.json_samples, dialects.movesense])
def test_json_is_known_by_what_follows_blanks_and_marks(tmp_path, write, before, bom):
    path = write(made(), tmp_path)
    text = path.read_text()
    expected = quietly(path)
    path.write_bytes(bom + before.encode() + text.encode())
    assert_same(quietly(path), expected)


@pytest.mark.parametrize("write", [dialects.json_samples, dialects.movesense])
@pytest.mark.parametrize(
    "dumped",
    [
        {"indent": 1},
        {"indent": "\t"},
        {"separators": (" , ", " : ")},
        {"separators": (",\n", ":")},
    ],
    ids=["indented", "tabs", "blanks", "lines"],
)
def test_json_is_known_in_every_layout(tmp_path, write, dumped):
    path = write(made(), tmp_path)
    expected = quietly(path)
    text = json.dumps(json.loads(path.read_text()), **dumped)
    for changed in (text, text.replace("{", "{ "), text.replace("[{", "[ {"), text + "\n\n"):
        path.write_text(changed)
        assert_same(quietly(path), expected)


def test_canonical_tables_may_begin_with_a_mark_behind_blanks(tmp_path):
    path = dialects.canonical(made(), tmp_path)
    path.write_text("\n\ufeff\ufeff" + path.read_text(), encoding="utf-8")
    assert_same(quietly(path), made())


def packed(path, files):
    """Archive of these files, whose names may repeat."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that they do
        with zipfile.ZipFile(path, "w") as out:
            for name, content in files:
                out.writestr(name, content)
    return path


@pytest.fixture
def files(tmp_path):
    """Names and contents of a phone's session."""
    (tmp_path / "session").mkdir()
    folder = dialects.sensor_logger(made(), tmp_path / "session")
    return [(str(f.relative_to(folder)), f.read_text()) for f in sorted(folder.rglob("*.csv"))]


def test_names_with_the_separator_of_windows(tmp_path, files):
    """Some programs of Windows pack them, against the format."""
    archive = packed(tmp_path / "s.zip", [(f"Trial\\{name}", text) for name, text in files])
    assert_same(quietly(archive, expected=("frame",)), made())


def test_two_files_of_one_name_that_are_not_read(tmp_path, files):
    notes = [("README.txt", "one"), ("README.txt", "two")]
    archive = packed(tmp_path / "s.zip", [*files, *notes])
    assert_same(quietly(archive, expected=("frame",)), made())


def test_two_files_of_one_name(tmp_path, files):
    """Python would read the last of them."""
    archive = packed(tmp_path / "s.zip", [*files, files[0]])
    with pytest.raises(InputError, match=r"s\.zip: holds two files called '?[A-Z]\w+\.csv"):
        understand(archive, expected=("frame",))
