"""An output replaces neither an input nor anything but a regular file; several are all or none."""

import functools
import inspect
import os
import socket
import stat
from pathlib import Path
from types import UnionType
from typing import get_args, get_origin, get_type_hints

import pytest
from command_lines import COMMANDS, MOUNTS, NAMES, name_of

from mobility_imu import files
from mobility_imu.cli.main import app
from mobility_imu.errors import InputError
from mobility_imu.files import Outputs


def command_line(command, **outputs):
    """Command line with all its outputs, some of them under another name."""
    arguments, _, options = COMMANDS[command]
    named = {option: outputs.get(option.strip("-"), name_of(command, option)) for option in options}
    return [*command.split(), *arguments, *(part for pair in named.items() for part in pair)]


def paths_of(function):
    """Names of a command's parameters that are paths."""

    def is_path(hint):
        if get_origin(hint) in (UnionType, list):
            return any(is_path(part) for part in get_args(hint))
        return hint is Path

    hints = get_type_hints(function)
    return {name for name in inspect.signature(function).parameters if is_path(hints[name])}


def test_every_command_with_files_is_tried_here():
    """A new command, input or output of one has to come into the table above."""
    for group in app.registered_groups:
        for command in group.typer_instance.registered_commands:
            name = f"{group.name} {command.name}"
            paths = paths_of(command.callback)
            if group.name == "simulate":
                assert paths == {"output"}
            elif "output" in paths:
                _, inputs, options = COMMANDS[name]
                assert len(paths) == len(inputs) + len(options), name


CASES = [
    (command, option, name)
    for command, (_, inputs, options) in COMMANDS.items()
    for option in options
    for name in inputs
]


@pytest.mark.parametrize("as_what", ["itself", "dotted", "symlink", "hard link", "linked folder"])
@pytest.mark.parametrize(("command", "option", "name"), CASES)
def test_no_output_replaces_an_input(room, fails, command, option, name, as_what):
    suffix = ".svg" if option == "--figure" else ""
    if suffix:  # a picture's name is asked for: let the input have it
        os.link(room / name, room / f"{name}{suffix}")
    target = f"{name}{suffix}"
    path = {
        "itself": target,
        "dotted": f"../{room.name}/./{target}",
        "symlink": f"link{suffix}",
        "hard link": f"twin{suffix}",
        "linked folder": f"elsewhere/{target}",
    }[as_what]
    if as_what == "symlink":
        os.symlink(target, room / path)
    elif as_what == "hard link":
        os.link(room / target, room / path)
    elif as_what == "linked folder":
        os.symlink(room, room / "elsewhere", target_is_directory=True)
    says = [Path(path).name, "is an input"]
    fails(*command_line(command, **{option.strip("-"): path}), says=says)


OPTIONS = [(command, option) for command, (_, _, options) in COMMANDS.items() for option in options]


@pytest.mark.parametrize(("command", "option"), OPTIONS)
def test_no_output_goes_to_standard_output(room, fails, command, option):
    """By a hyphen, which is no name."""
    says = [option, "ends in .png" if option == "--figure" else "'-' is no file"]
    fails(*command_line(command, **{option.strip("-"): "-"}), says=says)


@pytest.mark.parametrize("device", ["scooter", "wheelchair", "walker"])
def test_no_simulation_goes_to_standard_output(tmp_path, fails, device):
    fails("simulate", device, "--seed", 1, "-o", "-", says=["'-' is no file", "./-"])


@pytest.mark.parametrize("name", ["a.csv.gz", "a.CSV.GZ", "a.Csv.Gz", "a.csv", "a.GZIP"])
def test_a_table_is_packed_if_its_name_says_so(room, works, name):
    works(*command_line("scooter angles", o=name))
    packed = (room / name).read_bytes().startswith(b"\x1f\x8b")
    assert packed == name.lower().endswith(".gz")


def test_a_pictures_name_may_end_in_capitals(room, works):
    works(*command_line("wheelchair tasks", figure="f.PNG", events="e.CSV.GZ"))
    assert (room / "f.PNG").read_bytes().startswith(b"\x89PNG")
    assert (room / "e.CSV.GZ").read_bytes().startswith(b"\x1f\x8b")


def test_a_file_may_be_called_like_standard_output(room, works):
    works(*command_line("scooter angles", o="./-"))
    assert (room / "-").is_file()


def test_no_output_replaces_one_file_of_an_xsens_export(room, fails):
    (room / "Trial-frame.txt").write_text("PacketCounter\tAcc_X\n1\t2\n")
    line = ["walker", "trajectory", "Trial", "--geometry", "frame.toml", "-o", "Trial-frame.txt"]
    fails(*line, says=["Trial-frame.txt", "is an input"])


