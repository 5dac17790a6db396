"""The application, its entry point, and how it ends: messages in one line, and exit codes."""

from __future__ import annotations

import errno
import logging
import os
import sys
import traceback
import warnings
from collections import Counter
from collections.abc import Iterable, Iterator
from contextlib import suppress
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, get_args, get_type_hints

import typer

from mobility_imu import __version__
from mobility_imu.cli.fetch import fetch
from mobility_imu.cli.messages import say, warn
from mobility_imu.cli.read import read
from mobility_imu.cli.reproduce import reproduce
from mobility_imu.cli.scooter import app as scooter_app
from mobility_imu.cli.simulate import app as simulate_app
from mobility_imu.cli.typed import given_options, no_number, wrong_dash
from mobility_imu.cli.walker import app as walker_app
from mobility_imu.cli.wheelchair import app as wheelchair_app
from mobility_imu.errors import MobilityImuError, missing_extra

DONE, AT_FAULT, INTERRUPTED = 0, 2, 130
PACKAGE = Path(__file__).resolve().parents[1]

app = typer.Typer(
    name="mobility-imu",
    help="Angles, tasks and paths of mobility aids from inertial sensors (IMUs).",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
app.add_typer(scooter_app, name="scooter")
app.add_typer(wheelchair_app, name="wheelchair")
app.add_typer(walker_app, name="walker")
app.add_typer(simulate_app, name="simulate")
app.command("reproduce")(reproduce)
app.command("fetch")(fetch)
app.command("read")(read)


def _version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"mobility-imu {__version__}")
        raise typer.Exit


@app.callback()
def common(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version.")
    ] = False,
) -> None:
    """Angles, tasks and paths of mobility aids from inertial sensors (IMUs)."""


def main() -> None:
    """Run the command line; leaves with exit code 0, 2 or 130."""
    stdout, stderr = sys.stdout, sys.stderr
    for stream in (stdout, stderr):
        with suppress(AttributeError, ValueError):
            # A terminal that lacks a character shows its code instead.
            stream.reconfigure(errors="backslashreplace")  # type: ignore[union-attr]
    # Other libraries log what is not for users, such as a cache that cannot be kept.
    silent = logging.NullHandler()
    logging.getLogger().addHandler(silent)
    # Collected: when a command fails, its error is the only line.
    with warnings.catch_warnings(record=True) as heard:
        warnings.simplefilter("always")
        log, steps = logging.getLogger("mobility_imu"), _Steps(logging.INFO)
        log.addHandler(steps)
        log.setLevel(logging.INFO)
        try:
            code, message = _run()
        finally:
            log.removeHandler(steps)
            logging.getLogger().removeHandler(silent)
            sys.stdout, sys.stderr = stdout, stderr  # the application may wrap them
    if code == DONE:
        for warning in _own(heard):
            say(f"warning: {warning}")
    else:
        say(message)
    sys.exit(code)


def _run() -> tuple[int, str]:
    """Run the application; returns the exit code and, unless that is 0, the message."""
    valued = _options_with_values()
    pairs = _paired_flags()
    message = _of_slips(valued)
    if message is not None:
        return AT_FAULT, message
    flags = {name for pair in pairs for name in pair}
    given = Counter(name for name, _ in given_options(sys.argv[1:], valued, flags))
    warn(
        f"{name} is given {given[name]} times; the last one counts"
        for name in dict.fromkeys(valued.values())
        if given[name] > 1
    )
    warn(
        f"{one} and {other} are both given; the last one counts"
        for one, other in sorted(pairs)
        if given[one] and given[other]
    )
    try:
        code = _command()(standalone_mode=False)
        if sys.stdout is not None:
            sys.stdout.flush()
    except MobilityImuError as error:
        return AT_FAULT, str(error)
    except ModuleNotFoundError as error:
        missing = missing_extra(error) or _of_loading(error)
        if missing is None:
            raise
        return AT_FAULT, str(missing)
    except (KeyboardInterrupt, typer.Abort):
        code = INTERRUPTED
    except MemoryError:
        return AT_FAULT, "the input needs more memory than there is"
    except SystemExit:  # how the application leaves when nobody reads its output any more
        _drop_stdout()
        return DONE, ""
    except OSError as error:
        message = _of_loading(error)
        return _failed_stream(error) if message is None else (AT_FAULT, message)
    except Exception as error:
        if _is_interrupted(error):
            return INTERRUPTED, "interrupted"
        message = _of_arguments(error) or _of_loading(error) or _of_arithmetic(error)
        if message is None:
            raise
        return AT_FAULT, message
    if code == INTERRUPTED:
        return INTERRUPTED, "interrupted"
    return (code if isinstance(code, int) else DONE), ""


