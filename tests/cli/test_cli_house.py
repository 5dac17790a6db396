"""Slips of typing, signals, settings of other libraries: one line, and nothing half-written."""

import ast
import functools
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from command_lines import angles, contents

import mobility_imu.__main__ as module
from mobility_imu import readers

# Names and numbers as people mistype them.


@pytest.mark.parametrize("option", ["-o=a.csv", "-o==", "-qo=a.csv"])
def test_an_equals_sign_behind_a_letter(room, fails, option):
    """The parser of arguments takes it for the beginning of the name."""
    line = ["scooter", "angles", "ride.csv", "--geometry", "g.toml", option]
    fails(*line, says=["--output", "begins with an equals sign", "./="])
    fails("simulate", "walker", "--seed", 1, option, says=["begins with an equals sign"])


@pytest.mark.parametrize(
    ("typed", "says"),
    [
        (["-output", "a.csv"], "-output: has one dash; write --output"),
        (["-output=a.csv"], "-output=a.csv: has one dash; write --output=a.csv"),
        (["-o", "a.csv", "-geometry", "g.toml"], "-geometry: has one dash; write --geometry"),
        (["-o", "a.csv", "\u2014geometry", "g.toml"], "is no hyphen; write --geometry"),
        (["\u2013o", "a.csv"], "is no hyphen; write -o"),
        (["-o", "a.csv", "\u2013\u2013strict"], "is no hyphen; write --strict"),
        (["-o", "a.csv", "\u2212\u2212method=fusion"], "is no hyphen; write --method=fusion"),
        (["-help"], "-help: has one dash; write --help"),
        (["\u2014help"], "is no hyphen; write --help"),
    ],
)
def test_dashes_that_are_wrong(room, fails, typed, says):
    fails("scooter", "angles", "ride.csv", "--geometry", "g.toml", *typed, says=[says])


@pytest.mark.parametrize("name", ["-output", "\u2014geometry", "\u2013o.csv"])
def test_a_value_may_look_like_a_slip(room, works, name):
    works(*angles(output=name))
    assert (room / name).exists()
    works("scooter", "angles", "ride.csv", "--geometry", "g.toml", "-qo", name)


def test_options_of_other_commands_are_not_proposed(room, run):
    """Here ``-p`` is unknown, and so is ``--poses``."""
    line = ["wheelchair", "tasks", "velocity.csv", "-o", "k.csv", "-poses", "p"]
    result = run(*line)
    assert result.returncode == 2 and "--poses" not in result.stderr


@pytest.mark.parametrize("name", ["new/", "new.csv/", "new.csv/.", "./new//"])
def test_a_folders_name_is_no_files(room, fails, name):
    fails(*angles(output=name), says=["--output", "ends as the name of a folder"])
    tasks = ["wheelchair", "tasks", "velocity.csv", "-o", "k.csv"]
    for option in ("--events", "--figure"):
        fails(*tasks, option, f"{name}.png/", says=[option, "ends as the name of a folder"])


@pytest.mark.parametrize(
    ("option", "value"),
    [("--sampling-rate-hz", "1_5"), ("--median-window", "1_1"), ("--fill-gaps-s", "0_1")],
)
@pytest.mark.parametrize("joined", [False, True])
def test_an_underscore_is_part_of_no_number(room, fails, option, value, joined):
    typed = [f"{option}={value}"] if joined else [option, value]
    fails(*angles(), *typed, says=[f"{option}: '{value}' is no number"])


def test_an_underscore_is_part_of_no_seed(tmp_path, fails):
    fails("simulate", "walker", "--seed", "9_00", "-o", "s", says=["--seed: '9_00' is no number"])


def test_the_next_command_takes_a_name_with_a_dash(tmp_path, works):
    said = works("simulate", "walker", "--seed", 1, "-o", "-s").stderr
    assert "next: mobility-imu walker calibrate ./-s/tilts.csv.gz" in said


# How a process ends.

SLOWED = """
import os, sys, time
real = getattr(os, sys.argv[1])
count = [int(sys.argv[2])]
def slow(*arguments, **options):
    count[0] -= 1
    if not count[0]:
        print("now", flush=True)
        time.sleep(30)
    return real(*arguments, **options)
setattr(os, sys.argv[1], slow)
sys.argv[1:] = sys.argv[3:]
from mobility_imu.__main__ import main
main()
"""
"""A command that waits at the nth call of a function of the system."""
TASKS = "wheelchair tasks velocity.csv -o k.csv --events e.csv --figure f.svg"
SIMULATION = "simulate walker --seed 1 -o new/s"


