"""Kernels of notebooks as forks of one process that has numpy, scipy and the others loaded.

Starting Python and importing these takes a kernel longer than most cells. Nothing of this project
is loaded here: each notebook imports what it uses, and runs in a process of its own.

Jupyter starts this file as it starts any kernel. It asks the process for a fork, and ends with it:

    python book/kernels.py SOCKET            the process that is forked
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
import time
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
PATIENCE_S = 60.0
"""Time for the process to load this on a busy machine."""


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
    this = [sys.executable, os.path.abspath(__file__), str(folder / "socket")]
    spec = folder / "kernels" / NAME / "kernel.json"
    spec.parent.mkdir(parents=True)
    kernel = {
        "argv": [*this, "-f", "{connection_file}"],
        "display_name": NAME,
        "language": "python",
    }
    spec.write_text(json.dumps(kernel))
    with subprocess.Popen(this) as process:
        try:
            yield [f"--nbmake-kernel={NAME}"], {"JUPYTER_PATH": str(folder)}
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


def serve(address: str) -> None:
    """Load, then fork at each request."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # who started this ends it
    os.environ["MPLBACKEND"] = INLINE
    for name in LOADED:
        importlib.import_module(name)
    gc.freeze()  # forks share these pages
    with Kernels(address, Kernel) as server:
        server.serve_forever()


def ask(address: str, arguments: list[str]) -> None:
    """Ask for a kernel, and wait for its end."""
    deadline = time.monotonic() + PATIENCE_S
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as kernel:
        while kernel.connect_ex(address) and time.monotonic() < deadline:
            time.sleep(0.05)
        wanted = {
            "arguments": arguments,
            "variables": dict(os.environ),
            "folder": os.getcwd(),
        }
        kernel.sendall(json.dumps(wanted).encode() + b"\n")
        kernel.recv(1)


if __name__ == "__main__":
    if sys.argv[2:]:
        ask(sys.argv[1], sys.argv[2:])
    else:
        serve(sys.argv[1])