def _of_slips(valued: dict[str, str]) -> str | None:
    """Message for what would be taken for something else than was meant, None if there is none."""
    # As a path an empty value would be the current folder; others are checked by their options.
    for before, here in pairwise(sys.argv):
        name = before if not here else here[:-1] if here.endswith("=") else ""
        if name in valued and Path in _taken()[name]:
            return f"{valued[name]}: the name is empty; the current folder is '.'"
        if name not in valued and not here:
            return "an argument is empty; the current folder is '.'"
    chosen = _chosen(sys.argv[1:])
    names = {name for command in chosen for option in command.params for name in _all(option)}
    names.add("--help")
    numbers = {name for name in valued.values() if _taken()[name] & {int, float}}
    return wrong_dash(sys.argv[1:], valued, names) or no_number(sys.argv[1:], valued, numbers)


def _chosen(words: list[str]) -> list[Any]:
    """The command that a command line names, with the groups that it is in."""
    found = [_command()]
    for word in words:
        inner = getattr(found[-1], "commands", {}).get(word)
        if inner is not None:
            found.append(inner)
    return found


def _all(option: Any) -> Iterator[str]:
    """Names of an option; an argument has none."""
    yield from (name for name in (*option.opts, *option.secondary_opts) if name.startswith("-"))


@cache
def _command() -> Any:
    """All commands; building them takes longer than running a short one."""
    return typer.main.get_command(app)


def _commands() -> Iterator[Any]:
    """All commands, and groups of them."""
    commands = [_command()]
    while commands:
        command = commands.pop()
        commands += getattr(command, "commands", {}).values()
        yield command


def _options_with_values() -> dict[str, str]:
    """Names of the options, of all commands, behind which a value stands, with the longest name."""
    names: dict[str, str] = {}
    for command in _commands():
        # An argument has no such flag.
        valued = [option for option in command.params if not getattr(option, "is_flag", True)]
        names.update((name, max(option.opts, key=len)) for option in valued for name in option.opts)
    return names


def _paired_flags() -> set[tuple[str, str]]:
    """Flags of all commands that say yes and no to one thing, such as --smooth and --no-smooth."""
    return {
        (option.opts[0], option.secondary_opts[0])
        for command in _commands()
        for option in command.params
        if getattr(option, "secondary_opts", ())
    }


@cache
def _taken() -> dict[str, set[type]]:
    """Types of the values that options of each name take, in any command."""
    found: dict[str, set[type]] = {}
    for command in _commands():
        hints = get_type_hints(command.callback) if command.callback else {}
        for option in (option for option in command.params if option.name in hints):
            kind = hints[option.name]
            for name in option.opts:
                found.setdefault(name, set()).update((kind, *get_args(kind)))
    return found