@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="Windows ends processes at once")
@pytest.mark.parametrize("name", ["SIGTERM", "SIGHUP"])
@pytest.mark.parametrize(("line", "call"), [(TASKS, "replace"), (SIMULATION, "fsync")])
def test_a_process_that_is_ended_leaves_nothing(room, name, line, call):
    """As a scheduler or ``timeout`` ends it, or a terminal that is closed."""
    (room / "k.csv").write_text("old")
    before = contents(room)
    command = subprocess.Popen(
        [sys.executable, "-c", SLOWED, call, "2", *line.split()],
        cwd=room,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        # Whoever starts the tests may ignore the signal, and a child inherits that.
        preexec_fn=functools.partial(signal.signal, signal.Signals[name], signal.SIG_DFL),
    )
    assert command.stdout.readline() == "now\n"
    command.send_signal(signal.Signals[name])
    _, message = command.communicate(timeout=60)
    assert message == "mobility-imu: interrupted\n"
    assert command.returncode == -signal.Signals[name]  # as who sent it expects
    assert contents(room) == before


@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="Windows ends processes at once")
def test_a_signal_that_is_ignored_stays_so(room):
    """``nohup`` lets a command outlive its terminal."""
    command = subprocess.Popen(
        [sys.executable, "-c", SLOWED.replace("30", "1"), "fsync", "1", *map(str, angles())],
        cwd=room,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=functools.partial(signal.signal, signal.SIGHUP, signal.SIG_IGN),
    )
    assert command.stdout.readline() == "now\n"
    time.sleep(0.1)
    command.send_signal(signal.SIGHUP)
    command.communicate(timeout=60)
    assert command.returncode == 0
    assert (room / "a.csv").exists()


def test_a_second_signal_does_not_stop_the_tidying_up(monkeypatch):
    """``timeout`` sends its signal to the process, and to the group that it is in."""
    monkeypatch.setattr(module, "_ended_by", [])
    with pytest.raises(KeyboardInterrupt):
        module._interrupt(15, None)
    module._interrupt(15, None)
    monkeypatch.setattr(module, "TWICE_S", 0.0)  # a library has swallowed the first one
    with pytest.raises(KeyboardInterrupt):
        module._interrupt(15, None)


def test_an_ending_that_python_drops_comes_again(monkeypatch):
    sent = []
    monkeypatch.setattr(os, "kill", lambda _, number: sent.append(number))
    monkeypatch.setattr(module, "_ended_by", [(15, time.monotonic())])
    monkeypatch.setattr(sys, "unraisablehook", module._deliver_interrupts)

    class Dropped:
        def __del__(self):
            raise KeyboardInterrupt

    Dropped()
    for _ in range(100):
        time.sleep(0.02)
        if sent:
            break
    assert (sent, module._ended_by) == ([15], [])


def test_an_interrupt_that_a_library_makes_an_error_of_its_loading(room, run, monkeypatch):
    def load(*arguments, **options):
        try:
            raise KeyboardInterrupt
        except KeyboardInterrupt as error:
            raise ImportError("initialization failed") from error

    monkeypatch.setattr(readers, "read_recording", load)
    result = run(*angles())
    assert (result.returncode, result.stderr) == (130, "mobility-imu: interrupted\n")


# Standard output that takes nothing.

PRINTS = [
    ["read", "ride.csv", "-o", "a.csv"],
    [
        *("scooter", "check", "parked_level.csv.gz", "--geometry", "geometry.toml"),
        *("--poses", "poses.csv", "-o", "a.csv"),
    ],
]


class Stream:
    """Standard output that fails."""

    def __init__(self, error):
        self.error = error

    def write(self, text):
        raise self.error

    def flush(self):
        """Nothing is held back."""


@pytest.fixture
def both(room, simulated):
    """Inputs of both commands that print and write."""


@pytest.mark.usefixtures("both")
@pytest.mark.parametrize("line", PRINTS, ids=lambda line: line[0])
def test_what_cannot_be_printed_is_not_written(room, monkeypatch, fails, line):
    (room / "a.csv").write_text("old")
    monkeypatch.setattr(sys, "stdout", Stream(OSError(28, os.strerror(28))))
    fails(*line, says=["standard output: cannot be written (No space left on device)"])


@pytest.mark.usefixtures("both")
@pytest.mark.parametrize("line", PRINTS, ids=lambda line: line[0])
def test_what_nobody_reads_is_written_all_the_same(room, monkeypatch, works, line):
    monkeypatch.setattr(sys, "stdout", Stream(BrokenPipeError(32, os.strerror(32))))
    works(*line)
    assert (room / "a.csv").stat().st_size > 100


# Other libraries.


def process(room, line, **variables):
    return subprocess.run(
        [sys.executable, "-m", "mobility_imu", *line.split()],
        cwd=room,
        env={**os.environ, **variables},
        capture_output=True,
        text=True,
    )


