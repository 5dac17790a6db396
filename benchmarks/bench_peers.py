"""Errors against references on real recordings: ours beside worklab, qmt and gaitmap, in one run.

``python benchmarks/bench_peers.py [SET ...]``; sets: chairs, car, two hinges, one hinge, feet. The
recordings are those that MOBILITY_IMU_RECORDINGS or ``mobility-imu fetch`` provide. Each peer has
an environment of its own below _build/peers and is given prepared arrays; error_measures.py judges
all alike. What is missing, recordings or a network, is said in a sentence. Numbers, with the
checksum of each recording, go to _build/peers/errors.json. Exit code 0 whatever comes out.
"""

import json
import os
import subprocess
import sys
import tempfile
from datetime import date
from pathlib import Path

for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")

import numpy as np  # noqa: E402
from peer_environments import FOLDER, HERE, NotInstalled, peer_python  # noqa: E402
from real_recordings import SETS, available  # noqa: E402

from mobility_imu.errors import InputError  # noqa: E402

LONGEST_S = 1800


def answers(real_set, cases, python):
    """What a peer answers to each case, by name."""
    with tempfile.TemporaryDirectory() as scratch:
        given, found = Path(scratch, "given"), Path(scratch, "found")
        given.mkdir()
        found.mkdir()
        for case in cases:
            np.savez(given / f"{case.name}.npz", **case.given)
        done = subprocess.run(
            [str(python), str(HERE / real_set.script), str(given), str(found)],
            capture_output=True, text=True, timeout=LONGEST_S,
        )  # fmt: skip
        if done.returncode:
            lines = done.stderr.strip().splitlines() or ["no reason given"]
            raise NotInstalled(f"{real_set.peer}: fails ({lines[-1][:150]})")
        return {case.name: dict(np.load(found / f"{case.name}.npz")) for case in cases}


def compared(cases, answered):
    """Errors of both for each case, by name; no peer's where it has not answered."""
    return {
        case.name: {
            "sha256": case.sha256,
            "peer": case.judge(answered[case.name]) if answered else None,
            "ours": case.judge(case.ours),
        }
        for case in cases
    }


def medians(errors, key):
    """Median over the recordings of one error, the peer's and ours, over those with both."""
    rows = [
        [one[who][key] if one[who] else float("nan") for who in ("peer", "ours")]
        for one in errors.values()
    ]
    both = [row for row in rows if np.isfinite(row).all()] or rows
    return [float(each) for each in np.median(both, axis=0)]


def mean_ratio(errors, key):
    """Geometric mean of our error over the peer's: less a matter of one recording than medians."""
    ratios = [one["ours"][key] / one["peer"][key] for one in errors.values() if one["peer"]]
    return float(np.exp(np.mean(np.log(ratios)))) if ratios else float("nan")


def row(name, key, peer, ours):
    unit = key.rsplit("_", 1)[1].replace("mps", "m/s")
    label = f"{name} {key.split('_')[0]}" if key.count("_") > 1 else name
    return f"  {label:32}{peer:10.4f}{ours:10.4f}{ours / peer:8.2f}  {unit}"


def show(real_set, errors):
    """Print the table of one set."""
    print(f"\n{real_set.name}: {len(errors)} recordings")
    print(f"  given to both: {real_set.given}")
    print(f"  {real_set.peer}: {real_set.peer_settings}")
    print(f"  {'recording':32}{real_set.peer:>10}{'ours':>10}{'ratio':>8}  rms")
    for name, one in errors.items():
        for key in real_set.measures:
            peer = one["peer"][key] if one["peer"] else float("nan")
            print(row(name, key, peer, one["ours"][key]))
    for key in real_set.measures:
        print(row("median", key, *medians(errors, key)))
        if len(errors) > 2:
            print(f"  {'geometric mean of the ratios':32}{'':20}{mean_ratio(errors, key):8.2f}")
    keys = {key for one in errors.values() for key in one["peer"] or ()}
    others = sorted(key for key in keys - set(real_set.measures) if key.startswith("rms_"))
    for key in others:
        values = [one["peer"][key] for one in errors.values()]
        way = key.removeprefix("rms_").rsplit("_", 1)[0].replace("_", " ")
        print(f"  {real_set.peer}, {way}: median {np.median(values):.4f}")


def one_set(real_set):
    """Errors of one set, or None with a sentence."""
    try:
        folder = available(real_set)
    except InputError as missing:
        print(f"{real_set.name}: {missing}")
        return None
    if folder is None:
        print(
            f"{real_set.name}: no recordings here; 'mobility-imu fetch {real_set.dataset}' or "
            "MOBILITY_IMU_RECORDINGS provide them"
        )
        return None
    cases, answered = real_set.cases(folder), {}
    try:
        answered = answers(real_set, cases, peer_python(real_set.peer))
    except NotInstalled as reason:
        print(f"{real_set.name}: {reason}; ours alone")
    errors = compared(cases, answered)
    show(real_set, errors)
    return {
        "peer": real_set.peer,
        "given": real_set.given,
        "peer_settings": real_set.peer_settings,
        "medians": {key: medians(errors, key) for key in real_set.measures},
        "recordings": errors,
    }


def main():
    named = sys.argv[1:] or [each.name for each in SETS]
    unknown = set(named) - {each.name for each in SETS}
    if unknown:
        print(f"no such set: {', '.join(sorted(unknown))}; there are "
              f"{', '.join(each.name for each in SETS)}")  # fmt: skip
        return 2
    found = {each.name: one_set(each) for each in SETS if each.name in named}
    sets = {name: one for name, one in found.items() if one}
    if not sets:
        return 0
    versions = {
        line.split("==")[0]: line.split("==")[1]
        for path in sorted(HERE.glob("requirements-*.txt"))
        for line in path.read_text().split()
        if line.split("==")[0] in ("worklab", "imufusion", "qmt", "vqf", "gaitmap")
    }
    FOLDER.mkdir(parents=True, exist_ok=True)
    target = FOLDER / "errors.json"
    record = {"date": date.today().isoformat(), "versions": versions, "sets": sets}
    target.write_text(json.dumps(record, indent=1) + "\n")
    print(f"\nnumbers: {target}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
