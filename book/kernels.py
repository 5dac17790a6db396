"""Kernels of notebooks as forks of one process that has numpy, scipy and the others loaded.

Starting Python and importing these takes a kernel longer than most cells. Nothing of this project
is loaded here: each notebook imports what it uses, and runs in a process of its own.

Jupyter starts this file as it starts any kernel. It asks the process for a fork, and ends with it:

    python book/kernels.py NUMBER            the process that is forked; number of its socket
    python book/kernels.py SOCKET -f FILE    one kernel, with its connection file
"""

from __future__ import annotations

import contextlib
import gc
import importlib
import json
import os
import signal
import socket
import socketserver
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

NAME = "forked"
"""Name of the kernel spec."""
LOADED = (
    *("ipykernel.kernelapp", "ipykernel.ipkernel", "numpy", "pandas", "numba", "sympy"),
    *("scipy.interpolate", "scipy.linalg", "scipy.optimize", "scipy.signal", "scipy.stats"),
    *("scipy.spatial.transform", "matplotlib.figure", "matplotlib.backends.backend_agg"),
)
"""What a kernel has loaded when it begins; not pyplot, which asks for the kernel it is in."""
INLINE = "module://matplotlib_inline.backend_inline"
"""Matplotlib's backend in a kernel; it is read when matplotlib is loaded."""
ONE_THREAD = {f"{library}_NUM_THREADS": "1" for library in ("OMP", "OPENBLAS", "MKL", "NUMBA")}
"""One thread for each kernel: the kernels share the cores. Read when a library is loaded."""
WAITING = 128
"""Kernels that may wait for the process while it loads."""


@contextlib.contextmanager
def forked_kernels(folder: Path) -> Iterator[tuple[list[str], dict[str, str]]]:
    """Options of nbmake and environment variables for such kernels; none but on Linux.

    Other systems have no ``fork``, or libraries that cannot be used after it.

    Parameters
    ----------
    folder : empty folder for the socket and for the kernel spec
    """
    if sys.platform != "linux":
        yield [], {}
        return
    this = [sys.executable, os.path.abspath(__file__)]
    address = str(folder / "socket")
    spec = folder / "kernels" / NAME / "kernel.json"
    spec.parent.mkdir(parents=True)
    kernel = {
        "argv": [*this, address, "-f", "{connection_file}"],
        "display_name": NAME,
        "language": "python",
    }
    spec.write_text(json.dumps(kernel))
    # Listening before the process is there: who asks waits while it loads. The process alone then
    # holds the socket: when it has ended, who asks is refused at once.
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as listening:
        listening.bind(address)
        listening.listen(WAITING)
        number = listening.fileno()
        environment = ONE_THREAD | os.environ
        process = subprocess.Popen([*this, str(number)], pass_fds=[number], env=environment)
    with process:
        try:
            paths = [str(folder), os.environ.get("JUPYTER_PATH", "")]
            variables = {"JUPYTER_PATH": os.pathsep.join(filter(None, paths))}
            yield [f"--nbmake-kernel={NAME}"], variables
        finally:
            process.terminate()


class Kernel(socketserver.StreamRequestHandler):
    """What a fork does: it takes arguments, variables and folder of who asks, and runs a kernel."""

    def handle(self) -> None:
        from ipykernel.kernelapp import IPKernelApp

        self.server.socket.close()
        signal.signal(signal.SIGINT, signal.default_int_handler)
        asked = json.loads(self.rfile.readline())
        os.environ.clear()
        os.environ.update(asked["variables"])
        os.chdir(asked["folder"])
        threading.Thread(target=self.end_with_who_asks, daemon=True).start()
        parent = f"--IPKernelApp.parent_handle={os.getppid()}"
        IPKernelApp.launch_instance([*asked["arguments"], parent])

    def end_with_who_asks(self) -> None:
        self.rfile.read()
        os._exit(1)


class Kernels(socketserver.ForkingMixIn, socketserver.UnixStreamServer):
    """The process that is forked; it ends with the one that started it."""

    parent = os.getppid()

    def service_actions(self) -> None:
        super().service_actions()
        if os.getppid() != self.parent:
            sys.exit()


def serve(number: int) -> None:
    """Load, then fork at each request that comes to the socket of this number."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # who started this ends it
    os.environ["MPLBACKEND"] = INLINE
    for name in LOADED:
        importlib.import_module(name)
    gc.freeze()  # forks share these pages
    with Kernels("", Kernel, bind_and_activate=False) as server:
        server.socket.close()
        server.socket = socket.socket(fileno=number)
        server.serve_forever()


def ask(address: str, arguments: list[str]) -> None:
    """Ask for a kernel, and wait for its end."""
    wanted = {
        "arguments": arguments,
        "variables": dict(os.environ),
        "folder": os.getcwd(),
    }
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as kernel:
        try:
            kernel.connect(address)
            kernel.sendall(json.dumps(wanted).encode() + b"\n")
            kernel.recv(1)
        except OSError as error:
            sys.exit(
                f"{NAME} kernel: no kernel came from the process that is forked ({error.strerror});"
                " it has ended, and its messages say why. Run the notebooks again."
            )


if __name__ == "__main__":
    if sys.argv[2:]:
        ask(sys.argv[1], sys.argv[2:])
    else:
        serve(int(sys.argv[1]))
