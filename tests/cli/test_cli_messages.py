"""What reaches the terminal: one line, escaped, short, and only what is ours."""

import builtins
import io
import os
import signal
import sys
import time
import warnings

import numpy as np
import pandas as pd
import pytest
from command_lines import CORRIDOR, angles, scooter_ride, velocity, velocity_csv
from scipy import linalg

from mobility_imu import readers
from mobility_imu.cli import main as entry


@pytest.fixture
def ride(tmp_path):
    scooter_ride(tmp_path)
    return tmp_path


@pytest.mark.parametrize(
    ("char", "shown"),
    [
        ("\x1b", r"\x1b"),
        ("\x07", r"\x07"),
        ("\x9b", r"\x9b"),  # the same as ESC [ on some terminals
        ("\r", r"\r"),
        ("\t", r"\t"),
        ("\x85", r"\x85"),
        ("\u2028", r"\u2028"),
        ("\u202e", r"\u202e"),  # turns the reading direction round
        ("\udcff", r"\udcff"),  # a byte that is no UTF-8
    ],
)
def test_control_characters_are_escaped(ride, fails, char, shown):
    name = f"ri{char}[2Jde.csv"
    assert f"ri{shown}[2Jde.csv: no such file" in fails(*angles(ride=name))
    assert shown in fails(*angles(geometry=name))
    assert shown in fails("scooter", f"bo{char}gus")
    fails(*angles(), "--median-window", f"2{char}5")
    if char in "\r\udcff":
        return
    text = (ride / "ride.csv").read_text()
    (ride / "cell.csv").write_text(text.replace("\n0.01,", f"\n0.01{char}[2J,"))
    assert f"'0.01{shown}[2J' is not a number" in fails(*angles("cell.csv"))
    (ride / "head.csv").write_text(text.replace("lever_acc_x", f"lever{char}_acc_x"))
    assert shown in fails(*angles("head.csv"))


def test_cells_are_quoted_in_part(ride, fails):
    text = (ride / "ride.csv").read_text()
    (ride / "cell.csv").write_text(text.replace("\n0.01,", f"\n{1_000_000 * 'x'},"))
    line = fails(*angles("cell.csv"), says=["cell.csv: line 3, column time_s: 'xxxxx"])
    assert "x" * 61 not in line and "..." in line


def test_lists_of_names_are_cut(ride, fails):
    names = ",".join(f"column_{k}" for k in range(500))
    (ride / "velocity.csv").write_text(f"{names}\n{','.join(500 * ['1'])}\n")
    line = fails("wheelchair", "tasks", "velocity.csv", "-o", "t.csv", says=["column_9 and 490"])
    assert "column_10" not in line


def test_a_message_is_never_longer_than_a_page(fails):
    assert len(fails("scooter", "x" * 100_000)) < 1100


def test_without_a_command(fails):
    fails(says=["give a command; --help lists them"])
    fails("scooter", says=["give a command"])


@pytest.mark.parametrize("arguments", [("bogus",), ("scooter", "bogus"), ("--bogus",)])
def test_wrong_arguments(fails, arguments):
    fails(*arguments, says=["No such"])


def test_several_files_that_stand_apart(ride, fails):
    line = fails(*angles("ride.csv"), "b.csv", says=["extra argument", "(b.csv)"])
    assert line.endswith("files of one recording are one name: frame=f.csv,left_wheel=l.csv")


@pytest.mark.parametrize(
    "command",
    [("simulate", "walker", "--seed", 1, "-o", "s"), ("reproduce",), ("fetch", "terrain-chair")],
)
def test_other_arguments_too_many_are_no_files_of_a_recording(fails, command):
    assert "files of one recording" not in fails(*command, "b.csv", says=["extra argument"])


@pytest.mark.parametrize(
    "before", [("--quiet",), ("-q",), (), ("--sampling-rate-hz=100",), ("--",)]
)
def test_an_empty_argument_is_not_the_current_folder(fails, before):
    fails("read", *before, "", says=["an argument is empty; the current folder is '.'"])
    fails("wheelchair", "velocity", "--strict", "", says=["an argument is empty"])


def test_an_empty_value_is_told_by_its_option(ride, fails):
    fails("simulate", "walker", "--seed", 1, "-o", "", says=["the name is empty"])
    fails(*angles(), "--method", "", says=["--method"])


def test_version(works):
    assert works("--version").stdout.startswith("mobility-imu ")


