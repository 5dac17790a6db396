"""Command line: from a recording to angles, velocities, tasks, and the papers' numbers checked.

Exit code 0: done. Exit code 2: the input or an argument is at fault; one line on stderr says what,
and no output file is left behind. Exit code 130: interrupted.
"""

from mobility_imu.cli.main import main

__all__ = ["main"]
