"""Mutations: small faults put into the estimators one at a time, each judged by its module's tests.

    python checks/mutations.py [--count 200] [--seed 12] [--workers 2] [--only MODULE ...]
        [--leave-out MODULE ...] [--at MODULE:LINE ...] [--seconds FILE]

A mutation is killed if a test of the module's own files fails, or they no longer end in time. The
draw is the same for the same seed and sources; a change in one module leaves what is drawn in the
others as it is, but for the few at the draw's edge. ``--only``, ``--leave-out`` and ``--at``
(single lines, to try a new test) choose from the draw. Texts, annotations, messages of errors and
what only the interpreter's import needs are left alone. Recordings outside the repository are not
used.
"""

from __future__ import annotations

import argparse
import ast
import hashlib
import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile
from collections import Counter, defaultdict
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from queue import Queue
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
DEVICES = ("scooter", "wheelchair", "walker")
LEFT_OUT = {"__init__"}
COPIED = ("mobility_imu", "tests", "benchmarks", "book", "notebooks")
FILES = ("pyproject.toml", "README.md", "CITATION.cff", "requirements.txt")
OUTSIDE = ("MOBILITY_IMU_DATA", "MOBILITY_IMU_RECORDINGS", "MOBILITY_IMU_PAPERS")
TIMES = 4.0
"""Tests that take so many times as long as without a mutation, and START_S, count as failed."""
START_S = 90.0
"""Processor time for starting, and for compiling what was mutated."""

BESIDE: dict[str, tuple[str, ...]] = {
    "mobility_imu/hinges": ("scooter/test_scooter_angles",),
    "scooter/agreement": ("test_scooter_faults", "test_scooter_contradictions"),
    "scooter/angles": ("test_scooter_validity",),
    "scooter/calibration": ("test_scooter_ride", "test_scooter_told"),
    "scooter/contradictions": (
        *("test_scooter_faults", "test_scooter_forces", "test_scooter_told"),
    ),
    "scooter/exchanges": ("test_scooter_told",),
    "scooter/faults": (
        *("test_scooter_contradictions", "test_scooter_forces", "test_scooter_told"),
    ),
    "scooter/force": ("test_scooter_forces", "test_scooter_told"),
    "scooter/fusion": ("test_scooter_fusion_parts", "test_scooter_fusion_sd"),
    "scooter/fusion_filter": ("test_scooter_fusion", "test_scooter_fusion_sd"),
    "scooter/fusion_noise": ("test_scooter_fusion", "test_scooter_fusion_sd"),
    "scooter/fusion_settings": (
        *("test_scooter_fusion_parts", "test_scooter_fusion", "test_scooter_ride"),
    ),
    "scooter/geometry": ("test_scooter_angles",),
    "scooter/machine": ("test_scooter_faults", "test_scooter_contradictions"),
    "scooter/mended": ("test_scooter_faults", "test_scooter_forces"),
    "scooter/ride": ("test_scooter_fusion_parts", "test_scooter_forces", "test_scooter_told"),
    "scooter/mount": ("test_scooter_ride", "test_scooter_calibration"),
    "scooter/pose_errors": ("test_scooter_pose_check", "test_scooter_pose_table"),
    "scooter/sensor_pair": ("test_scooter_faults", "test_scooter_contradictions"),
    "scooter/slips": ("test_scooter_forces",),
    "scooter/uncertain": ("test_scooter_ride",),
    "wheelchair/calibration": ("test_wheelchair_offsets",),
    "wheelchair/check": ("test_wheelchair_outcomes", "test_wheelchair_offsets"),
    "wheelchair/codes": ("test_wheelchair_tasks",),
    "wheelchair/contradictions": ("test_wheelchair_faults", "test_wheelchair_faults_told"),
    "wheelchair/dead_axis": ("test_wheelchair_faults", "test_wheelchair_faults_told"),
    "wheelchair/frame_faults": ("test_wheelchair_faults", "test_wheelchair_faults_told"),
    "wheelchair/lags": ("test_wheelchair_faults", "test_wheelchair_faults_told"),
    "wheelchair/recovery": ("test_wheelchair_faults", "test_wheelchair_faults_told"),
    "wheelchair/remarks": ("test_wheelchair_brought",),
    "wheelchair/series": ("test_wheelchair_inputs",),
    "wheelchair/sign_faults": ("test_wheelchair_faults", "test_wheelchair_false_alarms"),
    "wheelchair/slip": ("test_wheelchair_court",),
    "wheelchair/turning": ("test_wheelchair_faults", "test_wheelchair_faults_told"),
    "wheelchair/validity": ("test_wheelchair_tasks",),
    "wheelchair/velocity": ("test_wheelchair_offsets",),
    "wheelchair/smoothing": ("test_wheelchair_doors",),
    "wheelchair/wheel_faults": ("test_wheelchair_faults", "test_wheelchair_faults_told"),
    "walker/floor": ("test_walker_brought",),
    "walker/footprint": ("test_walker_calibration", "test_walker_tilt_detection"),
    "walker/given_rests": ("test_walker_trajectory",),
    "walker/_kernel": ("test_walker_navigation",),
    "walker/arc_fit": ("test_walker_uncertainty",),
    "walker/calibration": ("test_walker_uncertainty",),
    "walker/error_state": ("test_walker_navigation",),
    "walker/eskf": ("test_walker_navigation",),
    "walker/fault_checks": ("test_walker_faults", "test_walker_fault_rules"),
    "walker/follow": ("test_walker_trajectory", "test_walker_doors"),
    "walker/gaps": ("test_walker_fault_rules",),
    "walker/mount": ("test_walker_geometry", "test_walker_doors"),
    "walker/navigation_settings": ("test_walker_navigation", "test_walker_doors"),
    "walker/path_checks": ("test_walker_faults", "test_walker_fault_rules"),
    "walker/reach": ("test_walker_fault_rules",),
    "walker/rest_checks": ("test_walker_faults",),
    "walker/sensor_errors": (
        *("test_walker_calibration", "test_walker_trajectory", "test_walker_rounding"),
    ),
    "walker/stillness": ("test_walker_navigation", "test_walker_doors"),
    "walker/trajectory": ("test_walker_uncertainty", "test_walker_doors"),
    "walker/turned_sums": ("test_walker_rest_checks",),
    "walker/tilt_ends": ("test_walker_calibration", "test_walker_uncertainty"),
    "walker/walking_tests": ("test_walker_steps",),
}
"""Modules whose tests stand, all or some, in files that bear another module's name."""