OPTIONS = {
    ("scooter", "angles"): {"--method": "fusion", "--form": "printed"},
    ("scooter", "check"): {"--method": "fusion", "--sensors": "calibrated"},
    ("wheelchair", "velocity"): {"--camber": "sign-safe", "--filter": "savitzky-golay"},
    ("wheelchair", "tasks"): {"--edge": "covering"},
    ("walker", "calibrate"): {"--method": "all-samples", "--form": "corrected"},
    ("simulate", "walker"): {"--course": "timed-up-and-go", "--level": "data-sheet"},
    ("reproduce",): {"--work": "walker"},
}


@pytest.mark.parametrize("command", OPTIONS, ids=" ".join)
def test_a_misspelt_choice_is_refused_with_the_choices(fails, works, command):
    for option, choice in OPTIONS[command].items():
        assert choice in works(*command, "--help").stdout.replace("\n", "")
        fails(*command, option, f"{choice}x", says=[option, f"'{choice}x'", f"'{choice}'"])


def test_choices_are_those_of_the_library():
    from typing import get_args, get_type_hints

    from mobility_imu.cli import scooter, simulate, walker, wheelchair
    from mobility_imu.reproduction.claims import Work
    from mobility_imu.scooter import estimate_angles
    from mobility_imu.simulation import bundle
    from mobility_imu.simulation.scooter import COURSES
    from mobility_imu.walker import calibration
    from mobility_imu.wheelchair import smoothing, tasks

    assert set(get_args(scooter.Form)) == set(scooter.FORMS)
    forms = get_args(get_type_hints(estimate_angles)["form"])
    assert set(scooter.FORMS.values()) == set(forms)
    assert set(get_args(wheelchair.Smoothing)) == set(get_args(smoothing.Smoothing))
    assert set(get_args(wheelchair.Edge)) == set(get_args(tasks.Edge))
    assert set(get_args(walker.Method)) == set(get_args(calibration.Method))
    assert set(get_args(walker.Form)) == set(get_args(calibration.Form))
    assert set(get_args(simulate.ScooterCourse)) == set(COURSES)
    for choices, levels in (
        (simulate.Level, bundle.WALKER_LEVELS),
        (simulate.ScooterLevel, bundle.SCOOTER_SENSORS),
        (simulate.WheelchairLevel, bundle.WHEELCHAIR_LEVELS),
    ):
        assert {level.replace("-", " ") for level in get_args(choices)} == set(levels)
    from mobility_imu.cli.reproduce import Work as Choice

    assert set(get_args(Choice)) == set(get_args(Work))


def test_warnings_are_lines_of_ours(ride, works):
    """A median of another length is told; what numpy or others warn of is not."""
    text = works(*angles(), "--median-window", 101, "--quiet").stderr
    assert text.startswith("mobility-imu: warning: a median of 101 samples is 1.01 s long")
    assert len(text.splitlines()) == 1


@pytest.mark.parametrize("category", [RuntimeWarning, DeprecationWarning, FutureWarning])
def test_warnings_of_others_are_not_shown(ride, works, monkeypatch, category):
    def warn_and_read(*arguments, real=readers.read_recording, **options):
        warnings.warn("overflow encountered in multiply", category, stacklevel=2)
        np.log(-np.ones(1))
        return real(*arguments, **options)

    monkeypatch.setattr(readers, "read_recording", warn_and_read)
    assert works(*angles(), "--quiet").stderr == ""


def test_numpys_warnings_on_huge_readings_are_not_shown(tmp_path, run):
    walk = pd.read_csv(CORRIDOR / "walk.csv.gz")
    walk.loc[3000, "frame_acc_z_mps2"] = 1.7e308
    walk.to_csv(tmp_path / "w.csv", index=False)
    mount = CORRIDOR / "true_mount.toml"
    result = run("walker", "trajectory", "w.csv", "--geometry", mount, "-o", "p.csv")
    assert "encountered" not in result.stderr


def test_after_an_error_no_warning_is_shown(ride, fails):
    fails(*angles(), "--median-window", 301, says=["301"])


def test_the_process_keeps_its_own_warnings(ride, works, fails):
    filters, show = list(warnings.filters), warnings.showwarning
    works(*angles())
    fails(*angles(geometry="none.toml"))
    assert warnings.showwarning is show
    assert warnings.filters == filters


def test_a_terminal_that_lacks_a_character(run, monkeypatch):
    """An ASCII terminal gets codes instead of a traceback."""
    from mobility_imu.reproduction import scorecard

    monkeypatch.setattr(scorecard, "scorecard", lambda *a, **o: [])
    monkeypatch.setattr(scorecard, "print_scorecard", lambda *a, **o: print("1 ± 2 m/s²"))
    out = io.TextIOWrapper(io.BytesIO(), encoding="ascii", errors="strict")
    monkeypatch.setattr(sys, "stdout", out)
    monkeypatch.setattr(sys, "argv", ["mobility-imu", "reproduce"])
    with pytest.raises(SystemExit) as left:
        entry()
    assert left.value.code == 0
    out.flush()
    assert out.buffer.getvalue() == rb"1 \xb1 2 m/s\xb2" + b"\n"


