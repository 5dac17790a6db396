"""An environment of its own for each peer, below _build/peers, from its list of packages."""

import hashlib
import os
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).parent
FOLDER = HERE.parent / "_build" / "peers"


class NotInstalled(Exception):
    """A peer's environment cannot be made; the text is one sentence."""


def python_of(environment):
    """Interpreter of an environment."""
    if os.name == "nt":
        return environment / "Scripts" / "python.exe"
    return environment / "bin" / "python"


def peer_python(peer, folder=FOLDER):
    """Interpreter that has a peer installed; makes its environment unless it is there already."""
    wanted = HERE / f"requirements-{peer}.txt"
    environment = folder / peer
    stamp = environment / ".installed"
    listed = hashlib.sha256(wanted.read_bytes()).hexdigest()
    if not (stamp.is_file() and stamp.read_text() == listed):
        run([sys.executable, "-m", "venv", "--clear", str(environment)], peer)
        pip = [str(python_of(environment)), "-m", "pip", "install", "--disable-pip-version-check"]
        run([*pip, "--quiet", "-r", str(wanted)], peer)
        stamp.write_text(listed)
    return python_of(environment)


def run(command, peer):
    """Run a command; its last line is the reason if it fails."""
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        lines = (done.stderr or done.stdout).strip().splitlines() or ["no reason given"]
        raise NotInstalled(f"{peer}: cannot be installed here ({lines[-1].strip()[:150]})")
