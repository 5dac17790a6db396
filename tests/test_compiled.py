"""Compiled loops: kept machine code is found, and nobody waits for a compiler unasked."""

import importlib
import logging
import os
import subprocess
import sys

import numpy as np
import pytest

from mobility_imu import _compiled
from mobility_imu._compiled import HAVE_NUMBA, choose, machine_code_ready

needs_numba = pytest.mark.skipif(not HAVE_NUMBA, reason="numba is an extra")

LOOP = """
from mobility_imu._compiled import compiled


@compiled()
def total(values):
    result = 0.0
    for value in values:
        result += value
    return result
"""
ASK = """
import numpy as np
from loops import total
from mobility_imu._compiled import machine_code_ready
print(machine_code_ready(total, np.ones(3)), machine_code_ready(total, np.ones(3, np.float32)))
"""


def ask(folder, code):
    env = {**os.environ, "NUMBA_CACHE_DIR": str(folder / "cache"), "MOBILITY_IMU_COMPILE": ""}
    env["PYTHONPATH"] = os.pathsep.join([str(folder), env.get("PYTHONPATH", "")])
    return subprocess.run(
        [sys.executable, "-c", code], env=env, check=True, capture_output=True, text=True
    ).stdout.split()


@needs_numba
def test_kept_machine_code_is_found_by_type_and_lost_with_the_source(tmp_path):
    source = tmp_path / "loops.py"
    source.write_text(LOOP)
    assert ask(tmp_path, ASK) == ["False", "False"]
    assert ask(tmp_path, ASK + "total(np.ones(3))\n" + ASK) == [*["False"] * 2, "True", "False"]
    assert ask(tmp_path, ASK) == ["True", "False"]  # another process finds it on the disk
    source.write_text(LOOP + "\n\n# changed\n")
    assert ask(tmp_path, ASK) == ["False", "False"]
    ask(tmp_path, ASK + "total(np.ones(3))\n")
    for file in (tmp_path / "cache").rglob("*.nbi"):
        file.write_bytes(b"damaged")
    assert ask(tmp_path, ASK) == ["False", "False"]


def test_without_numba_everything_is_plain():
    code = """
import numpy as np
from mobility_imu import _compiled
assert not _compiled.HAVE_NUMBA
double = _compiled.compiled(fastmath=True)(lambda values: 2 * values)
assert double(2.0) == 4.0 and not _compiled.machine_code_ready(double, 2.0)
assert _compiled.choose({double: (2.0,)}, plain_s=1e9, what="work") == "plain"
"""
    env = {**os.environ, "MOBILITY_IMU_NO_NUMBA": "1"}
    subprocess.run([sys.executable, "-c", code], env=env, check=True)


@pytest.fixture
def loop(tmp_path, monkeypatch):
    """A loop that nothing has compiled before."""
    numba = pytest.importorskip("numba")
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))

    @_compiled.compiled()
    def total(values):
        return values.sum()

    return total


@needs_numba
def test_compiling_begins_when_the_plain_form_has_taken_longer(loop, monkeypatch, caplog):
    monkeypatch.setattr(_compiled, "_spent_s", {})
    monkeypatch.delenv("MOBILITY_IMU_COMPILE", raising=False)
    given = {loop: (np.ones(3),)}
    ways = []
    with caplog.at_level("INFO", logger="mobility_imu"):
        for _ in range(3):
            ways.append(choose(given, plain_s=2.0, what="loop"))
    assert ways == ["plain", "plain", "compiled"]
    assert [record.message for record in caplog.records] == [
        "compiling the loop for this computer, some 10 s; later runs start at once"
    ]
    assert not machine_code_ready(loop, np.ones(3))  # to choose compiles nothing
    loop(np.ones(3))
    caplog.clear()
    assert choose(given, plain_s=0.0, what="another") == "compiled" and not caplog.records


@needs_numba
def test_the_environment_decides_if_it_is_asked_to(loop, monkeypatch):
    monkeypatch.setattr(_compiled, "_spent_s", {})
    given = {loop: (np.ones(3),)}
    monkeypatch.setenv("MOBILITY_IMU_COMPILE", "never")
    assert choose(given, plain_s=1e9, what="loop") == "plain"
    monkeypatch.setenv("MOBILITY_IMU_COMPILE", "always")
    assert choose(given, plain_s=0.0, what="loop") == "compiled"


def test_the_command_line_says_that_it_compiles(monkeypatch, capsys):
    command = importlib.import_module("mobility_imu.cli.main")

    def run():
        logging.getLogger("mobility_imu").info("compiling the loop")
        return command.DONE, ""

    monkeypatch.setattr(command, "_run", run)
    for _ in range(2):  # once for each command, however often a process runs one
        with pytest.raises(SystemExit):
            command.main()
        assert capsys.readouterr().err == "mobility-imu: compiling the loop\n"
