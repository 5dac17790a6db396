"""What a file is that is no text of numbers: known by its content, whatever its name."""

from __future__ import annotations

import io
import re
import zipfile
from collections.abc import Mapping, Sequence

BEGINS = {
    b"\x89HDF\r\n\x1a\n": "an HDF5 file, as APDM's programs write it",
    b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1": "a workbook of an older Excel",
    b"MATLAB 5.0": "a MATLAB file",
    b"MATLAB 7.3": "a MATLAB file",
    b"PAR1": "a Parquet table",
    b"ARROW1": "a Feather table",
    b"FEA1": "a Feather table",
    b"\x93NUMPY": "an array of NumPy (.npy)",
    b"SQLite format 3\0": "a database of SQLite",
    b"Obj\x01avro": "a table of Avro",
    b"RDX2\n": "data of R",
    b"RDX3\n": "data of R",
    b"X\n\0\0\0": "data of R (.rds)",
    b"CDF\x01": "a NetCDF file",
    b"CDF\x02": "a NetCDF file",
    b"TDSm": "a file of LabVIEW (.tdms)",
    b"MDF     ": "a measurement file (.mf4)",
    b"#ROSBAG V": "a bag of ROS",
    b"\x89MCAP0\r\n": "a log of ROS (.mcap)",
}
"""How files begin that hold numbers, but no text."""
DOCUMENTS = {
    b"%PDF-": "a PDF",
    b"{\\rtf": "a document in RTF",
    b"\x89PNG\r\n": "a picture",
    b"\xff\xd8\xff": "a picture",
    b"GIF8": "a picture",
    b"RIFF": "a video, sound or picture",
    b"version https://git-lfs": "a pointer of Git LFS in place of the file",
}
"""How files begin that hold no numbers."""
PACKED = {
    b"\xfd7zXZ\x00": "xz",
    b"BZh": "bzip2",
    b"7z\xbc\xaf\x27\x1c": "7-Zip",
    b"Rar!\x1a\x07": "RAR",
    b"\x28\xb5\x2f\xfd": "Zstandard",
    b"\x04\x22\x4d\x18": "LZ4",
    b"\x1f\x9d": "compress",
    b"MSCF\0\0\0\0": "Windows (.cab)",
    b"\x1f\x8b": "gzip",
}
"""How packed files begin that are not unpacked here, or not again."""
CONTROL = re.compile(rb"[\x00-\x08\x0e-\x1f\x7f]")
"""Bytes that no text has, whatever its encoding."""
_ZIP = (b"PK\x03\x04", b"PK\x05\x06")
_PICKLE = re.compile(rb"\x80[\x02-\x05]")
_WEB_PAGE = re.compile(rb"\s*<(?:!doctype html|html|head)\b", re.IGNORECASE)
TAR_MARK, TAR_PLACE = b"ustar", 257
"""Of a tar archive (POSIX.1-1988), which has no mark at its beginning."""
IN_ARCHIVES = {
    "xl/": "a workbook of Excel",
    "word/": "a document of Word",
    "content.xml": "a workbook or document of LibreOffice",
    "log.bin": "a recording of ActiGraph (.gt3x)",
}
"""Files in an archive, or how their names begin, and what it is."""
EXPORT = "export it as CSV and read that"


def what_to_do(raw: bytes, *, export: str = EXPORT) -> str:
    """What a file is that holds no text of numbers, and what to do: the end of a message.

    Parameters
    ----------
    raw : content, or its beginning
    export : what to do with a file that holds something in another form

    Returns
    -------
    str, empty for what may be a text
    """
    packed = _first(PACKED, raw)
    if packed:
        return f"is packed by {packed}; unpack it and read what is in it"
    if raw.startswith(TAR_MARK, TAR_PLACE) and b"\0" in raw[:TAR_PLACE]:
        return "is a tar archive; unpack it and read what is in it"
    if raw.startswith(_ZIP):
        return _in_archive(raw, export) or f"is an archive or a workbook; {export}"
    if _WEB_PAGE.match(raw):
        return "is a web page; download the file itself"
    document = _first(DOCUMENTS, raw)
    if document:
        return f"is {document}; expected a text file"
    kind = _first(BEGINS, raw)
    if _PICKLE.match(raw) and raw.endswith(b"."):
        kind = "a pickle of Python"
    return f"is {kind}; {export}" if kind else ""


def is_plain(raw: bytes) -> bool:
    """Whether bytes can be a text with some content in an 8-bit encoding.

    Parameters
    ----------
    raw : content, or its beginning

    Returns
    -------
    bool
    """
    return raw.strip() != b"" and CONTROL.search(raw) is None


def _first(kinds: Mapping[bytes, str], raw: bytes) -> str:
    found = next((begin for begin in kinds if raw.startswith(begin)), b"")
    if found.isalnum() and is_plain(raw):  # the name of a column may begin with these letters
        return ""
    return kinds.get(found, "")


def _in_archive(raw: bytes, export: str) -> str:
    """What a ZIP archive is, by the files in it; empty if it cannot be looked into."""
    try:
        with zipfile.ZipFile(io.BytesIO(raw)) as archive:
            names = archive.namelist()
    except (OSError, ValueError, OverflowError, NotImplementedError, zipfile.BadZipFile):
        return ""
    kind = of_archive(names)
    return f"is {kind}; {export}" if kind else "is a ZIP archive; unpack it and read what is in it"


def of_archive(names: Sequence[str]) -> str:
    """What a ZIP archive is by the files in it.

    Parameters
    ----------
    names : of all files in it, with their folders

    Returns
    -------
    str, empty for an archive of any files
    """
    if names and all(name.endswith(".npy") for name in names):
        return "an archive of NumPy's arrays (.npz)"
    found = (kind for begin, kind in IN_ARCHIVES.items() if any(n.startswith(begin) for n in names))
    return next(found, "")