ANY_NEGATIVE = "NumPy takes any negative length for the one that follows from the others"
EQUIVALENT: dict[tuple[str, ...], str] = {
    ("scooter/pulses.py", "np.arange(0, total[-1], PAIRS_IN_ORDER)"): (
        "where the last block of pairs ends changes its length, not what is found in it"
    ),
    ("'True' -> 'False'", "strict=True)"): (
        "the lengths are equal by what stands before; the guard never acts"
    ),
    ("'1' -> '2'", "reshape(", ", -1)"): ANY_NEGATIVE,
    ("'1' -> '2'", "reshape(-1"): ANY_NEGATIVE,
    ("walker/_kernel.py", "'15' -> '16'", "for k in range(15):"): (
        "behind the 15 rows of a matrix lies padding of zeros"
    ),
    ("walker/_kernel.py", "'1' -> '2'", "for g in range(len(ends), -1, -1):"): (
        "the loop breaks at the first stride, before its range ends; twice the step is noticed"
    ),
    ("walker/_kernel.py:422", "'15' -> '16'", "for j in range(15):"): (
        "the padding of each row of the other factor is zero"
    ),
    ("wheelchair/outcomes.py", "'0' -> '1'", "np.r_[smooth[0], smooth, smooth[-1] - 1e-9]"): (
        "a first sample that is the highest gains nothing and is no push, found as a peak or not"
    ),
}
"""Mutations that give the same answer, by parts of the line that describes them; why."""

BINARY = {ast.Add: "-", ast.Sub: "+", ast.Mult: "/", ast.Div: "*", ast.Pow: "*", ast.MatMult: "-"}
COMPARED = {
    ast.Lt: ">=", ast.LtE: ">", ast.Gt: "<=", ast.GtE: "<", ast.Eq: "!=", ast.NotEq: "==",
    ast.Is: "is not", ast.IsNot: "is",
}  # fmt: skip
CALLED = {
    "sin": "cos", "cos": "sin", "minimum": "maximum", "maximum": "minimum", "min": "max",
    "max": "min", "any": "all", "all": "any", "argmax": "argmin", "argmin": "argmax",
    "mean": "median", "median": "mean", "floor": "ceil", "ceil": "floor", "sqrt": "abs",
    "hypot": "add", "arctan2": "subtract", "cumsum": "sort", "nanmin": "nanmax", "nanmax": "nanmin",
}  # fmt: skip


class Mutation(NamedTuple):
    """One replacement in one file: text from ``begin`` to ``end`` becomes ``new``."""

    path: str
    line: int
    begin: int
    end: int
    old: str
    new: str


