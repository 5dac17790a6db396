"""Every option of every command with an odd value: an answer or one line, never a traceback."""

import os

import numpy as np
import pytest
import typer
from command_lines import COMMANDS, contents, name_of

from mobility_imu.cli.main import _paired_flags, app

COUNT = int(os.environ.get("MOBILITY_IMU_MUTATIONS", "200")) // 2
VALUES = (
    *(
        "",
        " ",
        "-",
        "--",
        "-1",
        "0",
        "1",
        "2",
        "1.5",
        "1e3",
        "1e308",
        "nan",
        "inf",
        "-inf",
        "1e-320",
    ),
    *("9" * 30, "9" * 400, "9" * 5000, "0x10", "1_0", "١", "true", "none", "a,b", ",", "[1]"),
    *("none/none", "n" * 300, "~", "a\x1b[2Jb", "\udcff", "\u202e", "a\nb", "*"),
    *("f.svg", "o.csv.gz", ".png", "o.PNG"),
)
THERE = (".", "..", "/", "ride.csv", "g.toml", "settings.json", "court.csv.gz", "frame.toml")
OUTPUTS = ("--output", "-o", "--events", "--figure", "--steps")
CHECK = "court.csv.gz --static static.csv.gz --straight straight.csv.gz --geometry chair.toml"
LINES = {
    **{name: [*arguments] for name, (arguments, _, _) in COMMANDS.items()},
    "wheelchair check": CHECK.split(),
    **{f"simulate {device}": ["--seed", "1"] for device in ("scooter", "wheelchair", "walker")},
}


def parameters():
    """Each command with each of its parameters: (command, option or None for an argument)."""
    for group, commands in typer.main.get_command(app).commands.items():
        for name, command in getattr(commands, "commands", {}).items():
            for parameter in command.params:
                if "--help" not in parameter.opts:
                    option = next((o for o in parameter.opts if o.startswith("-")), None)
                    yield f"{group} {name}", option


PARAMETERS = list(parameters())


def test_every_command_is_tried():
    assert {name for name, _ in PARAMETERS} == set(LINES)
    assert len(PARAMETERS) > 50


@pytest.mark.parametrize("seed", range(COUNT))
def test_odd_values_end_in_an_answer_or_one_line(seed, room, run):
    rng = np.random.default_rng([7, seed])
    name, option = PARAMETERS[seed % len(PARAMETERS)]
    # Outputs get new names only: a folder or file that is there may be written, rightly.
    values = VALUES if option in OUTPUTS else (*VALUES, *THERE)
    value = values[rng.integers(len(values))]
    line = [*name.split(), *LINES[name]]
    if "check" not in name:
        line += ["-o", name_of(name, "-o")]
    if option is None:
        line[2] = value
    elif option in line:
        line[line.index(option) + 1] = value
    else:
        line += [option, value]
    if rng.random() < 0.3:
        line += ["--method", "fusion"]
    before = contents(room)
    result = run(*line)
    after = contents(room)
    assert all(after.get(path) == content for path, content in before.items())
    assert result.stderr.replace("\n", "").isprintable()
    if result.returncode == 0:
        assert (len(after) > len(before)) == (name != "wheelchair check")
    else:
        assert result.returncode == 2, result
        assert after == before
        assert len(result.stderr.splitlines()) == 1 and result.stdout == "", result


@pytest.mark.parametrize(
    ("line", "names"),
    [
        (["walker", "calibrate", "--form", "printed"], ["--form has no effect with --method all-"]),
        (
            ["wheelchair", "velocity", "--filter-window", "9", "--filter-order", "3"],
            [
                "--filter-window has no effect with --filter none",
                "--filter-order has no effect with --filter none",
            ],
        ),
        (
            [*"wheelchair velocity --filter moving-average --filter-order 3".split()],
            ["--filter-order has no effect with --filter moving-average"],
        ),
        (["walker", "calibrate", *"--form printed --method two-tilts".split()], []),
        (["wheelchair", "velocity", *"--filter savitzky-golay --filter-order 3".split()], []),
    ],
)
def test_options_without_effect_are_told(line, names, room, works):
    command = " ".join(line[:2])
    error = works(*line[:2], *LINES[command], *line[2:], "-o", name_of(command, "-o")).stderr
    assert error.count("has no effect") == len(names)
    for name in names:
        assert f"warning: {name}" in error


@pytest.mark.parametrize(
    "twice",
    [
        ["-o", "a.csv", "-o", "b.csv"],
        ["--output", "a.csv", "-o", "b.csv"],
        ["--output=a.csv", "--output=b.csv"],
        ["-oa.csv", "-qo", "b.csv"],
    ],
    ids=lambda twice: " ".join(twice),
)
def test_an_option_that_is_given_twice_is_told(twice, room, works):
    """The last one counts, as in other programs; what the first one named is not written."""
    result = works("scooter", "angles", *LINES["scooter angles"], *twice)
    assert "warning: --output is given 2 times; the last one counts" in result.stderr
    assert (room / "b.csv").exists() and not (room / "a.csv").exists()


def test_flags_that_say_yes_and_no_are_told(room, works):
    yes, no = "--slip-correction", "--no-slip-correction"
    line = ["wheelchair", "velocity", *LINES["wheelchair velocity"], "-o", "out"]
    says = f"warning: {yes} and {no} are both given; the last one counts"
    assert says in works(*line, no, yes).stderr
    assert "are both given" not in works(*line[:-1], no, yes).stderr  # a file of this name
    assert _paired_flags() >= {(yes, no), ("--smooth", "--no-smooth")}


def test_a_value_that_looks_like_an_option_is_not_counted(room, works):
    result = works("scooter", "angles", *LINES["scooter angles"], "-o", "-o", "-q")
    assert result.stderr == ""
    assert (room / "-o").exists()


def test_messages_name_no_part_of_the_program(fails):
    """What checks the arguments puts its own words before some messages."""
    assert fails("fetch", "nothing", says=["'nothing' is not one of"]).count("error") == 0
