"""Numbers that the public sample gives, recorded so that the book shows them without the sample.

Each part is a function of the sample's folder. What needs the public tool's answers is left out
where they are not there; the record itself is made with them.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any, Literal

import numpy as np

from mobility_imu.data import sample_folder
from mobility_imu.readers.velocities import read_velocities
from mobility_imu.reproduction.wheelchair.choices import frames_changed
from mobility_imu.reproduction.wheelchair.printed import velocity_printed, wheel_rates_printed
from mobility_imu.reproduction.wheelchair.sample import (
    LABEL_FILES,
    SAMPLE_FILES,
    SHIPPED_VELOCITIES,
    SMALLEST_TURN_RADPS,
    TOOL_VELOCITIES,
    Sample,
    ToolVelocities,
    differing_labels,
    load_sample,
    load_tool_velocities,
    yaw_gain,
)
from mobility_imu.runs import changes_of
from mobility_imu.wheelchair.calibration import Form
from mobility_imu.wheelchair.geometry import SAMPLE_CHAIR, SIDES
from mobility_imu.wheelchair.slip import detect_slip, slip_report, slip_sources, wheel_speeds
from mobility_imu.wheelchair.tasks import identify_tasks
from mobility_imu.wheelchair.velocity import ChairVelocity, VelocitySettings, estimate_velocity

Term = Literal["printed", "sign-safe"]
FORMS: dict[Term, Form] = {"printed": "printed", "sign-safe": "corrected"}
"""Form of (1.16) by the name that the pages and the record give to its camber term."""
Numbers = dict[str, Any]


def study(executor: Any = None) -> Numbers | None:
    """All parts, and the checksums of the files that were read.

    Parameters
    ----------
    executor : not used: the study takes seconds

    Returns
    -------
    dict with ``numbers`` and ``inputs``, or None if the sample or the tool's answers to it are
    not here
    """
    folder = sample_folder()
    if folder is None or not (folder / TOOL_VELOCITIES).is_file():
        return None
    numbers: Numbers = {name: part(folder) for name, part in PARTS.items()}
    numbers["sample_sha256"] = sample_checksum(folder)
    return {"numbers": numbers, "inputs": checksums(folder)}


def checksums(folder: Path) -> dict[str, str]:
    """SHA-256 of the sample's files that are read, and of the tool's answers, by file name.

    Parameters
    ----------
    folder : the sample's

    Returns
    -------
    dict from name to 64 hexadecimal digits
    """
    tools = [TOOL_VELOCITIES, *(f.labels for f in LABEL_FILES if not f.bundled)]
    return {
        Path(name).name: hashlib.sha256((folder / name).read_bytes()).hexdigest()
        for name in (*SAMPLE_FILES, *tools)
        if (folder / name).is_file()
    }


def sample_checksum(folder: Path) -> str:
    """One SHA-256 over names and contents of the four files that are read of the public sample.

    Parameters
    ----------
    folder : the sample's

    Returns
    -------
    str of 64 hexadecimal digits
    """
    total = hashlib.sha256()
    for name in SAMPLE_FILES:
        path = folder / name
        total.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return total.hexdigest()


@lru_cache(maxsize=2)
def cached_sample(folder: Path) -> tuple[Sample, dict[Term, ChairVelocity]]:
    """Sample, and its velocities with either camber term, read and computed once.

    Parameters
    ----------
    folder : the sample's

    Returns
    -------
    Sample, dict from camber term to ChairVelocity
    """
    sample = load_sample(folder)
    return sample, {
        term: estimate_velocity(
            sample.trial, SAMPLE_CHAIR, sample.calibration.mount, VelocitySettings(form=form)
        )
        for term, form in FORMS.items()
    }


def mounting_numbers(folder: Path) -> Numbers:
    """How the sample's sensors sit, and what the printed equations make of it.

    Parameters
    ----------
    folder : the sample's

    Returns
    -------
    dict: z component of each axle in IMU axes, rate across the axles in percent, angle between
    the frame IMU's x and forward in degrees, size of the resting acceleration along the upward
    axis in m/s², and the printed velocity over the driven one
    """
    sample, _ = cached_sample(folder)
    mount = sample.calibration.mount
    forward, _, up = mount.rotation_frame_imu_to_chair
    x_level = np.array([1.0, 0.0, 0.0]) - up[0] * up
    askew = np.arctan2(np.linalg.norm(np.cross(x_level, forward)), x_level @ forward)
    return {
        "axle_z": {s: round(float(mount.rotation_imu_to_wheel(s)[2, 2]), 3) for s in SIDES},
        "largest_off_axle_percent": round(100 * max(sample.calibration.off_axle_share), 2),
        "x_beside_forward_deg": round(float(np.rad2deg(askew)), 2),
        "resting_along_imu_z_mps2": round(
            float(sample.static.sensor("frame").acc_mps2[:, 2].mean()), 2
        ),
        "resting_up": resting_direction(sample),
        "printed_velocity_over_driven": round(printed_velocity_gain(folder), 3),
    }


def resting_direction(sample: Sample) -> float:
    """Direction of the acceleration at rest, +1 upward, found without gravity.

    The right wheel is the faster one in a left turn, and left turns are positive about the
    vertical that points up: the wheels tell where up is.

    Parameters
    ----------
    sample : Sample

    Returns
    -------
    float, +1 or -1
    """
    resting = sample.static.sensor("frame").acc_mps2.mean(axis=0)
    about = sample.trial.gyroscope("frame") @ resting
    radius = SAMPLE_CHAIR.wheel_radius_m
    left, right = (
        sample.calibration.mount.wheel(side, sample.trial.gyroscope(f"{side}_wheel"))[:, 2]
        for side in SIDES
    )
    return float(np.sign((radius.right * right - radius.left * left) @ about))


def printed_velocity_gain(folder: Path) -> float:
    """Velocity by the printed (1.8), (1.9) and (1.17) over the driven one, least squares.

    The camber term is left out: it does not change the sign.

    Parameters
    ----------
    folder : the sample's

    Returns
    -------
    float
    """
    sample, velocity = cached_sample(folder)
    rates = wheel_rates_printed(sample.straight, sample.trial)
    printed = velocity_printed(rates.left[:, 2], rates.right[:, 2], SAMPLE_CHAIR)
    driven = velocity["sign-safe"].linear_velocity_mps
    return float(printed @ driven / (driven @ driven))


def velocity_numbers(folder: Path) -> Numbers:
    """What the sample's wheels and frame give with either camber term.

    Parameters
    ----------
    folder : the sample's

    Returns
    -------
    dict: length of the trial, median velocity, longest turn to the right in frames; by camber
    term the factor between the wheels' and the frame's yaw rate, the fraction of the speed beside
    it, the percentage of frames flagged as slip; with the tool's answers also the differences
    """
    sample, velocity = cached_sample(folder)
    tool = load_tool_velocities(folder)
    yaw_rate = velocity["printed"].yaw_rate_radps
    right = np.nonzero(np.r_[True, yaw_rate > -SMALLEST_TURN_RADPS, True])[0]
    numbers: Numbers = {
        "frames": len(sample.trial),
        "median_velocity_mps": round(
            float(np.median(velocity["sign-safe"].linear_velocity_mps)), 2
        ),
        "longest_right_turn_frames": int(np.diff(right).max()) - 1,
    }
    for term, found in velocity.items():
        factor, share = yaw_gain(
            found.yaw_rate_radps,
            found.wheel_yaw_rate_radps,
            found.linear_velocity_mps,
            side="left",
        )
        numbers[term] = {
            "yaw_factor_left_turns": round(factor, 3),
            "radii_apart_percent": round(100 * share * SAMPLE_CHAIR.track_m, 2),
            "slip_percent": round(100 * float(found.slip.mean()), 3),
        }
    if tool is not None:
        numbers["tool"] = _tool_differences(velocity, tool)
    return numbers


def _tool_differences(velocity: dict[Term, ChairVelocity], tool: ToolVelocities) -> Numbers:
    windows = detect_slip(tool.yaw_rate_radps, tool.wheel_yaw_rate_radps, 100.0)
    yaw = velocity["printed"].yaw_rate_radps - tool.yaw_rate_radps
    return {
        "largest_difference_mps": {
            term: round(largest(found.linear_velocity_mps - tool.linear_velocity_mps), 4)
            for term, found in velocity.items()
        },
        "largest_yaw_difference_degps": round(largest(np.rad2deg(yaw)), 4),
        "slip_windows": len(windows.first),
        "slip_frames": int(windows.flags(len(tool.yaw_rate_radps)).sum()),
    }


def largest(difference: Any) -> float:
    """Largest size in an array."""
    return float(np.abs(difference).max())


def slip_numbers(folder: Path) -> Numbers:
    """What the slip correction does to the sample with the sign-safe camber term.

    Parameters
    ----------
    folder : the sample's

    Returns
    -------
    dict: windows, corrected windows with their report, largest jumps of either wheel's speed in
    the last of them, m/s
    """
    sample, velocity = cached_sample(folder)
    plain = velocity["sign-safe"]
    mount = sample.calibration.mount
    best = estimate_velocity(
        sample.trial, SAMPLE_CHAIR, mount, VelocitySettings(slip_correction=True)
    )
    windows = detect_slip(plain.yaw_rate_radps, plain.wheel_yaw_rate_radps, 100.0)
    acc = mount.frame(sample.trial.sensor("frame").acc_mps2)[:, 0]
    wheels = wheel_speeds(
        plain.linear_velocity_mps, plain.wheel_yaw_rate_radps, plain.yaw_rate_radps, SAMPLE_CHAIR
    )
    report = slip_report(
        plain.linear_velocity_mps,
        best.linear_velocity_mps,
        windows,
        100.0,
        source=slip_sources(wheels, acc, windows, 100.0),
    )
    last = int(np.nonzero(report.corrected)[0][-1])
    near = slice(int(windows.first[last]) - 2, int(windows.first[last]) + 8)
    return {
        "windows": len(windows.first),
        "corrected_percent": round(100 * report.corrected_share, 2),
        "largest_change_mps": round(report.largest_change, 3),
        "corrected": report.to_frame()[report.corrected].round(3).to_dict("records"),
        "jumps_in_the_last_mps": {
            side: round(float(np.ptp(speed[near])), 2)
            for side, speed in (("left", wheels.left), ("right", wheels.right))
        },
    }


def task_numbers(folder: Path) -> Numbers:
    """Tasks found on the sample, run by run, and the frames labelled otherwise than by the tool.

    Parameters
    ----------
    folder : the sample's

    Returns
    -------
    dict: first frame and task code of each run; with the tool's answers the number of frames that
    differ, by series and settings
    """
    _, velocity = cached_sample(folder)
    found = velocity["sign-safe"]
    codes = identify_tasks(found).codes
    starts = changes_of(codes)
    numbers: Numbers = {
        "frames": len(codes),
        "run_starts": starts.tolist(),
        "run_codes": codes[starts].tolist(),
    }
    differing = {
        reference.what: differing_labels(reference, folder)
        for reference in LABEL_FILES
        if not reference.bundled and reference.folder(folder) is not None
    }
    if differing:
        numbers["differing_from_tool"] = differing
    return numbers


def choice_numbers(folder: Path) -> Numbers:
    """Frames of the sample's shipped velocities that each open choice labels otherwise.

    Parameters
    ----------
    folder : the sample's

    Returns
    -------
    dict from the choice in words to the number of frames
    """
    shipped = read_velocities(folder / SHIPPED_VELOCITIES)
    return dict(
        frames_changed(
            shipped.linear_velocity_mps, shipped.yaw_rate_radps, shipped.sampling_rate_hz
        )
    )


PARTS: dict[str, Callable[[Path], Numbers]] = {
    "mounting": mounting_numbers,
    "velocity": velocity_numbers,
    "slip": slip_numbers,
    "tasks": task_numbers,
    "choices": choice_numbers,
}
"""Parts of the record, each a function of the sample's folder."""
