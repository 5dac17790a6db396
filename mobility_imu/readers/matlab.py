"""Variables of a MATLAB file."""

from __future__ import annotations

import io
from collections.abc import Sequence

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray
from mobility_imu.readers.wording import listed, quoted


def parse_matlab(content: bytes, names: Sequence[str], source: str) -> dict[str, FloatArray]:
    """Arrays of numbers of a ``.mat`` file (version 5 to 7, not 7.3).

    Parameters
    ----------
    content : of the file
    names : variables that are wanted
    source : the file's name, for messages

    Returns
    -------
    dict of name to array of float; dimensions of length one are taken out

    Raises
    ------
    InputError
        If it is no such file, or a variable is missing or holds no numbers.
    """
    from scipy.io import loadmat

    try:
        found = loadmat(io.BytesIO(content), squeeze_me=True, variable_names=list(names))
    except Exception as error:  # a damaged file fails in many ways
        raise InputError(f"{source}: no MATLAB file ({quoted(str(error))})") from None
    missing = [name for name in names if name not in found]
    if missing:
        raise InputError(f"{source}: no variable {listed(missing)}")
    arrays = {}
    for name in names:
        try:
            arrays[name] = np.asarray(found[name], float)
        except (TypeError, ValueError):
            raise InputError(f"{source}: variable {quoted(name)} holds no numbers") from None
    return arrays
