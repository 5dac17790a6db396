"""WheelMove-ID's sample: unpacked as it is, since the package reads its files."""

from __future__ import annotations

from pathlib import PurePosixPath

from mobility_imu.datasets.files import Files, Note, Output
from mobility_imu.errors import InputError

SUFFIXES = (".txt", ".csv")


def wanted(path: str) -> bool:
    """Whether a member of the archive is kept."""
    return path.lower().endswith(SUFFIXES) and "__MACOSX" not in path


def convert(files: Files, out: Output) -> Note:
    """Unpack the sample; a folder around everything is taken off."""
    names = [name for name in files.names if wanted(name)]
    if not names:
        raise InputError("the sample's archive holds no table")
    parts = {name: PurePosixPath(name).parts for name in names}
    if any(".." in p or PurePosixPath(n).is_absolute() or "\\" in n for n, p in parts.items()):
        raise InputError("the sample's archive names a path outside of it; nothing is unpacked")
    outer = {p[0] for p in parts.values()}
    cut = int(len(outer) == 1 and all(len(p) > 1 for p in parts.values()))
    for name, path in parts.items():
        target = out.folder.joinpath(*path[cut:])
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(files.read(name))
    return Note(
        done=[
            "Unpacked, byte for byte; 'mobility-imu wheelchair' reads these files.",
            "For tests and book: the variable MOBILITY_IMU_DATA names this folder.",
        ],
        left_out=[
            "The public tool's answers (reference-outputs), which are not part of the sample."
        ],
    )
