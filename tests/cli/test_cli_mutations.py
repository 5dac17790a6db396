"""Valid files with something changed: an answer or one line, never a traceback.

``MOBILITY_IMU_MUTATIONS=2000`` tries more than ``make test`` does.
"""

import gzip
import os
import re
import shutil
from itertools import pairwise

import numpy as np
import pandas as pd
import pytest
from command_lines import (
    CORRIDOR,
    COURT,
    SCOOTER_TOML,
    angles,
    calibrate,
    contents,
    trajectory,
    velocity,
    velocity_csv,
)
from test_cli_inputs import SCOOTER_MOUNT

COUNT = int(os.environ.get("MOBILITY_IMU_MUTATIONS", "200"))
SETTINGS = '{"freqAcq": 100, "inptSegmentsec": 0.25, "seuilVitLinAbs": 0.5, "segment_s": 0.25}'
POSES = "steering_deg,throttle_deg\n50,0\n50,40\n0,40\n0,0\n-50,0\n-50,40\n"
TOKENS = (
    b"",
    b"nan",
    b"-inf",
    b"1e308",
    b"-1e30",
    b"1e-320",
    b"1e4",
    b"0",
    b"-1",
    b"1" + 400 * b"0",
    b"1" + 5000 * b"0",
    b"0x" + 5000 * b"f",
    b"1_0",
    "٣".encode(),
    b"true",
    b'"1"',
    b"1,5",
    b"[",
    500 * b"[",
    b"{",
    b"\x00",
    b"\x1b[2J",
    b"\xff",
    b"\r",
    b"\n",
    b"\t",
    b";",
    b"//",
    b"=",
)


@pytest.fixture(scope="module")
def valid(tmp_path_factory):
    """Folder with short valid files."""
    room = tmp_path_factory.mktemp("valid")
    from mobility_imu.simulation.scooter import (
        COURSES,
        draw_scooter,
        simulate_parked,
        simulate_ride,
    )

    unit = draw_scooter(1)
    ride = simulate_ride(COURSES["curves"], seed=1, unit=unit).recording.trim(0, 4)
    parked = simulate_parked(pitch_rad=0.1, bank_rad=0.0, seed=1, unit=unit)
    for name, recording in (("ride", ride), ("parked", parked)):
        table = recording.to_frame()
        table.to_csv(room / f"{name}.csv", index=False, float_format="%.5f")
    for source, name, until in (
        (COURT, "court", 10),
        (COURT, "static", 3),
        (COURT, "straight", 10),
        (CORRIDOR, "tilts", 60),
        (CORRIDOR, "walk", 15),
    ):
        table = pd.read_csv(source / f"{name}.csv.gz")
        table[table["time_s"] < until].to_csv(room / f"{name}.csv.gz", index=False)
    velocity_csv(room / "v.csv")
    (room / "g.toml").write_text(SCOOTER_TOML + SCOOTER_MOUNT)
    (room / "chair.toml").write_text((COURT / "geometry.toml").read_text())
    (room / "frame.toml").write_text((CORRIDOR / "true_mount.toml").read_text())
    (room / "s.json").write_text(SETTINGS)
    (room / "poses.csv").write_text(POSES)
    for sensor, word in (("frame", "Frame"), ("left_wheel", "Left"), ("right_wheel", "Right")):
        (room / f"Trial-{word}.txt").write_text(xsens(room / "court.csv.gz", sensor))
    wheelmove = wheelmove_id(room / "court.csv.gz")
    wheelmove.to_csv(room / "w.csv", index=False, sep=";", decimal=",")
    velocities = pd.read_csv(room / "v.csv")
    velocities.columns = ["Temps (s)", "Vitesse linéaire (m/s)", "Vitesse angulaire (°/s)"]
    velocities.to_csv(room / "french.csv", index=False, sep=";", decimal=",")
    return room


def wheelmove_id(path):
    """Recording in the columns of WheelMove-ID."""
    table = pd.read_csv(path)
    names = {"Chassis": "frame", "RoueGauche": "left_wheel", "RoueDroite": "right_wheel"}
    return pd.DataFrame(
        {
            f"{theirs}_{kind}_{axis.upper()}": table[f"{ours}_{kind.lower()}_{axis}_{unit}"]
            for theirs, ours in names.items()
            for kind, unit in (("Acc", "mps2"), ("Gyr", "radps"))
            for axis in "xyz"
        }
    )


def xsens(path, sensor):
    """One sensor of a recording as Xsens' MT Manager exports it."""
    table = pd.read_csv(path)
    columns = {"PacketCounter": (65500 + np.arange(len(table))) % 65536}
    for theirs, ours, unit in (("Acc", "acc", "mps2"), ("Gyr", "gyr", "radps")):
        for axis in "xyz":
            columns[f"{theirs}_{axis.upper()}"] = table[f"{sensor}_{ours}_{axis}_{unit}"]
    return "// Update Rate: 100.0Hz\n" + pd.DataFrame(columns).to_csv(sep="\t", index=False)