def _of_arguments(error: Exception) -> str | None:
    """Message of the application's own errors on arguments, None for another error."""
    if not (hasattr(error, "format_message") and hasattr(error, "exit_code")):
        return None
    if type(error).__name__ == "NoArgsIsHelpError":  # its message is the whole help
        return "give a command; --help lists them"
    command = getattr(getattr(error, "ctx", None), "command", None)
    options = getattr(command, "params", ())
    if type(error).__name__ == "NoSuchOption":
        known = {name for option in options for name in option.opts}
        for argument in sys.argv[1:]:
            if argument[:1] == "-" and argument not in known and os.path.exists(argument):
                return f"{argument}: begins with a dash, as options do; write ./{argument}"
    # What checks the values begins some messages with words of its own.
    message = str(error.format_message()).replace(": Value error, ", ": ")
    # What looks at sensors reads a recording, which may be in several files.
    of_recordings = any(option.name == "strict" for option in options)
    if of_recordings and message.startswith("Got unexpected extra argument"):
        message += "; several files of one recording are one name: frame=f.csv,left_wheel=l.csv"
    return message


def _is_interrupted(error: BaseException | None) -> bool:
    """Whether an interrupt is behind an error, as of a library that was being loaded."""
    while error is not None and not isinstance(error, KeyboardInterrupt):
        error = error.__cause__ or error.__context__
    return error is not None


def _of_loading(error: Exception) -> str | None:
    """Message for a library that is there and cannot be loaded, None for another error."""
    frames = [frame for frame, _ in traceback.walk_tb(error.__traceback__)]
    names = [str(frame.f_globals.get("__name__", "")).partition(".")[0] for frame in frames]
    last = max(
        (k for k, name in enumerate(names) if name == __package__.partition(".")[0]), default=-1
    )
    # What runs first behind our own line is the library, if that line imports one.
    passed = {"importlib", "scipy.__getattr__"}  # SciPy imports its parts when they are asked for
    behind = [
        k
        for k in range(last + 1, len(frames))
        if not passed & {names[k], f"{names[k]}.{frames[k].f_code.co_name}"}
    ]
    if not behind or frames[behind[0]].f_code.co_name != "<module>":
        return None
    library = names[behind[0]]
    why = next(
        (line.strip() for line in str(error).splitlines() if line.strip()), "no reason given"
    )
    do = "; MOBILITY_IMU_NO_NUMBA=1 does without it" if library == "numba" else ""
    return f"{library} cannot be loaded ({why}); mend it, or what the environment tells it{do}"


def _of_arithmetic(error: Exception) -> str | None:
    """Message for a computation that broke down on the numbers it got, None for another error."""
    *_, last = traceback.walk_tb(error.__traceback__)
    library = last[0].f_globals.get("__name__", "").partition(".")[0]
    names = {cause.__name__ for cause in type(error).__mro__}
    refused = "ValueError" in names and library in ("numpy", "scipy")
    if not refused and not names & {"ArithmeticError", "LinAlgError"}:
        return None
    return (
        f"the computation breaks down on these numbers ({error}); look for readings that no "
        "sensor gives, and for a clock in another unit than s"
    )


def _failed_stream(error: OSError) -> tuple[int, str]:
    """Exit code and message when standard output cannot be written."""
    _drop_stdout()
    if error.errno == errno.EPIPE:
        return DONE, ""
    why = error.strerror or error
    if error.filename:
        return AT_FAULT, f"{error.filename}: cannot be read or written ({why})"
    return AT_FAULT, f"standard output: cannot be written ({why})"


def _drop_stdout() -> None:
    """Discard buffered output, so that the interpreter does not fail on it when it ends."""
    stream = getattr(sys.stdout, "wrapped", sys.stdout)  # the application wraps a closed pipe
    if sys.__stdout__ is None or stream is not sys.__stdout__:
        return
    with suppress(OSError, ValueError):
        number = sys.__stdout__.fileno()
        nothing = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nothing, number)
        os.close(nothing)


def _own(heard: Iterable[warnings.WarningMessage]) -> list[str]:
    """Texts of this package's own warnings, each once; numpy's and others' are not for users."""
    texts = [
        str(warning.message)
        for warning in heard
        if warning.category is UserWarning and PACKAGE in Path(warning.filename).parents
    ]
    return list(dict.fromkeys(texts))


class _Steps(logging.Handler):
    """Handler that prints what takes long, such as compiling, before it begins."""

    def emit(self, record: logging.LogRecord) -> None:
        """Print one record."""
        say(record.getMessage())