class FullStream(io.TextIOBase):
    """Standard output of which nothing can be written."""

    def __init__(self, error):
        self.error = error

    def write(self, text):
        raise self.error

    def flush(self):
        raise self.error


@pytest.mark.parametrize("arguments", [["--version"], ["--help"], ["scooter", "angles", "--help"]])
def test_a_full_disk_behind_standard_output(monkeypatch, capsys, arguments):
    monkeypatch.setattr(sys, "stdout", FullStream(OSError(28, "No space left on device")))
    monkeypatch.setattr(sys, "argv", ["mobility-imu", *arguments])
    with pytest.raises(SystemExit) as left:
        entry()
    assert left.value.code == 2
    assert capsys.readouterr().err == (
        "mobility-imu: standard output: cannot be written (No space left on device)\n"
    )


def test_nobody_reads_the_output_any_more(monkeypatch, capsys):
    """``mobility-imu --help | head -1``: no message."""
    monkeypatch.setattr(sys, "stdout", FullStream(BrokenPipeError(32, "Broken pipe")))
    monkeypatch.setattr(sys, "argv", ["mobility-imu", "--version"])
    with pytest.raises(SystemExit) as left:
        entry()
    assert left.value.code == 0
    assert capsys.readouterr().err == ""


def test_interrupts(ride, run, monkeypatch):
    def interrupted(*arguments, **options):
        raise KeyboardInterrupt

    monkeypatch.setattr(readers, "read_recording", interrupted)
    result = run(*angles())
    assert (result.returncode, result.stderr) == (130, "mobility-imu: interrupted\n")


@pytest.fixture
def process(monkeypatch, capfd):
    """Run the entry point of a process; returns how it ends and what it says."""
    import mobility_imu.__main__ as module

    def leave(code):
        raise SystemExit(code)

    monkeypatch.setattr(os, "_exit", leave)
    monkeypatch.setattr(signal, "signal", lambda *a: None)
    monkeypatch.setattr(sys, "unraisablehook", sys.unraisablehook)

    def process():
        with pytest.raises(SystemExit) as left:
            module.main()
        return left.value.code, capfd.readouterr().err

    return process


def test_an_interrupt_while_the_command_line_is_loaded(process, monkeypatch):
    """Ctrl-C in the first tenths of a second: code 130 and one line, no traceback."""
    real = builtins.__import__

    def interrupted(name, *arguments, **options):
        if name.startswith("mobility_imu.cli"):
            raise KeyboardInterrupt
        return real(name, *arguments, **options)

    monkeypatch.setattr(builtins, "__import__", interrupted)
    assert process() == (130, "mobility-imu: interrupted\n")


def test_an_interrupt_that_python_drops_comes_again(hears_interrupts, process, monkeypatch):
    """An interrupt in a callback of the import system is reported to a hook, and goes on."""

    class Dropped:
        def __del__(self):
            raise KeyboardInterrupt

    def read(*arguments, **options):
        Dropped()
        time.sleep(5)
        raise AssertionError("the interrupt was lost")

    monkeypatch.setattr(readers, "read_recording", read)
    monkeypatch.setattr(sys, "argv", ["mobility-imu", "wheelchair", "check"])
    sys.argv += map(str, velocity()[2:-2])
    assert process() == (130, "mobility-imu: interrupted\n")


def test_numbers_that_break_a_computation_are_one_line(ride, fails, monkeypatch):
    def not_finite():
        linalg.inv(np.full((2, 2), np.inf))

    for cause, says in (
        (lambda: 1 / 0, "division by zero"),
        (lambda: np.linalg.inv(np.zeros((2, 2))), "Singular matrix"),
        (lambda: round(np.inf * 2), "infinity"),
        (not_finite, "infs or NaNs"),
    ):
        monkeypatch.setattr(readers, "read_recording", lambda *a, cause=cause, **o: cause())
        fails(*angles(), says=["the computation breaks down", says])


def test_faults_of_the_program_are_not_hidden(tmp_path, run, monkeypatch):
    """An error that no input explains keeps its traceback, so that it can be reported."""
    velocity_csv(tmp_path / "v.csv")
    from mobility_imu.readers import velocities

    for mistake in (AttributeError, ValueError, KeyError):

        def broken(*arguments, mistake=mistake, **options):
            raise mistake("of ours")

        monkeypatch.setattr(velocities, "read_velocities", broken)
        with pytest.raises(mistake):
            run("wheelchair", "tasks", "v.csv", "-o", "t.csv")
