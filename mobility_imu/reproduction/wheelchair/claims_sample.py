"""The public sample and the public tool's answers: rows that stand under *reference*.

Rows that need the sample, or the tool's answers to it, have no number where those are not here.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from mobility_imu.data import sample_folder
from mobility_imu.reproduction.claims import Claim
from mobility_imu.reproduction.wheelchair.sample import (
    LABEL_FILES,
    LabelFile,
    differing_labels,
    load_tool_velocities,
    yaw_gain,
)
from mobility_imu.reproduction.wheelchair.sample_study import (
    Term,
    cached_sample,
    largest,
    printed_velocity_gain,
    resting_direction,
)
from mobility_imu.wheelchair.slip import detect_slip

FS_HZ = 100.0
TOOL = "public tool's answer, recorded by us"
NEEDS_SAMPLE = "(needs the public sample)"
NEEDS_TOOL = (
    "(needs the public tool's answers to the sample; we recorded them, the public sample does "
    "not contain them)"
)
SAMPLE_FRAMES = 12656
LEFT_TURN_FRAMES = 4347
"""Frames of the sample that turn left faster than 0.3 rad/s."""
MADE_UP_FRAMES = 20000


def sample_claims() -> list[Claim]:
    """Rows of the public tool and of the public sample.

    Returns
    -------
    list of Claim
    """
    return [*_label_claims(), *_tool_claims(), *_sample_rows()]


def _claim(where: str, what: str, unit: str, **fields: Any) -> Claim:
    return Claim(work="wheelchair", where=where, what=what, unit=unit, **fields)


# The public tool


def _label_claims() -> list[Claim]:
    rows = []
    for reference in LABEL_FILES:
        needs = "" if reference.bundled else f" {NEEDS_TOOL}"
        rows.append(
            _claim(
                "public tool, task labels",
                f"samples labelled otherwise: {reference.what}{needs}",
                "samples",
                basis="computed on simulated data"
                if reference.bundled
                else "computed on the public sample",
                reference=0.0,
                reference_from=TOOL,
                compute=partial(_label_difference, reference),
                n=MADE_UP_FRAMES if reference.bundled else SAMPLE_FRAMES,
                tolerance=0.0,
                tolerance_reason="same rules on the same numbers",
                needs_sample=not reference.bundled,
            )
        )
    return rows


def _label_difference(reference: LabelFile) -> float:
    folder = reference.folder(sample_folder())
    return math.nan if folder is None else float(differing_labels(reference, folder))


def _tool_claims() -> list[Claim]:
    known = "chosen with the result known"
    return [
        _tool_claim(
            "public tool, velocity",
            "largest difference before slip correction, camber term as in the document",
            "m/s",
            partial(_velocity_difference, "printed"),
            reference=0.0,
            tolerance=0.004,
            tolerance_reason=f"{known}: 0.0038 with the document's mean rate, 0.0011 with the "
            "principal axis of the rate, which the package uses now",
        ),
        _tool_claim(
            "public tool, yaw rate",
            "largest difference of the frame's yaw rate",
            "deg/s",
            _yaw_difference,
            reference=0.0,
            tolerance=0.01,
            tolerance_reason=f"{known} (0.0054): the tool takes the vertical from the middle half "
            "of the static trial",
        ),
        _tool_claim(
            "public tool, slip",
            "samples flagged, camber term as in the document",
            "%",
            lambda folder: 100 * float(cached_sample(folder)[1]["printed"].slip.mean()),
            reference=100 * 3670 / SAMPLE_FRAMES,
            tolerance=0.5,
            tolerance_reason=f"{known} (0.25): samples at the threshold flip with differences of "
            "0.003 rad/s",
            finding="W3",
        ),
        _tool_claim(
            "public tool, slip",
            "windows flagged, from the tool's own two yaw rates",
            "windows",
            _slip_windows,
            reference=166.0,
            tolerance=0.0,
            tolerance_reason="same rule on the same numbers",
        ),
    ]


def _tool_claim(
    where: str, what: str, unit: str, compute: Callable[[Path], float], **fields: Any
) -> Claim:
    return _claim(
        where,
        f"{what} {NEEDS_TOOL}",
        unit,
        basis="computed on the public sample",
        reference_from=TOOL,
        compute=partial(_on_tool, compute),
        n=SAMPLE_FRAMES,
        needs_sample=True,
        **fields,
    )


def _on_tool(compute: Callable[[Path], float]) -> float:
    folder = sample_folder()
    if folder is None or load_tool_velocities(folder) is None:
        return math.nan
    return compute(folder)


def _velocity_difference(term: Term, folder: Path) -> float:
    tool = load_tool_velocities(folder)
    assert tool is not None
    ours = cached_sample(folder)[1][term].linear_velocity_mps
    return largest(ours - tool.linear_velocity_mps)


def _yaw_difference(folder: Path) -> float:
    tool = load_tool_velocities(folder)
    assert tool is not None
    ours = cached_sample(folder)[1]["printed"].yaw_rate_radps
    return largest(np.rad2deg(ours - tool.yaw_rate_radps))


def _slip_windows(folder: Path) -> float:
    tool = load_tool_velocities(folder)
    assert tool is not None
    windows = detect_slip(tool.yaw_rate_radps, tool.wheel_yaw_rate_radps, FS_HZ)
    return float(len(windows.first))


# The public sample alone


def _sample_rows() -> list[Claim]:
    factor = "wheels' over frame's yaw rate, the sample's left turns"
    gain: dict[str, Any] = {
        "reference": 1.0,
        "reference_from": "the frame's gyroscope",
        "tolerance": 0.02,
        "tolerance_reason": "a track known to 1 cm of 84, radii to 1 %",
        "n": LEFT_TURN_FRAMES,
    }
    return [
        _sample_claim(
            "equations (1.16) to (1.18), the public tool's signs and distance",
            factor,
            partial(_sample_gain, "printed"),
            finding="W3",
            **gain,
        ),
        _sample_claim(
            "equations (1.16) to (1.18), our sign-safe form",
            factor,
            partial(_sample_gain, "sign-safe"),
            **gain,
        ),
        _sample_claim(
            "equation (1.17) as in the document",
            "velocity over the driven one; both sensors face inward",
            printed_velocity_gain,
            reference=-1.0,
            reference_from="our own derivation: Figure 1 draws z outward, facing inward turns the "
            "sign",
            tolerance=0.01,
            tolerance_reason="a sign, and radii known to 1 %",
            finding="W4",
        ),
        _sample_claim(
            "equation (1.12)",
            "direction of the acceleration at rest, found from the turns; up is +1",
            lambda folder: resting_direction(cached_sample(folder)[0]),
            reference=-1.0,
            reference_from="the minus of (1.12)",
            tolerance=0.01,
            tolerance_reason="a sign",
            finding="W1",
        ),
    ]


def _sample_claim(where: str, what: str, compute: Callable[[Path], float], **fields: Any) -> Claim:
    return _claim(
        where,
        f"{what} {NEEDS_SAMPLE}",
        "-",
        basis="computed on the public sample",
        compute=partial(_on_sample, compute),
        needs_sample=True,
        **({"n": SAMPLE_FRAMES} | fields),
    )


def _on_sample(compute: Callable[[Path], float]) -> float:
    folder = sample_folder()
    return math.nan if folder is None else compute(folder)


def _sample_gain(term: Term, folder: Path) -> float:
    found = cached_sample(folder)[1][term]
    return yaw_gain(
        found.yaw_rate_radps, found.wheel_yaw_rate_radps, found.linear_velocity_mps, side="left"
    )[0]
