"""Command that shows what the program understands of a recording, and writes canonical CSV."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from mobility_imu.cli.inputs import check_reading
from mobility_imu.cli.messages import summarize, warn
from mobility_imu.cli.options import FillGaps, Quiet, Rate, table_file
from mobility_imu.cli.outputs import checked_outputs, print_and_write, table_bytes

if TYPE_CHECKING:
    from mobility_imu.readers.recordings import Reading


def read(
    recording: Annotated[
        list[Path],
        typer.Argument(
            help="A file, a session's folder or archive, the common beginning of the names of "
            "Xsens exports, or several files, which are put on one clock: lever=a.csv body=b.csv "
            "[clock=same|own|start]: stamps of one clock, clocks of their own, or files that a "
            "trigger began together."
        ),
    ],
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            help="Write the recording as canonical CSV.",
            parser=table_file,
            metavar="PATH",
        ),
    ] = None,
    map_path: Annotated[
        Path | None,
        typer.Option(
            "--map", help="For any other table: a TOML file that names its columns and units."
        ),
    ] = None,
    sampling_rate_hz: Rate = None,
    fill_gaps_s: FillGaps = 0.0,
    quiet: Quiet = False,
) -> None:
    """Show what the program understands of a recording: format, sensors, rate, gravity, offsets."""
    from mobility_imu.cli.summaries import read_line, written_line
    from mobility_imu.health import examine
    from mobility_imu.readers.recordings import recording_files, understand

    name = recording if len(recording) > 1 else recording[0]
    files = recording_files(name)
    inputs = (*files, *([] if map_path is None else [map_path]))
    outputs = checked_outputs({"--output": output}, inputs)
    check_reading(sampling_rate_hz, fill_gaps_s)
    found = understand(
        name,
        sampling_rate_hz=sampling_rate_hz,
        fill_gaps_s=fill_gaps_s,
        map_path=map_path,
    )
    warn(found.warnings)
    warn(fault.sentence for fault in examine(found.recording))
    text = reading_text(found)
    table = {} if output is None else {output: table_bytes(found.recording.to_frame(), output)}
    print_and_write(text, outputs, table)
    if output is None:
        summarize([read_line(found.recording)], quiet)
        return
    as_it_was = found.format == "canonical CSV" and len(files) == 1
    own = found.recording.time_s[0] == 0 and not as_it_was
    note = "its times count from its first sample: clock=same does not fit it to other files"
    summarize([*([note] if own else []), written_line([output])], quiet)


def reading_text(found: Reading) -> str:
    """Lines that ``read`` prints.

    Parameters
    ----------
    found : Reading

    Returns
    -------
    str
    """
    import numpy as np

    from mobility_imu.offsets import rest_offsets

    recording = found.recording
    step = np.diff(recording.time_s)
    length = float(recording.time_s[-1] - recording.time_s[0])
    lines = [
        f"format    {found.format}",
        f"rate      {recording.sampling_rate_hz:.6g} Hz, from {found.rate_from}",
        f"samples   {len(recording)}, {length:.2f} s; steps of {1e3 * step.min():.3g} to "
        f"{1e3 * step.max():.3g} ms",
    ]
    offsets = rest_offsets(recording)
    for name, imu in recording.sensors.items():
        norm = np.linalg.norm(imu.acc_mps2, axis=1)
        label = found.labels.get(name, "")
        lines.append(f"{name}" + (f" (in the file: {label})" if label not in ("", name) else ""))
        lines.append(
            f"  acc     median length {np.median(norm):.3f} m/s², largest axis "
            f"{np.abs(imu.acc_mps2).max():.3g} m/s²"
        )
        if imu.gyr_radps is None:
            lines.append("  gyr     none")
            continue
        fastest = np.rad2deg(np.abs(imu.gyr_radps).max())
        rest = offsets.get(name)
        at_rest = (
            "no rest found"
            if rest is None
            else "at rest "
            + ", ".join(f"{v:.2f}" for v in np.rad2deg(rest.offset_radps))
            + " deg/s"
        )
        lines.append(f"  gyr     largest axis {fastest:.4g} deg/s; {at_rest}")
    return "\n".join(lines)