@pytest.mark.parametrize("name", ["log.csv", "twin.csv", "/dev/fd/{}", "/dev/fd/../fd/{}"])
def test_no_output_replaces_a_file_that_a_stream_goes_to(room, fails, name):
    """``-o log >> log``, or ``-o /dev/stdout >> log``: the log stays."""
    (room / "log.csv").write_text("what was there before")
    os.link(room / "log.csv", room / "twin.csv")
    with open(room / "log.csv", "a") as log:
        line = command_line("scooter angles", o=name.format(log.fileno()))
        fails(*line, says=["has open", "choose another name"])


TWO = [
    (command, one, other)
    for command, (_, _, options) in COMMANDS.items()
    for k, one in enumerate(options)
    for other in options[k + 1 :]
]


@pytest.mark.parametrize("there", ["new", "there", "linked", "in capitals"])
@pytest.mark.parametrize(("command", "one", "other"), TWO)
def test_two_outputs_are_never_one_file(room, fails, command, one, other, there):
    names = ("same.svg", "./same.svg")
    if there == "there":
        (room / "same.svg").write_text("old")
    elif there == "linked":
        (room / "same.svg").write_text("old")
        os.link(room / "same.svg", room / "twin.svg")
        names = ("same.svg", "twin.svg")
    elif there == "in capitals":
        names = ("same.svg", "SAME.svg")
    outputs = {one.strip("-"): names[0], other.strip("-"): names[1]}
    fails(*command_line(command, **outputs), says=["the same file as"])


def special(room, kind):
    """Something that is no regular file, under the name ``special.svg``."""
    path = room / "special.svg"
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "folder":
        path.mkdir()
    elif kind == "socket":
        with socket.socket(socket.AF_UNIX) as server:
            server.bind(str(path))
    elif kind == "dangling link":
        path.symlink_to("nowhere")
    elif kind == "link to itself":
        path.symlink_to("special.svg")
    else:
        target = {"link to a pipe": "p", "link to a folder": "d", "link to a device": os.devnull}
        os.mkfifo(room / "p")
        (room / "d").mkdir()
        path.symlink_to(target[kind])
    return path.name


KINDS = ("pipe", "folder", "socket", "dangling link", "link to itself", "link to a pipe")
KINDS += ("link to a folder", "link to a device")


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("option", [(c, o) for c, (_, _, os_) in COMMANDS.items() for o in os_])
def test_only_regular_files_are_written(room, fails, monkeypatch, kind, option):
    """Refused with one line, before any recording is read."""
    for reader in ("recordings.read_recording", "velocities.read_velocities"):
        monkeypatch.setattr(f"mobility_imu.readers.{reader}", must_not_be_called)
    monkeypatch.setattr("mobility_imu.readers.read_recording", must_not_be_called)
    name = special(room, kind)
    before = (room / name).lstat()
    fails(*command_line(option[0], **{option[1].strip("-"): name}), says=["special.svg"])
    after = (room / name).lstat()
    assert (before.st_ino, before.st_mode) == (after.st_ino, after.st_mode)


def must_not_be_called(*arguments, **options):
    raise AssertionError("a recording was read before the outputs were checked")


def test_a_link_to_a_file_is_written_through(room, works):
    (room / "deep").mkdir()
    (room / "deep" / "real.csv").write_text("old")
    (room / "link.csv").symlink_to("deep/real.csv")
    works(*command_line("scooter angles", o="link.csv"))
    assert (room / "link.csv").is_symlink()
    assert (room / "deep" / "real.csv").read_text().startswith("time_s")
    assert [p.name for p in (room / "deep").iterdir()] == ["real.csv"]


def mode_of(path):
    return stat.S_IMODE(path.stat().st_mode)


@pytest.fixture(params=[0o077, 0o002], ids=oct)
def mask(request):
    old = os.umask(request.param)
    yield request.param
    os.umask(old)


DEVICES = ("scooter", "wheelchair", "walker")


@functools.cache
def beginning(device):
    """The first ten rows of the tables that a simulation writes, and its texts."""
    from mobility_imu.simulation import bundle

    contents = getattr(bundle, f"{device}_bundle")(1)
    return {k: v if isinstance(v, str) else v.head(10) for k, v in contents.items()}


@pytest.fixture
def short():
    """Simulations write a few rows: where they go is tried, not what they hold."""
    contents = {device: beginning(device) for device in DEVICES}
    with pytest.MonkeyPatch.context() as patch:
        for device in DEVICES:
            name = f"mobility_imu.simulation.bundle.{device}_bundle"
            patch.setattr(name, lambda *_, d=device, **__: contents[d])
        yield


