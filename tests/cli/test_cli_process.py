"""The command line as a process of its own: how it starts, and how it ends."""

import os
import signal
import subprocess
import sys

import pytest
from command_lines import velocity

MODULE = [sys.executable, "-m", "mobility_imu"]


def test_from_files_to_a_file(inputs, tmp_path):
    """Another folder, no terminal: exit code 0, the file, and with --quiet silence."""
    result = subprocess.run(
        [*MODULE, *map(str, velocity(inputs / "court.csv.gz")), "--quiet"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
    )
    assert (result.returncode, result.stdout, result.stderr) == (0, "", "")
    assert [path.name for path in tmp_path.iterdir()] == ["v.csv"]


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="a device of Linux")
def test_standard_output_on_a_full_disk(inputs, tmp_path):
    """One line and exit code 2, also from what the interpreter does at its end."""
    trials = map(str, velocity(inputs / "court.csv.gz")[2:-2])
    with open("/dev/full", "w") as full:
        result = subprocess.run(
            [*MODULE, "wheelchair", "check", *trials],
            cwd=tmp_path,
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
        )
    assert result.returncode == 2
    assert result.stderr == (
        "mobility-imu: standard output: cannot be written (No space left on device)\n"
    )


def test_interrupted_while_it_waits_for_its_input(tmp_path, hears_interrupts):
    """Ctrl-C: exit code 130, one line, nothing left behind."""
    os.mkfifo(tmp_path / "slow.csv")
    options = map(str, velocity("slow.csv"))
    command = subprocess.Popen(
        [*MODULE, *options], cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    with open(tmp_path / "slow.csv", "w") as recording:  # waits until the command reads it
        recording.write("time_s,")
        recording.flush()
        command.send_signal(signal.SIGINT)
        _, message = command.communicate(timeout=60)
    assert (command.returncode, message) == (130, "mobility-imu: interrupted\n")
    assert [path.name for path in tmp_path.iterdir()] == ["slow.csv"]
