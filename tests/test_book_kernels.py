"""Kernels that notebooks run in are forks of one process, and alone all the same."""

import ast
import contextlib
import json
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "book"))
jupyter = pytest.importorskip("jupyter_client")

from kernels import NAME, forked_kernels  # noqa: E402

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
OPENBLAS_THREADS = """[
    getattr(__import__("ctypes").CDLL(line.split()[-1]), "scipy_openblas_get_num_threads64_", int)()
    for line in open("/proc/self/maps") if "libscipy_openblas64_" in line
]"""
"""Code: threads of numpy's OpenBLAS, once for each part of the library in memory."""
pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="kernels are forked on Linux only")


@pytest.fixture(scope="module")
def spec(tmp_path_factory):
    """Folder of the kernel spec, while the process that is forked is there."""
    folder = tmp_path_factory.mktemp("kernels")
    with pytest.MonkeyPatch.context() as patch:
        for name in (*THREADS, "JUPYTER_PATH"):
            patch.delenv(name, raising=False)
        with forked_kernels(folder) as (options, variables):
            assert options == [f"--nbmake-kernel={NAME}"]
            assert variables == {"JUPYTER_PATH": str(folder)}
            yield folder / "kernels"


@contextlib.contextmanager
def kernel(spec, **variables):
    """Manager of a kernel, and what tells the value of an expression in it."""
    specs = jupyter.kernelspec.KernelSpecManager(kernel_dirs=[str(spec)])
    manager = jupyter.KernelManager(kernel_name=NAME, kernel_spec_manager=specs)
    manager.start_kernel(env=os.environ | variables)
    client = manager.client()
    client.start_channels()
    client.wait_for_ready(timeout=60)

    def value(code):
        reply = client.execute("", user_expressions={"v": code}, reply=True, timeout=60)
        return reply["content"]["user_expressions"]["v"]["data"]["text/plain"]

    try:
        yield manager, value
    finally:
        client.stop_channels()
        manager.shutdown_kernel(now=True)


def goes(process):
    """Whether a process ends within some seconds."""
    for _ in range(100):
        try:
            state = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]
        except FileNotFoundError:
            return True
        if state == "Z":  # ended, and not waited for
            return True
        time.sleep(0.1)
    return False


def children():
    """Processes that this one started."""
    return {int(p) for p in Path(f"/proc/self/task/{os.getpid()}/children").read_text().split()}


def test_libraries_are_loaded_and_nothing_of_this_project(spec):
    with kernel(spec, FOR_THIS_KERNEL="yes") as (_, value):
        assert value("'numpy' in __import__('sys').modules") == "True"
        assert value("'mobility_imu' in __import__('sys').modules") == "False"
        assert value("__import__('os').environ['FOR_THIS_KERNEL']") == "'yes'"
        assert value("__import__('os').getcwd()") == repr(os.getcwd())


def test_figures_are_shown(spec):
    """By show, and at the end of a cell."""
    for code in ("plt.plot([1, 2]); plt.show()", "plt.plot([1, 2]);"):
        with kernel(spec) as (manager, _):
            client = manager.client()
            client.start_channels()
            shown = []
            client.execute_interactive(
                f"import matplotlib.pyplot as plt; {code}", output_hook=shown.append, timeout=60
            )
            client.stop_channels()
        kinds = [list(m["content"]["data"]) for m in shown if m["msg_type"] == "display_data"]
        assert len(kinds) == 1 and "image/png" in kinds[0]


def test_kernels_share_nothing(spec):
    with kernel(spec) as (_, first), kernel(spec) as (_, second):
        first("setattr(__import__('numpy'), 'mine', 1)")
        assert second("hasattr(__import__('numpy'), 'mine')") == "False"
        assert first("__import__('os').getpid()") != second("__import__('os').getpid()")


def test_a_kernel_ends_when_who_started_it_is_killed(spec):
    with kernel(spec) as (manager, value):
        process = int(value("__import__('os').getpid()"))
        assert process != manager.provisioner.pid
        os.kill(manager.provisioner.pid, 9)
        assert goes(process)


@pytest.mark.skipif((os.cpu_count() or 1) < 2, reason="one core: one thread in any case")
def test_a_kernel_has_one_thread(spec):
    """Kernels run on all cores at once; with threads of their own they wait for each other."""
    with kernel(spec) as (_, value):
        found = ast.literal_eval(
            value(f"({OPENBLAS_THREADS}, __import__('numba').get_num_threads())")
        )
    assert found[1] == 1 and set(found[0]) <= {1}


def test_kernels_of_the_user_stay(tmp_path, monkeypatch):
    monkeypatch.setenv("JUPYTER_PATH", f"/of/mine{os.pathsep}/of/theirs")
    with forked_kernels(tmp_path) as (_, variables):
        paths = variables["JUPYTER_PATH"].split(os.pathsep)
    assert paths == [str(tmp_path), "/of/mine", "/of/theirs"]


def test_a_process_that_has_ended_is_told_at_once(tmp_path):
    """At the first request after its end, and at one that came while it loaded."""
    before = children()
    with forked_kernels(tmp_path):
        (process,) = children() - before
        argv = json.loads((tmp_path / "kernels" / NAME / "kernel.json").read_text())["argv"]
        asks = {"stderr": subprocess.PIPE, "text": True}
        waiting = subprocess.Popen(argv, **asks)
        time.sleep(0.3)
        os.kill(process, 9)
        assert goes(process)
        begun = time.monotonic()
        for asking in (waiting, subprocess.Popen(argv, **asks)):
            with asking:
                _, message = asking.communicate(timeout=20)
            assert asking.returncode == 1
            assert "has ended" in message and "Traceback" not in message
        assert time.monotonic() - begun < 10