@pytest.mark.usefixtures("short", "plain")
def test_new_files_have_the_users_mask(room, works, mask):
    works(*command_line("wheelchair tasks"))
    works("simulate", "wheelchair", "--seed", 1, "-o", "sim")
    made = [room / "out.csv", room / "e.csv", room / "f.svg", *(room / "sim").iterdir()]
    assert len(made) == 8
    for path in made:
        assert mode_of(path) == 0o666 & ~mask
    assert mode_of(room / "sim") == 0o777 & ~mask


@pytest.mark.parametrize("mode", [0o600, 0o640, 0o644, 0o664, 0o777])
def test_a_file_keeps_its_mode(room, works, mode):
    (room / "out.csv").write_text("old")
    (room / "out.csv").chmod(mode)
    works(*command_line("scooter angles"))
    assert mode_of(room / "out.csv") == mode
    assert (room / "out.csv").read_text().startswith("time_s")


@pytest.mark.parametrize("suffix", [".csv", ".csv.gz"])
def test_the_longest_name_that_is_allowed(room, works, fails, suffix):
    longest = os.pathconf(room, "PC_NAME_MAX")
    name = "n" * (longest - len(suffix)) + suffix
    works(*command_line("scooter angles", o=name))
    assert (room / name).stat().st_size > 1000
    (room / name).unlink()
    fails(*command_line("scooter angles", o=f"n{name}"), says=["cannot be written"])
    fails("simulate", "walker", "--seed", 1, "-o", f"n{name}", says=["cannot be written"])


# What happens when writing fails.


class Full(OSError):
    """No space left on device."""

    def __init__(self):
        super().__init__(28, "No space left on device")


@pytest.fixture(params=[1, 2, 3], ids=["first", "second", "third"])
def nth(request):
    return request.param


@pytest.mark.usefixtures("plain")
@pytest.mark.parametrize("call", ["fsync", "replace"])
@pytest.mark.parametrize("old", [True, False], ids=["old files there", "new names"])
def test_of_several_outputs_all_are_written_or_none(room, fails, monkeypatch, nth, call, old):
    names = list(NAMES.values())
    if old:
        for name in names:
            (room / name).write_text(f"old {name}")
            (room / name).chmod(0o600)
    break_at(monkeypatch, call, nth)
    fails(*command_line("wheelchair tasks"), says=["No space left on device"])
    if old:
        assert all(mode_of(room / name) == 0o600 for name in names)


def break_at(monkeypatch, call, nth, error=None):
    """Let the nth call of a function of the system fail, within the module of outputs."""
    real, calls = getattr(os, call), []

    def failing(*arguments, **options):
        calls.append(arguments)
        if len(calls) == nth:
            raise error or Full()
        return real(*arguments, **options)

    monkeypatch.setattr(files.os, call, failing)


@pytest.mark.usefixtures("plain")
def test_of_several_outputs_without_hard_links(room, fails, monkeypatch):
    """Old files are kept as copies where the file system has no hard links."""
    for name in NAMES.values():
        (room / name).write_text(f"old {name}")
    monkeypatch.setattr(files.os, "link", lambda *a: (_ for _ in ()).throw(OSError(1, "no links")))
    break_at(monkeypatch, "replace", 3)
    fails(*command_line("wheelchair tasks"), says=["No space left"])


@pytest.mark.usefixtures("plain")
def test_an_interrupt_leaves_nothing(room, run, monkeypatch):
    before = sorted(room.rglob("*"))
    break_at(monkeypatch, "replace", 2, KeyboardInterrupt())
    result = run(*command_line("wheelchair tasks"))
    assert result.returncode == 130
    assert result.stderr == "mobility-imu: interrupted\n"
    assert sorted(room.rglob("*")) == before


@pytest.mark.usefixtures("short")
@pytest.mark.parametrize("device", DEVICES)
def test_a_failed_simulation_leaves_nothing(tmp_path, fails, monkeypatch, device):
    line = ["simulate", device, "--seed", 1, "-o"]
    break_at(monkeypatch, "replace", 2)
    fails(*line, "new/er", says=["No space left on device"])
    monkeypatch.undo()
    monkeypatch.chdir(tmp_path)
    (tmp_path / "there").mkdir()
    (tmp_path / "there" / "geometry.toml").write_text("old")
    break_at(monkeypatch, "fsync", 2)
    fails(*line, "there", says=["No space left on device"])


@pytest.mark.parametrize("name", ["geometry.toml", "truth.csv.gz"])
@pytest.mark.parametrize("device", ["scooter", "wheelchair", "walker"])
def test_a_simulation_writes_regular_files_only(tmp_path, fails, device, name):
    (tmp_path / "there").mkdir()
    os.mkfifo(tmp_path / "there" / name)
    fails("simulate", device, "--seed", 1, "-o", "there", says=[name, "is a pipe"])