class Finder(ast.NodeVisitor):
    """Places of one file where something can be put wrong."""

    def __init__(self, path: str, text: str) -> None:
        self.path, self.text, self.found = path, text, list[Mutation]()
        self.starts = [0]
        for line in text.encode().splitlines(keepends=True):
            self.starts.append(self.starts[-1] + len(line))
        self.raw = text.encode()

    def place(self, line: int, column: int) -> int:
        return self.starts[line - 1] + column

    def span(self, node: ast.expr) -> tuple[int, int]:
        assert node.end_lineno is not None and node.end_col_offset is not None
        begin = self.place(node.lineno, node.col_offset)
        return begin, self.place(node.end_lineno, node.end_col_offset)

    def add(self, line: int, begin: int, end: int, new: str) -> None:
        old = self.raw[begin:end].decode()
        if old.strip() and old != new:
            self.found.append(Mutation(self.path, line, begin, end, old, new))

    def between(self, left: ast.expr, right: ast.expr, new: str) -> None:
        """The operator between two operands, if nothing but it and blanks stands there."""
        begin, end = self.span(left)[1], self.span(right)[0]
        old = self.raw[begin:end].decode()
        if not set(old) & set("()#[]"):
            self.add(left.end_lineno or left.lineno, begin, end, f" {new} ")

    def visit_BinOp(self, node: ast.BinOp) -> None:
        if type(node.op) in BINARY and not isinstance(node.left, ast.Constant | ast.JoinedStr):
            self.between(node.left, node.right, BINARY[type(node.op)])
        elif type(node.op) in BINARY and isinstance(node.left, ast.Constant):
            if isinstance(node.left.value, int | float):
                self.between(node.left, node.right, BINARY[type(node.op)])
        self.generic_visit(node)

    def visit_AugAssign(self, node: ast.AugAssign) -> None:
        other = {ast.Add: "-=", ast.Sub: "+=", ast.Mult: "/=", ast.BitAnd: "|=", ast.BitOr: "&="}
        if type(node.op) in other:
            begin, end = self.span(node.target)[1], self.span(node.value)[0]
            if not set(self.raw[begin:end].decode()) & set("()#"):
                self.add(node.lineno, begin, end, f" {other[type(node.op)]} ")
        self.generic_visit(node)

    def visit_Compare(self, node: ast.Compare) -> None:
        if type(node.ops[0]) in COMPARED:
            self.between(node.left, node.comparators[0], COMPARED[type(node.ops[0])])
        self.generic_visit(node)

    def visit_BoolOp(self, node: ast.BoolOp) -> None:
        new = "or" if isinstance(node.op, ast.And) else "and"
        self.between(node.values[0], node.values[1], new)
        self.generic_visit(node)

    def visit_UnaryOp(self, node: ast.UnaryOp) -> None:
        if isinstance(node.op, ast.USub | ast.Not | ast.Invert):
            begin = self.span(node)[0]
            self.add(node.lineno, begin, self.span(node.operand)[0], " ")
        self.generic_visit(node)

    def visit_Constant(self, node: ast.Constant) -> None:
        begin, end = self.span(node)
        if isinstance(node.value, bool):
            self.add(node.lineno, begin, end, str(not node.value))
        elif isinstance(node.value, float):
            self.add(node.lineno, begin, end, repr(2 * node.value) if node.value else "1.0")
        elif isinstance(node.value, int):
            self.add(node.lineno, begin, end, str(node.value + 1))

    def visit_Call(self, node: ast.Call) -> None:
        function = node.func
        if isinstance(function, ast.Attribute) and function.attr in CALLED:
            end = self.span(function)[1]
            self.add(node.lineno, end - len(function.attr), end, CALLED[function.attr])
        elif isinstance(function, ast.Name) and function.id in CALLED:
            self.add(node.lineno, *self.span(function), CALLED[function.id])
        self.generic_visit(node)

    def visit_Raise(self, node: ast.Raise) -> None:
        """Messages are tested by their own tests; the condition above counts."""

    def visit_JoinedStr(self, node: ast.JoinedStr) -> None:
        """Texts are left alone."""

    def visit_AnnAssign(self, node: ast.AnnAssign) -> None:
        if node.value is not None:
            self.visit(node.value)

    def visit_arguments(self, node: ast.arguments) -> None:
        for default in [*node.defaults, *(d for d in node.kw_defaults if d is not None)]:
            self.visit(default)

    def visit_FunctionDef(self, node: ast.FunctionDef) -> None:
        self.visit(node.args)
        for part in node.body:
            self.visit(part)

    def visit_ClassDef(self, node: ast.ClassDef) -> None:
        for part in node.body:
            self.visit(part)

    def visit_Subscript(self, node: ast.Subscript) -> None:
        text = ast.unparse(node.value)
        if text in {"Literal", "Annotated", "tuple", "list", "dict", "NDArray", "Callable"}:
            return
        self.generic_visit(node)


