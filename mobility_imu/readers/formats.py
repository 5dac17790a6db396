"""Which reader for which file: each format is known by how its text begins."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import NamedTuple

from mobility_imu.errors import InputError
from mobility_imu.readers.actigraph import is_actigraph, read_actigraph
from mobility_imu.readers.androsensor import is_androsensor, read_androsensor
from mobility_imu.readers.apdm import is_apdm, read_apdm
from mobility_imu.readers.canonical import is_canonical, read_canonical
from mobility_imu.readers.json_samples import is_json_samples, read_json_samples
from mobility_imu.readers.lpms import is_lpms, read_lpms
from mobility_imu.readers.movesense import is_movesense, read_movesense
from mobility_imu.readers.phyphox import is_phyphox, read_phyphox_file
from mobility_imu.readers.physics_toolbox import is_physics_toolbox, read_physics_toolbox
from mobility_imu.readers.sensor_logger import is_sensor_logger, read_sensor_logger_file
from mobility_imu.readers.shimmer import is_shimmer, read_shimmer
from mobility_imu.readers.streams import Asked, Stream
from mobility_imu.readers.wheelmove_id import is_wheelmove_id, read_wheelmove_id
from mobility_imu.readers.wording import listed, quoted
from mobility_imu.readers.xio import is_xio, read_xio
from mobility_imu.readers.xsens_dot import is_xsens_dot, read_xsens_dot
from mobility_imu.readers.xsens_mt import is_xsens_mt, read_xsens_mt

BEGINNING = 4000
"""Characters that are looked at to know a format. Set by hand."""
_JSON = re.compile(r'\s*(?:\[\s*\{|\{)\s*"')
"""How JSON begins that may hold a recording: an object with a name, or an array of such."""


class Format(NamedTuple):
    """A format of one file.

    Parameters
    ----------
    name : as messages show it
    begins : says of the first line that is not empty whether a file of this format has it
    read : content, name for messages and what the user says to streams
    names_sensors : whether its labels are names of sensors that the commands know
    """

    name: str
    begins: Callable[[str], bool]
    read: Callable[[str, str, Asked], tuple[Stream, ...]]
    names_sensors: bool = False


FORMATS = (
    Format("canonical CSV", is_canonical, read_canonical, names_sensors=True),
    Format("WheelMove-ID", is_wheelmove_id, read_wheelmove_id, names_sensors=True),
    Format("Xsens MT Manager", is_xsens_mt, read_xsens_mt),
    Format("Xsens DOT", is_xsens_dot, read_xsens_dot),
    Format("LPMS", is_lpms, read_lpms),
    Format("x-io", is_xio, read_xio),
    Format("APDM", is_apdm, read_apdm),
    Format("Shimmer", is_shimmer, read_shimmer),
    Format("Movesense", is_movesense, read_movesense),
    Format("ActiGraph", is_actigraph, read_actigraph),
    Format("Sensor Logger", is_sensor_logger, read_sensor_logger_file),
    Format("phyphox", is_phyphox, read_phyphox_file),
    Format("AndroSensor", is_androsensor, read_androsensor),
    Format("Physics Toolbox", is_physics_toolbox, read_physics_toolbox),
    Format("JSON samples", is_json_samples, read_json_samples),
)


def find_format(text: str, source: str) -> Format:
    """Format of a text.

    Parameters
    ----------
    text : content of the file
    source : the file's name, for messages

    Returns
    -------
    Format

    Raises
    ------
    InputError
        If no format begins like this, or more than one does.
    """
    lines = [line for line in re.split(r"\r?\n", text[:BEGINNING]) if line.strip(" \t;,")]
    if lines and lines[0].strip().strip('"').lower().startswith("sep=") and len(lines) > 1:
        lines = lines[1:]
    first = lines[0] if lines else ""
    if _JSON.match(text):  # on one line or many, with blanks or without
        first = re.sub(r"\s+", "", text[:BEGINNING])
    found = [form for form in FORMATS if form.begins(first)]
    if len(found) > 1:
        raise InputError(
            f"{source}: can be {listed(form.name for form in found)}; convert it by a map "
            "(mobility-imu read --map)"
        )
    if not found:
        raise InputError(
            f"{source}: unknown format. Expected a header with time_s and <sensor>_acc_x_mps2 "
            f"..., or a format of {listed((form.name for form in FORMATS[1:]), 20)}; other tables "
            "are read by a map (mobility-imu read --map). It begins with "
            f"'{quoted(first)}'"
        )
    return found[0]
