"""One sensor on its own clock, as a vendor's file has it: the state before sensors are joined."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.frames import STANDARD_GRAVITY_MPS2, FloatArray, as_series, as_vectors
from mobility_imu.readers.table import NumberTable
from mobility_imu.results import Result


@dataclass(frozen=True, eq=False, repr=False)
class Stream(Result):
    """What one sensor gave, on its own clock.

    Unlike a :class:`~mobility_imu.recording.Recording`, whose clock is checked, times may repeat,
    run backwards or leave gaps: :func:`~mobility_imu.readers.clocks.join_streams` mends that.

    Parameters
    ----------
    time_s : (n,) array, s, the sensor's own stamps
    acc_mps2 : (n, 3) array, m/s², specific force
    gyr_radps : (n, 3) array, rad/s
    source : where it comes from; error messages begin with it
    warnings : what the reader left out or found odd

    Raises
    ------
    InputError
        If there is no sample, the lengths differ, or a value is no finite number.
    """

    time_s: FloatArray
    acc_mps2: FloatArray
    gyr_radps: FloatArray
    source: str = field(default="stream", kw_only=True)
    warnings: tuple[str, ...] = field(default=(), kw_only=True)

    def __post_init__(self) -> None:
        """Check shapes and numbers."""
        time_s = as_series(self.time_s, f"{self.source}: time")
        if not len(time_s):
            raise InputError(f"{self.source}: no usable sample")
        object.__setattr__(self, "time_s", time_s)
        for name in ("acc_mps2", "gyr_radps"):
            values = as_vectors(
                getattr(self, name), f"{self.source}: {name}", length=len(time_s), finite=True
            )
            object.__setattr__(self, name, values)
        super().__post_init__()

    def __len__(self) -> int:
        """Return the number of samples."""
        return len(self.time_s)


def stream_in_g_and_degrees(
    table: NumberTable, time_s: FloatArray, acc: list[str], gyr: list[str]
) -> Stream:
    """Stream from columns in g and deg/s.

    Parameters
    ----------
    table : the file's columns
    time_s : (n,) array, s
    acc : names of the three columns of the accelerometer, g
    gyr : names of the three columns of the gyroscope, deg/s

    Returns
    -------
    Stream
    """
    return Stream(
        time_s,
        table.columns(acc) * STANDARD_GRAVITY_MPS2,
        np.deg2rad(table.columns(gyr)),
        source=table.source,
    )