def modules() -> list[Path]:
    """Modules of the estimators."""
    found = [p for device in DEVICES for p in (ROOT / "mobility_imu" / device).rglob("*.py")]
    found += [ROOT / "mobility_imu" / f"{name}.py" for name in ("hinges", "offsets")]
    return sorted(p.relative_to(ROOT) for p in found if p.is_file() and p.stem not in LEFT_OUT)


def tests_of(module: Path) -> list[str]:
    """Tests of a module: its examples, the file of its name, and those of :data:`BESIDE`."""
    device, name = module.parent.name, module.stem
    folder = ROOT / "tests" / device if device in DEVICES else ROOT / "tests"
    own = f"test_{device}_{name}" if device in DEVICES else f"test_{name}"
    files = [
        folder / f"{own}.py",
        *(folder / f"{n}.py" for n in BESIDE.get(f"{device}/{name}", ())),
    ]
    found = [str(p.relative_to(ROOT)) for p in files if p.is_file()]
    assert found, f"{module} has no tests"
    return [str(module), *found]


def drawn(count: int, seed: int) -> list[Mutation]:
    """Mutations drawn over all places of all modules.

    Each place has a number from the seed and the text around it; the smallest are drawn.
    """
    numbered: list[tuple[str, Mutation]] = []
    for module in modules():
        text = (ROOT / module).read_text()
        finder = Finder(str(module), text)
        finder.visit(ast.parse(text))
        lines, seen = text.splitlines(), Counter[str]()
        for m in finder.found:
            name = f"{seed} {m.path} {lines[m.line - 1].strip()} {m.old.strip()} {m.new.strip()}"
            seen[name] += 1
            numbered.append((hashlib.sha256(f"{name} {seen[name]}".encode()).hexdigest(), m))
    chosen = sorted(numbered)[:count]
    print(f"{len(numbered)} places in {len(modules())} modules; {len(chosen)} drawn")
    return sorted(m for _, m in chosen)


def wanted(m: Mutation, only: list[str], leave_out: list[str], at: list[str]) -> bool:
    """Whether a mutation lies in the modules and lines that are asked for."""
    lines = [place.rsplit(":", 1) for place in at]
    return (
        (not only or any(name in m.path for name in only))
        and not any(name in m.path for name in leave_out)
        and (not lines or any(name in m.path and int(line) == m.line for name, line in lines))
    )


def copy_of_the_project(folder: Path) -> Path:
    """A copy in which files can be put wrong; data are only read."""
    for name in COPIED:
        ignore = shutil.ignore_patterns("*.nbi", "*.nbc", ".ipynb_checkpoints")
        shutil.copytree(ROOT / name, folder / name, ignore=ignore)
    for name in FILES:
        shutil.copyfile(ROOT / name, folder / name)
    (folder / "data").symlink_to(ROOT / "data", target_is_directory=True)
    return folder


def run(room: Path, seconds: Path, tests: list[str], limit_s: float) -> bool:
    """Whether the tests pass in a copy; the fast ones run first.

    The limit is one of processor time: a busy machine fails no test. Ten times as long on the clock
    is for tests that wait for ever.
    """

    def limit_processor_time() -> None:
        resource.setrlimit(resource.RLIMIT_CPU, (int(limit_s), int(limit_s) + 5))

    environment = {
        **os.environ, "PYTHONPATH": f"{room}{os.pathsep}{ROOT / 'checks'}",
        "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "PYTHONDONTWRITEBYTECODE": "1",
        "MOBILITY_IMU_MUTATIONS": "20", "MOBILITY_IMU_SECONDS": str(seconds),
        "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1",
    }  # fmt: skip
    for name in OUTSIDE:
        environment.pop(name, None)
    command = [
        *(sys.executable, "-m", "pytest", "-x", "-q", "--every-variant"),
        *("-p", "no:cacheprovider", "-p", "fastest_first", *tests),
    ]
    try:
        code = subprocess.run(
            command, cwd=room, env=environment, timeout=10 * limit_s,
            preexec_fn=limit_processor_time, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        ).returncode  # fmt: skip
    except subprocess.TimeoutExpired:
        return False
    return code == 0


