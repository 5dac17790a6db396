"""Readers: one module per file format, each returns a Recording (or a velocity series).

:func:`~mobility_imu.readers.recordings.read_recording` looks at a file and picks the reader.
"""

from mobility_imu.readers.recordings import read_recording, recording_files

__all__ = ["read_recording", "recording_files"]