@pytest.mark.parametrize("kind", ["pipe", "dangling link", "link to itself", "link to a device"])
@pytest.mark.parametrize("device", ["scooter", "wheelchair", "walker"])
def test_a_simulation_needs_a_folder(tmp_path, fails, device, kind):
    fails("simulate", device, "--seed", 1, "-o", special(tmp_path, kind), says=["special.svg"])
    (tmp_path / "file").write_text("mine")
    line = ["simulate", device, "--seed", 1, "-o"]
    fails(*line, "file", says=["file", "expected a folder"])
    fails(*line, "file/below", says=["file"])


@pytest.mark.parametrize("where", ["none/a.csv", "ride.csv/a.csv", "a.csv/", ""])
def test_folders_that_are_none(room, fails, where):
    (room / "a.csv").mkdir()
    fails(*command_line("scooter angles", o=where), says=[": "])


# Without a user's rights these cannot be seen: a superuser may write everywhere.


@pytest.mark.skipif(
    os.geteuid() == 0 and "RIGHTS_GIVEN_UP" not in os.environ,
    reason="a superuser may do everything; test_rights.py runs it without that",
)
class TestRights:
    def test_read_only_file(self, room, fails):
        (room / "out.csv").write_text("precious")
        (room / "out.csv").chmod(0o444)
        fails(*command_line("scooter angles"), says=["out.csv", "cannot be written"])

    def test_read_only_folder(self, room, fails):
        (room / "closed").mkdir(mode=0o555)
        fails(*command_line("scooter angles", o="closed/a.csv"), says=["cannot be written"])
        fails("simulate", "walker", "--seed", 1, "-o", "closed/new", says=["cannot be made"])


def test_rights_are_asked_for_before_the_work(room, fails, monkeypatch):
    monkeypatch.setattr("mobility_imu.readers.read_recording", must_not_be_called)
    monkeypatch.setattr(files.os, "access", lambda path, mode: not mode & os.W_OK)
    fails(*command_line("scooter angles"), says=["out.csv", "read-only"])
    fails("simulate", "walker", "--seed", 1, "-o", "new", says=["new", "read-only"])


def test_a_name_that_changed_while_the_command_worked_is_checked_again(room):
    outputs = Outputs({"--output": room / "late.csv"})
    os.mkfifo(room / "late.csv")
    with pytest.raises(InputError, match=r"late\.csv: is a pipe"):
        outputs.write({room / "late.csv": b"1"})
    assert stat.S_ISFIFO((room / "late.csv").lstat().st_mode)


def test_outputs_replace_files_whole(room, fails):
    """An old output stays as it was when the new run fails."""
    (room / "a.csv").write_text("old")
    fails("scooter", "angles", "ride.csv", "--geometry", "none.toml", "-o", "a.csv", says=["none"])
    assert (room / "a.csv").read_text() == "old"


def test_a_file_system_that_cannot_be_told_to_write_down(room, works, monkeypatch):
    break_at(monkeypatch, "fsync", 1, OSError(22, "Invalid argument"))
    works(*command_line("scooter angles"))
    assert (room / "out.csv").exists()


# Names that promise another kind of file.

TABLES = [pair for pair in OPTIONS if pair[1] != "--figure" and pair[0] not in MOUNTS]


@pytest.mark.parametrize(
    "name", ["k.json", "k.TOML", "k.png", "k.svg", "k.pdf", "k.html", "k.tsv", "k.json.gz", "k.7z"]
)
@pytest.mark.parametrize(("command", "option"), TABLES)
def test_no_table_under_another_kinds_name(room, fails, command, option, name):
    says = [f"{name}: is to be a table in CSV", "ends in .csv or .csv.gz"]
    fails(*command_line(command, **{option.strip("-"): name}), says=says)


@pytest.mark.parametrize("name", ["m.csv", "m.xlsx", "m.json", "m.Csv.gz", "m.toml.gz", "m.png"])
@pytest.mark.parametrize("command", MOUNTS)
def test_no_mount_under_another_kinds_name(room, fails, command, name):
    says = [f"{name}: is to be a mount in TOML", "ends in .toml"]
    fails(*command_line(command, o=name), says=says)


@pytest.mark.parametrize("name", ["k", "k.txt", "k.dat", "k.out", "json", ".json", "k.run1", "k.5"])
def test_a_name_that_promises_nothing_is_taken(room, works, name):
    works(*command_line("scooter angles", o=name))
    assert (room / name).read_text().startswith("time_s")