def judge(mutation: Mutation, room: Path, seconds: Path) -> bool:
    """Whether a mutation survives the tests of its module."""
    path, tests = room / mutation.path, tests_of(Path(mutation.path))
    known = json.loads(seconds.read_text())
    usual = sum(took for name, took in known.items() if name.split("::")[0] in tests)
    raw = path.read_bytes()
    assert raw[mutation.begin : mutation.end].decode() == mutation.old
    path.write_bytes(raw[: mutation.begin] + mutation.new.encode() + raw[mutation.end :])
    try:
        return run(room, seconds, tests, TIMES * usual + START_S)
    finally:
        path.write_bytes(raw)


def survivors(mutations: list[Mutation], workers: int, kept: Path | None) -> Iterator[Mutation]:
    """Judge all mutations; yields those that no test of their module noticed.

    All tests are run once without a mutation before, unless their seconds are known.
    """
    with tempfile.TemporaryDirectory() as folder:
        rooms: Queue[Path] = Queue()
        for k in range(workers):
            rooms.put(copy_of_the_project(Path(folder) / str(k)))
        seconds = kept.absolute() if kept else Path(folder) / "seconds.json"
        if not seconds.is_file():
            tests = sorted({test for m in mutations for test in tests_of(Path(m.path))})
            if not run(Path(folder) / "0", seconds, tests, 3600):
                raise SystemExit("the tests fail without a mutation")

        def judged(mutation: Mutation) -> tuple[Mutation, bool]:
            room = rooms.get()
            try:
                return mutation, judge(mutation, room, seconds)
            finally:
                rooms.put(room)

        with ThreadPoolExecutor(workers) as pool:
            for k, (mutation, survives) in enumerate(pool.map(judged, mutations)):
                mark = "SURVIVES" if survives else "killed"
                print(f"{k + 1:4d} {mark:8s} {described(mutation)}", flush=True)
                if survives:
                    yield mutation


def described(m: Mutation) -> str:
    """One line that names a mutation."""
    line = (ROOT / m.path).read_text().splitlines()[m.line - 1].strip()
    return f"{m.path}:{m.line}  {m.old.strip()!r} -> {m.new.strip()!r}   in: {line}"


def main() -> int:
    """Command line; exit code 1 if fewer than the wanted part are killed."""
    parser = argparse.ArgumentParser(description=__doc__, prog="python checks/mutations.py")
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seed", type=int, default=12)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--least", type=float, default=0.85, help="part that must be killed")
    parser.add_argument("--only", nargs="*", default=[], help="parts of module names")
    parser.add_argument("--leave-out", nargs="*", default=[], help="parts of module names")
    parser.add_argument(
        "--slowest", type=float, default=float("inf"), help="s, leave out tests that take longer"
    )
    parser.add_argument("--but", type=int, default=0, help="not those that a draw of so many has")
    parser.add_argument("--at", nargs="*", default=[], help="part of a module's name:line")
    parser.add_argument(
        "--seconds", type=Path, default=None, help="file of the tests' seconds; written if absent"
    )
    given = parser.parse_args()
    os.environ["MOBILITY_IMU_SLOWEST"] = str(given.slowest)
    known = set(drawn(given.but, given.seed))
    chosen = [m for m in drawn(given.count, given.seed) if m not in known]
    mutations = [m for m in chosen if wanted(m, given.only, given.leave_out, given.at)]
    alive = list(survivors(mutations, given.workers, given.seconds))
    for folder, (killed, all_) in counted(mutations, alive).items():
        print(f"killed in {folder}: {killed} of {all_} ({killed / all_:.1%})")
    part = 1 - len(alive) / len(mutations)
    print(f"killed: {len(mutations) - len(alive)} of {len(mutations)} ({part:.1%}); alive:")
    for mutation in alive:
        text = described(mutation)
        same = [why for parts, why in EQUIVALENT.items() if all(part in text for part in parts)]
        print("  ", text, *(f"(the same: {why})" for why in same))
    return int(part < given.least)


def counted(mutations: list[Mutation], alive: list[Mutation]) -> dict[str, tuple[int, int]]:
    """Of each folder, how many mutations were killed and how many there were."""
    found: defaultdict[str, list[bool]] = defaultdict(list)
    for mutation in mutations:
        found[str(Path(mutation.path).parent)].append(mutation not in alive)
    return {folder: (sum(marks), len(marks)) for folder, marks in found.items()}


if __name__ == "__main__":
    sys.exit(main())
