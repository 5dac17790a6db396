"""What a recipe reads from and writes to: files of the origin, tables and notes of ours."""

from __future__ import annotations

import gzip
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from mobility_imu.errors import InputError
from mobility_imu.recording import Recording

if TYPE_CHECKING:
    from mobility_imu.readers.streams import Stream


class Files(Protocol):
    """Files of an origin, by their paths in it."""

    @property
    def names(self) -> Sequence[str]:
        """Every path of the origin, sorted, also of files that were not fetched."""

    def read(self, name: str) -> bytes:
        """Content of a file that was fetched.

        Parameters
        ----------
        name : path in the origin
        """


class Recipe(Protocol):
    """How a data set is made from its origin: a module of ``recipes``."""

    def wanted(self, path: str) -> bool:
        """Whether a file of the origin is needed.

        Parameters
        ----------
        path : in the origin
        """

    def convert(self, files: Files, out: Output) -> Note:
        """Write the data set; returns what was done.

        Parameters
        ----------
        files : of the origin; those that are wanted can be read
        out : folder that takes the data set

        Raises
        ------
        InputError
            If the origin's files are not what is expected.
        """


@dataclass
class Note:
    """What was done to the recordings, sentence by sentence.

    Parameters
    ----------
    done : what was changed
    fitted : what was fitted to the reference, so that the recordings cannot test it
    assumed : what nobody measured
    left_out : what the origin has and this does not
    warnings : what was odd in single files
    """

    done: list[str] = field(default_factory=list)
    fitted: list[str] = field(default_factory=list)
    assumed: list[str] = field(default_factory=list)
    left_out: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class Output:
    """Folder that a recipe fills.

    Parameters
    ----------
    folder : exists, empty
    """

    folder: Path

    def recording(self, name: str, recording: Recording) -> None:
        """Write a recording as canonical CSV, packed, to six decimals.

        Parameters
        ----------
        name : of the file, without ``.csv.gz``
        recording : what is written
        """
        self.table(name, recording.to_frame())

    def stream(self, name: str, sensor: str, stream: Stream) -> None:
        """Write one sensor with the clock that it has, gaps included, as canonical CSV.

        Parameters
        ----------
        name : of the file, without ``.csv.gz``
        sensor : name of the sensor
        stream : what is written
        """
        columns: dict[str, Any] = {"time_s": stream.time_s}
        for quantity, unit, values in (
            ("acc", "mps2", stream.acc_mps2),
            ("gyr", "radps", stream.gyr_radps),
        ):
            for k, axis in enumerate("xyz"):
                if values is not None:
                    columns[f"{sensor}_{quantity}_{axis}_{unit}"] = values[:, k]
        self.table(name, columns)

    def table(self, name: str, columns: Mapping[str, Any] | Any, *, digits: int = 6) -> None:
        """Write a packed table; the same numbers give the same bytes.

        Parameters
        ----------
        name : of the file, without ``.csv.gz``; a folder before it is made
        columns : DataFrame, or name to column; NaN becomes an empty cell
        digits : decimals that are kept
        """
        import pandas as pd

        text = pd.DataFrame(columns).round(digits).to_csv(index=False)
        self._write(f"{name}.csv.gz", gzip.compress(text.encode(), 9, mtime=0))

    def text(self, name: str, content: str) -> None:
        """Write a text file.

        Parameters
        ----------
        name : of the file
        content : its lines
        """
        self._write(name, content.encode())

    def _write(self, name: str, content: bytes) -> None:
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)


def decoded(files: Files, name: str, label: str) -> str:
    """Text of a file of the origin.

    Parameters
    ----------
    files : of the origin
    name : path in it
    label : what messages call the file; paths may hold people's names

    Returns
    -------
    str

    Raises
    ------
    InputError
        If it is not text in UTF-8.
    """
    try:
        return files.read(name).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"{label}: not a text file (byte {error.start})") from None