def test_lines_of_other_libraries_are_not_shown(room):
    """Matplotlib logs that it cannot keep its cache, and what it does not know in its settings."""
    (room / "matplotlibrc").write_text("no.key: 1\n")
    (room / "file").touch()
    line = "wheelchair tasks velocity.csv -o k.csv --figure f.png --quiet"
    result = process(room, line, MPLCONFIGDIR=str(room / "file"))
    assert (result.returncode, result.stderr) == (0, "")


def test_a_drawing_that_fails_is_one_line(room, fails, monkeypatch):
    """As where text is to be set by a LaTeX that is not there."""

    def broken(*arguments):
        raise RuntimeError("latex could not be found\nin PATH")

    monkeypatch.setattr("mobility_imu.cli.wheelchair.figure_bytes", broken)
    line = ["wheelchair", "tasks", "velocity.csv", "-o", "k.csv", "--figure", "f.png"]
    fails(*line, says=["--figure f.png: cannot be drawn (latex could not be found)"])


def test_a_library_that_cannot_be_loaded_is_one_line(room):
    """Numba reads how many threads it may have when it is loaded."""
    line = "walker trajectory walk.csv.gz --geometry frame.toml -o p.csv"
    result = process(room, line, NUMBA_NUM_THREADS="0", MOBILITY_IMU_NO_NUMBA="")
    assert result.returncode == 2
    assert result.stderr.startswith("mobility-imu: numba cannot be loaded (Number of threads")
    assert result.stderr.count("\n") == 1
    assert "MOBILITY_IMU_NO_NUMBA=1" in result.stderr


BROKEN = """
import importlib.util, sys

class Finder:
    def find_spec(self, name, path=None, target=None):
        if name == {name!r}:
            return importlib.util.spec_from_file_location(name, {file!r})

sys.meta_path.insert(0, Finder())
"""


@pytest.mark.parametrize(
    ("name", "code"),
    [
        ("numba", "raise OSError('no shared object')"),
        ("pandas", "import dateutil_missing"),
        ("scipy.ndimage", "raise ImportError('libopenblas')"),
    ],
)
def test_however_a_library_fails(room, name, code):
    (room / "broken.py").write_text(code)
    begin = BROKEN.format(name=name, file=str(room / "broken.py"))
    begin += "import mobility_imu.__main__ as m; m.main()"
    line = "scooter angles ride.csv --geometry g.toml --method fusion -o a.csv"
    command = [sys.executable, "-c", begin, *line.split()]
    variables = {**os.environ, "MOBILITY_IMU_NO_NUMBA": ""}
    result = subprocess.run(command, cwd=room, env=variables, capture_output=True, text=True)
    told = result.stderr.splitlines()
    assert (result.returncode, len(told)) == (2, 1)
    assert told[0].startswith(f"mobility-imu: {name.partition('.')[0]} cannot be loaded (")


def test_a_cache_below_a_folder_that_was_removed(tmp_path, monkeypatch, fails):
    gone = tmp_path / "gone"
    gone.mkdir()
    monkeypatch.chdir(gone)
    gone.rmdir()
    monkeypatch.setenv("MOBILITY_IMU_CACHE", "here")
    monkeypatch.delenv("MOBILITY_IMU_RECORDINGS", raising=False)
    try:
        fails(
            "fetch", "--list", says=["MOBILITY_IMU_CACHE = here", "current folder does not exist"]
        )
    finally:
        monkeypatch.chdir(tmp_path)


# Other encodings than UTF-8, which files of ours and JSON are in.

C_LOCALE = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}


@pytest.mark.parametrize(
    "variables", [C_LOCALE, {"PYTHONIOENCODING": "latin-1"}], ids=["C", "8859"]
)
def test_numbers_as_json_in_another_locale(room, variables):
    result = subprocess.run(
        [sys.executable, "-m", "mobility_imu", "reproduce", "--json", "--work", "scooter"],
        cwd=room,
        env={**os.environ, **variables},
        capture_output=True,
    )
    assert result.returncode == 0, result.stderr
    assert any("°" in str(row) for row in json.loads(result.stdout))


def test_no_file_is_opened_in_the_locales_encoding():
    """Windows and containers have others than UTF-8, in which our own files are."""
    package = Path(module.__file__).parent
    without = []
    for path in package.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
                named = {keyword.arg for keyword in node.keywords}
                reads = node.func.attr == "read_text" and not node.args
                writes = node.func.attr == "write_text" and len(node.args) == 1
                if (reads or writes) and "encoding" not in named:
                    without.append(f"{path.name}:{node.lineno}")
    assert not without


def test_a_sample_that_is_another_folder(tmp_path, monkeypatch, fails):
    monkeypatch.setenv("MOBILITY_IMU_DATA", str(tmp_path))
    for line in (["reproduce"], ["reproduce", "--work", "wheelchair"]):
        fails(*line, says=[f"MOBILITY_IMU_DATA = {tmp_path}: does not hold the sample"])
