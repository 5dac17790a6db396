"""What the WheelMove-ID document and its public tool state, each with our number beside it.

The document prints no results of an experiment. It prints thresholds, letters and equations. What
its public tool answered, recorded by us, stands under *reference*, never under *published*.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from mobility_imu.data import reference_folder
from mobility_imu.readers.velocities import read_velocities
from mobility_imu.reproduction.claims import Cell, Claim, Quotation
from mobility_imu.reproduction.wheelchair.claims_equations import equation_claims
from mobility_imu.reproduction.wheelchair.claims_sample import sample_claims
from mobility_imu.reproduction.wheelchair.sample import (
    SIGNALS,
    TASK_NAMES,
    letter_combinations,
    open_combinations,
    printed_patterns,
)
from mobility_imu.simulation.wheelchair import (
    COURT,
    STATIC_TRIAL,
    STRAIGHT_TRIAL,
    random_mounting,
    simulate_drive,
)
from mobility_imu.wheelchair.calibration import calibrate_mount
from mobility_imu.wheelchair.geometry import SAMPLE_CHAIR
from mobility_imu.wheelchair.settings import TaskSettings
from mobility_imu.wheelchair.tasks import (
    Symbols,
    Task,
    find_pattern,
    identify_tasks,
    reduce_variability,
    task_codes,
    task_steps,
)
from mobility_imu.wheelchair.velocity import estimate_velocity

FS_HZ = 100.0
HOLDS = "the statement holds"


def claims() -> list[Claim]:
    """All rows of the wheelchair's work.

    Returns
    -------
    list of Claim
    """
    return [
        *equation_claims(),
        *_table_1(),
        *_table_2(),
        *_text(),
        *sample_claims(),
        _court(),
        _chronogram(),
    ]


def _claim(where: str, what: str, unit: str, **fields: Any) -> Claim:
    return Claim(work="wheelchair", where=where, what=what, unit=unit, **fields)


# Tables 1 and 2

# Printed number, and the letters (0, 1, 2 for a, b, c) that meet there.
_LIMITS = (
    ("linear_velocity", "a", "-0.5", (0, 1)),
    ("linear_velocity", "b", "-0.5", (0, 1)),
    ("linear_velocity", "b", "0.5", (1, 2)),
    ("linear_velocity", "c", "0.5", (1, 2)),
    ("abs_linear_velocity", "b", "0.5", (1, 2)),
    ("abs_linear_velocity", "c", "0.5", (1, 2)),
    ("abs_yaw_rate", "b", "40", (1, 2)),
    ("abs_yaw_rate", "c", "40", (1, 2)),
    ("curvature_radius", "a", "0.2", (0, 1)),
    ("curvature_radius", "b", "0.2", (0, 1)),
    ("curvature_radius", "b", "0.5", (1, 2)),
    ("curvature_radius", "c", "0.5", (1, 2)),
)
_UNITS = ("m/s", "m/s", "deg/s", "m")


def _table_1() -> list[Claim]:
    ends = Counter((signal, letter) for signal, letter, *_ in _LIMITS)
    limits = [
        _claim(
            f"Table 1, {signal.replace('_', ' ')}, {letter}"
            + (f", {_end(letter, meeting)} limit" if ends[signal, letter] > 1 else ""),
            "value at which the letter changes, found by driving it through",
            dict(zip(SIGNALS, _UNITS, strict=True))[signal],
            basis="published numbers recomputed",
            source=Cell("wheelchair_table1", signal, letter, "condition"),
            published=printed,
            compute=partial(_limit, signal, meeting),
            tolerance=1e-9,
            tolerance_reason="halving an interval down to the rounding of numbers of size 40",
            copied=True,
        )
        for signal, letter, printed, meeting in _LIMITS
    ]
    return [
        *limits,
        _claim(
            "Table 1",
            "of the 6 limits, how many have exactly one letter",
            "limits",
            basis="published numbers recomputed",
            reference=6.0,
            reference_from="every value needs one letter",
            compute=lambda: float(sum(_letters_at(*limit) == 1 for limit in _AT_LIMIT)),
            n=6,
            tolerance=0.0,
            tolerance_reason="a count",
            finding="W10",
        ),
    ]


def _end(letter: str, meeting: tuple[int, int]) -> str:
    return "upper" if "abc".index(letter) == meeting[0] else "lower"


# The printed conditions of each signal that has them, at each of its limits.
_AT_LIMIT: tuple[tuple[float, tuple[Callable[[float], bool], ...]], ...] = (
    *(
        (v, (lambda x: x <= -0.5, lambda x: -0.5 < x < 0.5, lambda x: x >= 0.5))
        for v in (-0.5, 0.5)
    ),
    (0.5, (lambda x: x < 0.5, lambda x: x >= 0.5)),
    (40.0, (lambda x: x < 40, lambda x: x > 40)),
    *((r, (lambda x: x <= 0.2, lambda x: 0.2 < x < 0.5, lambda x: x >= 0.5)) for r in (0.2, 0.5)),
)


def _letters_at(value: float, conditions: tuple[Callable[[float], bool], ...]) -> int:
    return sum(condition(value) for condition in conditions)


def _limit(signal: str, meeting: tuple[int, int]) -> float:
    """Value at which our letter changes, by bisection on constant series of one segment."""
    low, high = {0: -5.0, 1: 0.0, 2: 0.0, 3: 0.0}[SIGNALS.index(signal)], 100.0
    if meeting == (0, 1) and signal == "linear_velocity":
        high = 0.0
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if _letter(signal, middle) < meeting[1] else (low, middle)
    return high


def _letter(signal: str, value: float) -> int:
    velocity, yaw_radps = (0.0, math.radians(value)) if signal == "abs_yaw_rate" else (value, 1.0)
    steps = task_steps(np.full(25, velocity), np.full(25, yaw_radps), FS_HZ)
    letters = steps.symbols
    in_order = (letters.velocity, letters.speed, letters.yaw_rate, letters.radius)
    return int(in_order[SIGNALS.index(signal)][0])


def _table_2() -> list[Claim]:
    cells = [
        _claim(
            f"Table 2, {task}, {signal.replace('_', ' ')}",
            f"fraction of the samples that we call {task}, of those the table names, with this "
            f"letter ({letter})",
            "-",
            basis="published numbers recomputed",
            source=Cell("wheelchair_table2", signal, task, "symbol"),
            reference=1.0,
            reference_from=HOLDS,
            compute=partial(_letter_share, task, signal, letter),
            n=36,
            tolerance=0.0,
            tolerance_reason="letters are the same or not",
            copied=True,
        )
        for task, pattern in printed_patterns().items()
        for signal, letter in pattern.items()
    ]
    return [
        *cells,
        _claim(
            "Table 2",
            "combinations of letters without a task, of 36",
            "combinations",
            basis="published numbers recomputed",
            source=Quotation(
                "is composed solely of logical values (here capital letters) representing "
                "locomotor tasks."
            ),
            reference=0.0,
            reference_from="a task for every frame, as the sentence says",
            compute=lambda: float(open_combinations()),
            n=36,
            tolerance=0.0,
            tolerance_reason="a count of the document's letters",
            finding="W6",
        ),
    ]


def _letter_share(task: str, signal: str, letter: str) -> float:
    """Fraction with this letter, of the combinations that have a column and are this task to us."""
    combinations = letter_combinations()
    numbers = np.array([["abc".index(row[s]) for s in SIGNALS] for row in combinations], np.int8)
    ours = find_pattern(Symbols(*numbers.T))
    patterns = printed_patterns().values()
    named = [any(pattern.items() <= row.items() for pattern in patterns) for row in combinations]
    letters = [
        row[signal]
        for row, code, has in zip(combinations, ours, named, strict=True)
        if has and code == TASK_NAMES.index(task) + 1
    ]
    return letters.count(letter) / len(letters)


# Numbers and statements of the text


def _text() -> list[Claim]:
    settings = TaskSettings()
    return [
        _claim(
            "section 2.1, step 1",
            "default length of a segment",
            "s",
            basis="published numbers recomputed",
            source=Quotation(
                "The algorithm is developed using a segmentation duration of 0.25s presented as "
                "default value."
            ),
            published="0.25",
            compute=lambda: settings.frames(FS_HZ)[0] / FS_HZ,
            tolerance=0.0,
            tolerance_reason="a setting",
            copied=True,
        ),
        _claim(
            "section 2.4, step 4",
            "velocity from which forward propulsion counts",
            "m/s",
            basis="published numbers recomputed",
            source=Quotation(
                "forward propulsion is only considered when the linear velocity exceeds 0.5 m/s."
            ),
            published="0.5",
            compute=partial(_limit, "linear_velocity", (1, 2)),
            tolerance=1e-9,
            tolerance_reason="halving an interval down to rounding",
            copied=True,
        ),
        _claim(
            "section 2.4, step 4",
            "velocity at which the start of a gentle push is placed, search of 1 s",
            "m/s",
            basis="computed on simulated data",
            source=Quotation(
                "the default complementary threshold for linear velocity is set to 0.1 m/s."
            ),
            published="0.1",
            compute=_velocity_at_onset,
            tolerance=0.01,
            tolerance_reason="the velocity of the made-up start changes by 0.01 m/s per frame",
            finding="W12",
        ),
        *_statements(),
    ]


def _statements() -> list[Claim]:
    return [
        _claim(
            "section 2, rotations",
            "samples whose label stays when every turn is mirrored",
            "-",
            basis="computed on simulated data",
            source=Quotation("Rotations are detected independently of the rotation direction."),
            reference=1.0,
            reference_from=HOLDS,
            compute=_mirrored_share,
            n=20000,
            tolerance=0.0,
            tolerance_reason="the same sizes give the same labels",
        ),
        _claim(
            "section 2.3, step 3",
            "length of the labels over that of the signals, one short trial",
            "-",
            basis="computed on simulated data",
            source=Quotation("The resulting unique signal is as long as the initial signals"),
            reference=1.0,
            reference_from=HOLDS,
            compute=lambda: len(task_codes(np.ones(137), np.zeros(137), FS_HZ)) / 137,
            n=137,
            tolerance=0.0,
            tolerance_reason="a count of samples",
        ),
        _claim(
            "section 2.5, step 5",
            "longest wide turn that is absorbed between two straights at 100 Hz",
            "samples",
            basis="computed on simulated data",
            source=Quotation(
                "a single segment of wide turn appeared in between, that wide turn would be "
                "transformed into a straight-line frame."
            ),
            reference=25.0,
            reference_from="a single segment of 0.25 s, the document's example",
            compute=_longest_absorbed,
            tolerance=0.0,
            tolerance_reason="a count of samples; the public tool, which we follow, absorbs what "
            "is shorter than a segment, so that one segment exactly stays",
            finding="W7",
        ),
    ]


def _velocity_at_onset() -> float:
    """Velocity of the first forward frame of a start that gains 1 m/s in one second."""
    velocity = np.r_[np.zeros(100), np.linspace(0, 1, 101), np.ones(200)]
    codes = task_codes(velocity, np.zeros(len(velocity)), FS_HZ, TaskSettings(look_s=1.0))
    return float(velocity[np.argmax(codes == Task.FORWARD)])


def _mirrored_share() -> float:
    series = read_velocities(reference_folder() / "velocities_six_tasks.csv.gz")
    one, other = (
        task_codes(series.linear_velocity_mps, sign * series.yaw_rate_radps, FS_HZ)
        for sign in (1, -1)
    )
    return float(np.mean(one == other))


def _longest_absorbed() -> float:
    segment, _ = TaskSettings().frames(FS_HZ)
    straight = np.full(200, Task.FORWARD, np.int8)
    absorbed = [
        length
        for length in range(1, 200)
        if (
            reduce_variability(
                np.r_[straight, np.full(length, Task.WIDE, np.int8), straight], segment
            )
            == Task.FORWARD
        ).all()
    ]
    return float(max(absorbed))


# All steps together


def _court() -> Claim:
    return _claim(
        "section 2",
        "tasks found on a simulated court",
        "tasks",
        basis="computed on simulated data",
        reference=6.0,
        reference_from="the court that we programmed: all six tasks, each well inside its limits",
        compute=_tasks_on_court,
        n=5250,
        tolerance=0.0,
        tolerance_reason="a count",
    )


def _tasks_on_court() -> float:
    # Simulated here: an installed package carries no recordings.
    mounting = random_mounting(1)
    static, straight, court = (
        simulate_drive(legs, SAMPLE_CHAIR, mounting, seed=1000 + k).recording
        for k, legs in enumerate((STATIC_TRIAL, STRAIGHT_TRIAL, COURT))
    )
    drive = estimate_velocity(court, SAMPLE_CHAIR, calibrate_mount(static, straight).mount)
    return float(len(set(identify_tasks(drive).codes.tolist()) & set(Task)))


def _chronogram() -> Claim:
    return _claim(
        "section 2.6, step 6",
        "chronogram of six tasks over about 590 samples",
        "samples",
        basis="not reproducible",
        source=Quotation(
            "Finally, chronograms are a simple way to present the results, with each color "
            "representing a locomotor task."
        ),
        reason="shown in the figure, which our text copy lacks; its recording is not published",
    )