CHAIR = {"static": "static.csv.gz", "straight": "straight.csv.gz", "geometry": "chair.toml"}
CHECK = ["wheelchair", "check", *velocity("court.csv.gz", **CHAIR)[2:-2]]
TASKS = ["wheelchair", "tasks", "v.csv", "-o", "t.csv", "--settings", "s.json", "--events", "e.csv"]
FRAME = {"walk": "walk.csv.gz", "mount": "frame.toml"}
TILTS = {"tilts": "tilts.csv.gz", "geometry": "frame.toml"}
# Command line, and the files of which one is changed.
CASES = (
    (angles(), ("ride.csv", "g.toml")),
    ([*angles(), "--method", "fusion"], ("ride.csv", "g.toml")),
    ([*angles(), "--single-imu", "--fill-gaps-s", "1"], ("ride.csv",)),
    (
        "scooter calibrate parked.csv parked.csv --geometry g.toml --poses poses.csv "
        "-o m.toml".split(),
        ("poses.csv", "parked.csv"),
    ),
    (velocity("court.csv.gz", "o.csv", **CHAIR), ("court.csv.gz", *CHAIR.values())),
    (CHECK, ("court.csv.gz", "straight.csv.gz", "chair.toml")),
    (velocity("Trial", "o.csv", **CHAIR), ("Trial-Frame.txt", "Trial-Left.txt", "Trial-Right.txt")),
    ([*velocity("w.csv", "o.csv", **CHAIR), "--sampling-rate-hz", "100"], ("w.csv",)),
    (["wheelchair", "tasks", "french.csv", "-o", "t.csv"], ("french.csv",)),
    (TASKS, ("v.csv", "s.json", "s.json")),
    ([*trajectory(**FRAME), "--steps", "s.csv"], ("walk.csv.gz", "frame.toml", "frame.toml")),
    (calibrate(**TILTS), ("tilts.csv.gz", "frame.toml")),
)


def mutated(content, rng):
    """Bytes with one to three things changed."""
    for _ in range(rng.integers(1, 4)):
        content = MUTATIONS[rng.integers(len(MUTATIONS))](content, rng)
    return content


def place(content, rng):
    """Somewhere in the content, as often near its beginning as anywhere."""
    longest = min(len(content), 400) if rng.random() < 0.5 else len(content)
    return int(rng.integers(longest + 1))


def flip_bit(content, rng):
    if not content:
        return content
    k = min(place(content, rng), len(content) - 1)
    return content[:k] + bytes([content[k] ^ (1 << int(rng.integers(8)))]) + content[k + 1 :]


def insert_token(content, rng):
    k = place(content, rng)
    return content[:k] + TOKENS[rng.integers(len(TOKENS))] + content[k:]


def replace_word(content, rng):
    """A number or name becomes something else."""
    words = list(re.finditer(rb"[\w.+-]+", content))
    if not words:
        return content
    last = min(len(words), 40) if rng.random() < 0.5 else len(words)
    word = words[int(rng.integers(last))]
    return content[: word.start()] + TOKENS[rng.integers(len(TOKENS))] + content[word.end() :]


def cut_out(content, rng):
    k = place(content, rng)
    return content[:k] + content[k + int(rng.integers(1, 60)) :]


def repeat_part(content, rng):
    k, length = place(content, rng), int(rng.integers(1, 200))
    return content[:k] + content[k : k + length] + content[k:]


def cut_short(content, rng):
    return content[: place(content, rng)]


def change_lines(content, rng):
    lines = content.split(b"\n")
    k = int(rng.integers(len(lines)))
    kind = rng.integers(3)
    if kind == 0:
        del lines[k]
    elif kind == 1:
        lines.insert(k, lines[int(rng.integers(len(lines)))])
    else:
        other = int(rng.integers(len(lines)))
        lines[k], lines[other] = lines[other], lines[k]
    return b"\n".join(lines)


def change_dress(content, rng):
    """Another separator, decimal mark, line end or case throughout."""
    swaps = (
        (b",", b";"),
        (b".", b","),
        (b"\n", b"\r"),
        (b"\n", b"\r\n"),
        (b"_", b" "),
        (b"=", b":"),
    )
    old, new = swaps[rng.integers(len(swaps))]
    return content.upper() if rng.random() < 0.2 else content.replace(old, new)


MUTATIONS = (
    flip_bit,
    insert_token,
    replace_word,
    replace_word,
    replace_word,
    cut_out,
    repeat_part,
    cut_short,
    change_lines,
    change_dress,
)


def changed(name, content, rng):
    """The file changed: a packed one as it lies on the disk, or what is in it."""
    if name.endswith(".gz") and rng.random() < 0.6:
        return gzip.compress(mutated(gzip.decompress(content), rng), mtime=0)
    return mutated(content, rng)


@pytest.mark.parametrize("seed", range(COUNT))
def test_changed_files_end_in_an_answer_or_one_line(seed, valid, tmp_path, run):
    rng = np.random.default_rng([12, seed])
    line, names = CASES[seed % len(CASES)]
    name = names[rng.integers(len(names))]
    for path in valid.iterdir():
        os.link(path, tmp_path / path.name)
    (tmp_path / name).unlink()
    (tmp_path / name).write_bytes(changed(name, (valid / name).read_bytes(), rng))
    before = contents(tmp_path)
    result = run(*line)
    after = contents(tmp_path)
    assert all(after[path] == content for path, content in before.items())
    new = {path.name for path in after if path not in before}
    assert result.stderr.replace("\n", "").isprintable()
    lines = result.stderr.splitlines()
    if result.returncode == 0:
        assert new == outputs(line)
        warned = [part.startswith("mobility-imu: warning: ") for part in lines]
        assert warned == sorted(warned) and warned.count(False) <= 5, result.stderr
    else:
        assert result.returncode == 2
        assert new == set()
        assert result.stdout == "" and len(lines) == 1, result.stderr
    shutil.rmtree(tmp_path)  # of thousands of them


def outputs(line):
    """Files that a command line writes."""
    options = ("-o", "--events", "--steps")
    return {name for option, name in pairwise(line) if option in options}


@pytest.mark.parametrize("case", CASES, ids=lambda case: " ".join(case[0][:2]))
def test_the_files_are_valid_before_they_are_changed(case, valid, tmp_path, works):
    line, _ = case
    for path in valid.iterdir():
        os.link(path, tmp_path / path.name)
    works(*line)
    assert all((tmp_path / name).is_file() for name in outputs(line))
