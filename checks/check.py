"""Slow checks: what takes too long for every change, and is run before an issue is closed.

    python checks/check.py [STEP ...]

Each step works in a folder of its own, keeps its output in ``_build/check/<step>.log`` and ends in
one line: its name, the outcome, the time. Exit code 1 if a step failed.
"""

from __future__ import annotations

import argparse
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
LOGS = ROOT / "_build" / "check"
PAGES = ("README.md", "book/how_to_use.md")
"""Pages whose commands run one after the other from an empty folder, with the core alone."""
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
SUITE = ("-m", "pytest", "-q", "-p", "no:cacheprovider", "-n", "2")
WHOLE = (*SUITE, "tests", "--every-variant")


class Failed(Exception):
    """A step found a fault; the message is what its line says."""


class Step:
    """One step: a folder to work in, a log, and ways to run commands.

    Parameters
    ----------
    name : of the step
    folder : empty folder, removed afterwards
    """

    def __init__(self, name: str, folder: Path) -> None:
        self.folder = folder
        self.log = LOGS / f"{name}.log"
        self.log.parent.mkdir(parents=True, exist_ok=True)
        self.log.write_text("")

    def run(
        self,
        *command: str | Path,
        cwd: Path | None = None,
        codes: tuple[int, ...] = (0,),
        environment: dict[str, str] | None = None,
        **changed: str,
    ) -> str:
        """Run a command; its output goes to the log and is returned."""
        line = shlex.join(str(part) for part in command)
        done = subprocess.run(
            [str(part) for part in command],
            cwd=cwd or self.folder,
            env=(dict(os.environ) if environment is None else environment) | changed,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            encoding="utf-8",
            errors="replace",
        )
        with self.log.open("a", encoding="utf-8") as log:
            log.write(f"$ {line}\n{done.stdout}[{done.returncode}]\n")
        if done.returncode not in codes:
            last = (done.stdout.strip().splitlines() or ["no output"])[-1]
            raise Failed(f"{line[:100]} ended with {done.returncode}: {last[:200]}")
        return done.stdout

    def sources(self) -> Path:
        """Copy of the project's own files: nothing built or installed earlier counts."""
        target = self.folder / "sources"
        listed = self.run("git", "ls-files", "-z", "--cached", "--others", "--exclude-standard",
                          cwd=ROOT)  # fmt: skip
        for name in filter(None, listed.split("\0")):
            if (ROOT / name).is_file():
                (target / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(ROOT / name, target / name)
        return target

    def wheel(self) -> Path:
        """Wheel of the package, built from a copy."""
        self.run(sys.executable, "-m", "pip", "wheel", "-q", "--no-deps", "-w", "dist", "./sources")
        return next((self.folder / "dist").glob("*.whl"))

    def environment(self, name: str, *requirements: str | Path) -> Path:
        """Fresh virtual environment with some packages; the path of its programs."""
        self.run(sys.executable, "-m", "venv", name)
        programs = self.folder / name / "bin"
        self.run(programs / "python", "-m", "pip", "install", "-q", *requirements)
        return programs


def summary(output: str) -> str:
    """Last line of pytest's output, without decoration."""
    return output.strip().splitlines()[-1].strip("= ")


def compile_first(step: Step, python: Path | str, folder: Path, **environment: str) -> None:
    """Run the tests that compare processes once, whatever comes out, so that later ones load.

    A process that compiles the walker's filter calls its small functions otherwise than one that
    loads it: where they are not inlined, as with checked indices or an old numba, the two contract
    products and sums differently, and the last digits differ.
    """
    tests = "tests/test_executors.py"
    step.run(python, *SUITE, tests, cwd=folder, codes=(0, 1), **environment)


def bounds(step: Step) -> str:
    """Suite with numba's checks of every index."""
    checked = {"NUMBA_BOUNDSCHECK": "1", "NUMBA_CACHE_DIR": str(step.folder / "numba")}
    compile_first(step, sys.executable, ROOT, **checked, **ONE_THREAD)
    return summary(step.run(*(sys.executable, *WHOLE), cwd=ROOT, **checked, **ONE_THREAD))


def nonumba(step: Step) -> str:
    """Suite with the import of numba blocked."""
    found = step.run(*(sys.executable, *WHOLE), cwd=ROOT, MOBILITY_IMU_NO_NUMBA="1", **ONE_THREAD)
    return summary(found)


def lowest(step: Step) -> str:
    """Suite with the lowest versions that are declared."""
    sources = step.sources()
    step.run(sys.executable, "-m", "venv", "tools")
    step.run("tools/bin/python", "-m", "pip", "install", "-q", "uv")
    step.run("tools/bin/uv", "venv", "-q", "--python", sys.executable, "lowest")
    step.run(
        *("tools/bin/uv", "pip", "install", "-q", "--resolution", "lowest-direct"),
        f"{sources}[dev]",
        VIRTUAL_ENV=str(step.folder / "lowest"),
    )
    python = step.folder / "lowest/bin/python"
    environment = {
        "PYTHONPATH": str(sources),
        # Oldest versions here, newest beneath them: what those call deprecated is not our fault.
        "PYTEST_ADDOPTS": "-o filterwarnings=ignore",
        "NUMBA_CACHE_DIR": str(step.folder / "numba"),
        **ONE_THREAD,
    }
    compile_first(step, python, sources, **environment)
    return summary(step.run(python, *WHOLE, cwd=sources, **environment))


def examples(page: str) -> list[str]:
    """Commands of ``mobility-imu`` that a page shows as code, continued lines joined."""
    joined = re.sub(r"\\\n\s*", "", page)
    code = "\n".join(re.findall(r"^(?: {4}.*|```[\s\S]*?^```)$", joined, flags=re.MULTILINE))
    return re.findall(r"^ *(mobility-imu .*?)(?:\s+#.*)?$", code, flags=re.MULTILINE)


def wheel(step: Step) -> str:
    """Wheel in an empty environment, read-only and without a home: every command of the pages."""
    sources = step.sources()
    programs = step.environment("empty", step.wheel())
    # Neither the installation nor a home can be written to, not even by a superuser.
    home = step.folder / "home"
    home.mkdir()
    step.run("chmod", "-R", "a-w", programs.parent, home)
    plainly = ("setpriv", "--bounding-set=-dac_override,-dac_read_search")
    plainly = plainly if os.geteuid() == 0 else ()
    bare = {"PATH": f"{programs}:/usr/bin:/bin", "HOME": f"{home}/none", "LANG": "C.UTF-8"}
    # The README's commands run beside the checkout.
    (step.folder / "mobility_imu").symlink_to(sources)
    counts = []
    for page in PAGES:
        room = step.folder / Path(page).stem
        room.mkdir()
        commands = examples((sources / page).read_text(encoding="utf-8"))
        if not commands:
            raise Failed(f"{page}: no example was found")
        for command in commands:
            step.run(*plainly, "sh", "-c", command, cwd=room, environment=bare)
        counts.append(f"{len(commands)} of {page}")
    figure = "mobility-imu wheelchair tasks velocity.csv --figure c.png -o c.csv"
    refused = step.run("sh", "-c", figure, cwd=step.folder / "README", codes=(2,), environment=bare)
    if refused != "mobility-imu: needs matplotlib: pip install 'mobility-imu[plot]'\n":
        raise Failed(f"a missing extra is not named: {refused[:200]}")
    return f"examples that ran: {', '.join(counts)}"


def sdist(step: Step) -> str:
    """The source archive builds the same wheel as the sources."""
    sources = step.sources()
    step.environment("tools", "build")
    step.run("tools/bin/python", "-m", "build", "-o", "built", sources)
    through = next((step.folder / "built").glob("*.whl"))
    names = [
        step.run(sys.executable, "-m", "zipfile", "-l", path) for path in (through, step.wheel())
    ]
    files = [sorted(line.split()[0] for line in text.splitlines()[1:]) for text in names]
    if files[0] != files[1]:
        raise Failed(f"files differ: {set(files[0]) ^ set(files[1])}")
    return f"{len(files[0])} files"


def requirements(step: Step) -> str:
    """``pip install -r requirements.txt`` in a bare environment, then every notebook."""
    sources = step.sources()
    step.run(sys.executable, "-m", "venv", "bare")
    python = step.folder / "bare/bin/python"
    step.run(python, "-m", "pip", "install", "-q", "-r", "requirements.txt", cwd=sources)
    found = step.run(
        *(python, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--nbmake", "-n", "2"),
        *("notebooks", "book/index.ipynb"),
        cwd=sources,
        PATH=f"{python.parent}:{os.environ['PATH']}",
        **ONE_THREAD,
    )
    return summary(found)


def dask(step: Step) -> str:
    """A Dask cluster gives the same bytes as one process."""
    sources = step.sources()
    programs = step.environment(
        "cluster", f"{sources}[fast,cluster,dev]", "-c", sources / "constraints.txt"
    )
    found = step.run(
        *(programs / "python", "-m", "pytest", "-q", "-p", "no:cacheprovider"),
        *("-W", "ignore::DeprecationWarning", "tests/test_executors.py"),
        cwd=sources,
        PYTHONPATH=str(sources),
        MOBILITY_IMU_EXECUTOR="dask",
        **ONE_THREAD,
    )
    return summary(found)


def slow(step: Step) -> str:
    """Tests whose faster part is in the suite: whole studies, all draws."""
    found = step.run(*(sys.executable, *SUITE, "-m", "slow", "tests"), cwd=ROOT, **ONE_THREAD)
    return summary(found)


def mutations(step: Step) -> str:
    """2,000 inputs damaged at random: no traceback, no lost file."""
    found = step.run(
        *(
            sys.executable,
            *SUITE,
            "tests/cli/test_cli_mutations.py",
            "tests/readers/test_mutations.py",
        ),
        cwd=ROOT,
        MOBILITY_IMU_MUTATIONS="2000",
        **ONE_THREAD,
    )
    return summary(found)


STEPS: dict[str, Callable[[Step], str]] = {
    step.__name__: step
    for step in (wheel, sdist, lowest, bounds, nonumba, slow, dask, mutations, requirements)
}
"""Every step by its name, in the order in which they run."""


def main() -> int:
    """Command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    lines = [f"{name}: {(step.__doc__ or '').splitlines()[0]}" for name, step in STEPS.items()]
    parser.add_argument("steps", nargs="*", metavar="STEP", help="; ".join(lines))
    chosen = parser.parse_args().steps or list(STEPS)
    unknown = set(chosen) - set(STEPS)
    if unknown:
        parser.error(f"no such step: {', '.join(sorted(unknown))}; there are {', '.join(STEPS)}")
    failed = False
    for name in chosen:
        begun = time.monotonic()
        with tempfile.TemporaryDirectory(prefix=f"check-{name}-") as made:
            folder = Path(made)
            try:
                outcome = f"ok, {STEPS[name](Step(name, folder))}"
            except (Failed, OSError) as error:  # such as a program that is not there
                outcome, failed = f"FAILED, {error}; see {LOGS / name}.log", True
            finally:
                subprocess.run(["chmod", "-R", "u+w", made], check=False)
        clean = re.sub(r"\s+", " ", outcome)
        print(f"{name}: {clean} ({time.monotonic() - begun:.0f} s)", flush=True)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
