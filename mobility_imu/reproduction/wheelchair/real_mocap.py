"""Sports chairs against motion capture: what the record ``real_chair_mocap`` holds.

Twenty trials of seven people; a sensor on the frame and one on the right wheel. Radius and half
track are fitted from the motion capture, and so is one shift of the clocks per trial.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from mobility_imu.filters import rms
from mobility_imu.frames import FloatArray
from mobility_imu.readers import read_recording
from mobility_imu.recording import Recording
from mobility_imu.reproduction.real_files import Numbers, checksums
from mobility_imu.reproduction.wheelchair.real_common import (
    INSIDE,
    Against,
    against,
    in_degrees,
    low_passed,
    offset_numbers,
    ratio_fractions,
    recorded_study,
    rounded,
    spectrum,
    spread,
)
from mobility_imu.results import Result
from mobility_imu.runs import runs_of
from mobility_imu.simulation.sensor import MTI_1, REAL, SensorModel
from mobility_imu.simulation.wheelchair import random_court
from mobility_imu.wheelchair.calibration import WheelchairCalibration, calibrate_mount
from mobility_imu.wheelchair.geometry import WheelchairGeometry
from mobility_imu.wheelchair.tasks import task_codes
from mobility_imu.wheelchair.uncertainty import AssumedErrors
from mobility_imu.wheelchair.velocity import ChairVelocity, VelocitySettings, estimate_velocity

DATASET, RECORD = "mocap-chair", "real_chair_mocap"
CUTOFF_HZ = 3.0
"""The reference was low-passed so, forward and backward."""
ONE_CHAIR = ("P03", "P05", "P07")
"""People who sat in one kind of chair; the others each had their own."""
SHORTEST_LABELLED_S = 3.0
MOVING_MPS = 0.2
SERIES_STEP_S = 0.1
SIMULATED_SEEDS = range(20)
SPECTRA = {"P03": "P03_slalom_hs", "P09": "P09_slalom_ls"}
"""One person of each day, with a trial that moves all the time."""


@dataclass(frozen=True, eq=False, repr=False)
class Trial(Result):
    """One trial beside the motion capture.

    Parameters
    ----------
    name : of the trial
    chair : WheelchairGeometry
    calibration : from the person's static and straight cut
    recording : Recording
    drive : ChairVelocity
    speed, yaw_rate : Against, m/s and rad/s
    pitch_radps : (n,) array, rad/s, the frame's rate about the chair's y, at the reference's times
    wheel_radps, turn_radps : (n,) arrays, rad/s, the wheel's and the frame's gyroscope likewise
    true_time_s, true_speed_mps, true_yaw_radps : (m,) arrays, the whole reference
    """

    name: str
    chair: WheelchairGeometry
    calibration: WheelchairCalibration
    recording: Recording
    drive: ChairVelocity
    speed: Against
    yaw_rate: Against
    pitch_radps: FloatArray
    wheel_radps: FloatArray
    turn_radps: FloatArray
    true_time_s: FloatArray
    true_speed_mps: FloatArray
    true_yaw_radps: FloatArray

    @property
    def person(self) -> str:
        """Who sat in the chair."""
        return self.name[:3]


def trial_names(folder: Path) -> list[str]:
    """Trials of a folder that have a reference.

    Parameters
    ----------
    folder : of the data set

    Returns
    -------
    list of str
    """
    ending = "_truth.csv.gz"
    return [path.name.removesuffix(ending) for path in sorted(folder.glob(f"*{ending}"))]


def is_held_back(name: str) -> bool:
    """Whether a trial was not looked at until the settings were fixed: people with even numbers.

    Parameters
    ----------
    name : of the trial

    Returns
    -------
    bool
    """
    return int(name[1:3]) % 2 == 0


def load_trial(folder: Path, name: str) -> Trial:
    """Read a trial, calibrate with the person's own cuts, find speed and yaw rate.

    Parameters
    ----------
    folder : of the data set
    name : of the trial, with the subfolder that it is in; what its person's trials share is in the
        folder itself, or else in that subfolder

    Returns
    -------
    Trial
    """
    place, _, label = name.rpartition("/")
    person = label[:3]
    own = folder if (folder / f"{person}_static.csv.gz").is_file() else folder / place
    static, straight, recording = (
        read_recording(path)
        for path in (
            own / f"{person}_static.csv.gz",
            own / f"{person}_straight.csv.gz",
            folder / f"{name}.csv.gz",
        )
    )
    chair = WheelchairGeometry.from_toml(own / f"{person}_geometry.toml")
    cal = calibrate_mount(static, straight)
    drive = estimate_velocity(recording, chair, cal.mount, offsets=cal.offsets)
    truth = pd.read_csv(folder / f"{name}_truth.csv.gz")
    time_s, speed, yaw = (truth[c].to_numpy(float) for c in truth.columns[:3])
    rate = drive.sampling_rate_hz

    def beside(true: FloatArray, found: FloatArray, sd: FloatArray) -> Against:
        found = low_passed(found, rate, CUTOFF_HZ)
        return against(time_s, true, drive.time_s, found, sd)

    zeros = np.zeros(len(drive))
    gyr = recording.gyroscope("frame") - drive.offsets["frame"].offset_radps
    wheel = recording.gyroscope("right_wheel") - drive.offsets["right_wheel"].offset_radps
    about = cal.mount.frame(gyr)
    return Trial(
        name=label,
        chair=chair,
        calibration=cal,
        recording=recording,
        drive=drive,
        speed=beside(speed, drive.linear_velocity_mps, drive.linear_velocity_sd_mps),
        yaw_rate=beside(yaw, drive.yaw_rate_radps, drive.yaw_rate_sd_radps),
        pitch_radps=beside(speed, about[:, 1], zeros).found,
        wheel_radps=beside(speed, cal.mount.wheel("right", wheel)[:, 2], zeros).found,
        turn_radps=beside(speed, about[:, 2], zeros).found,
        true_time_s=time_s,
        true_speed_mps=speed,
        true_yaw_radps=yaw,
    )


def rocking_height(trial: Trial) -> float:
    """Height over the axle at which the pitch rate explains the speed's error best, m.

    A point above the axle moves forward when the chair pitches forward; the wheels do not see it.

    Parameters
    ----------
    trial : Trial

    Returns
    -------
    float, m
    """
    return float(-(trial.pitch_radps @ trial.speed.error) / (trial.pitch_radps @ trial.pitch_radps))


def gyroscope_part(trial: Trial) -> float:
    """Fraction of the yaw rates' difference (variance) that is the gyroscope's, by the speed.

    The frame's yaw rate carries the speed from the wheel to the middle. An error of the gyroscope
    comes back in the speed, times the distance of the wheel; an error of the reference does not.

    Parameters
    ----------
    trial : Trial

    Returns
    -------
    float; 1 if all is the gyroscope's, 0 if all is the reference's, scattering about these
    """
    error = trial.yaw_rate.error
    centre = float(trial.chair.wheel_centre("right")[1])
    slope = (error - error.mean()) @ (trial.speed.error - trial.speed.error.mean())
    return float(slope / np.sum(np.square(error - error.mean())) / centre)


def held_out(trials: list[Trial]) -> dict[str, float]:
    """Speed's error with radius and half track of other trials of the same chair.

    In the chair that three people had, those of the two others; otherwise the person's own other
    trials. People with a single trial are left out.

    Parameters
    ----------
    trials : every trial

    Returns
    -------
    dict from trial to root mean square, m/s
    """
    found = {}
    for one in trials:
        if one.person in ONE_CHAIR:
            others = [t for t in trials if t.person in ONE_CHAIR and t.person != one.person]
        else:
            others = [t for t in trials if t.person == one.person and t is not one]
        if others:
            design = np.vstack([np.column_stack([t.wheel_radps, t.turn_radps]) for t in others])
            sizes = np.linalg.lstsq(design, np.concatenate([t.speed.true for t in others]))[0]
            speed = np.column_stack([one.wheel_radps, one.turn_radps]) @ sizes
            found[one.name] = rms(speed - one.speed.true)
    return found


def labels_alike(trial: Trial) -> tuple[int, int]:
    """Frames that get the same task from our speeds as from the motion capture's.

    Only where the reference has no gap for three seconds or more.

    Parameters
    ----------
    trial : Trial

    Returns
    -------
    frames compared, frames alike
    """
    drive, rate = trial.drive, trial.drive.sampling_rate_hz
    frames, alike = 0, 0
    for run in runs_of(np.isfinite(trial.true_speed_mps)):
        if run.stop - run.start < SHORTEST_LABELLED_S * rate:
            continue
        time_s = trial.true_time_s[run]
        speed, yaw = (
            np.interp(time_s, drive.time_s, low_passed(values, rate, CUTOFF_HZ))
            for values in (drive.linear_velocity_mps, drive.yaw_rate_radps)
        )
        true = task_codes(trial.true_speed_mps[run], trial.true_yaw_radps[run], rate)
        same = task_codes(speed, yaw, rate) == true
        frames, alike = frames + len(same), alike + int(same.sum())
    return frames, alike


def inside_without_height(trial: Trial) -> float:
    """Coverage of the speed's 95 % interval if the axle itself were meant, with no height.

    Parameters
    ----------
    trial : Trial

    Returns
    -------
    float, fraction of the samples
    """
    axle = VelocitySettings(assumed=AssumedErrors(point_height_m=0.0))
    drive = estimate_velocity(
        trial.recording,
        trial.chair,
        trial.calibration.mount,
        axle,
        offsets=trial.calibration.offsets,
    )
    sd = np.interp(trial.speed.time_s, drive.time_s, drive.linear_velocity_sd_mps)
    return float(np.mean(np.abs(trial.speed.error) < INSIDE * sd))


def trial_row(trial: Trial) -> Numbers:
    """Row of the record of one trial.

    Parameters
    ----------
    trial : Trial

    Returns
    -------
    dict
    """
    speed, yaw, chair = trial.speed, trial.yaw_rate, trial.chair
    centre = chair.wheel_centre("right")[1]
    height = trial.drive.settings.assumed.point_height_m
    rocking = -height * trial.pitch_radps
    wheel_alone = speed.found - centre * trial.turn_radps
    frames, alike = labels_alike(trial)
    return {
        "trial": trial.name,
        "seconds": len(trial.recording) / trial.drive.sampling_rate_hz,
        "seconds_with_truth": float(speed.step_s.sum()),
        "way_m": float(np.abs(speed.true) @ speed.step_s),
        "fastest_mps": float(np.abs(speed.true).max()),
        "speed": speed.summary(),
        "path_ratio": speed.path_ratio,
        "speed_rms_without_rocking_mps": rms(speed.error - rocking),
        "speed_inside_without_height": inside_without_height(trial),
        "rocking_height_m": rocking_height(trial),
        "speed_rms_wheel_alone_mps": rms(wheel_alone - speed.true),
        "yaw_rate_degps": in_degrees(yaw).summary(),
        "yaw_gain": float(yaw.true @ yaw.found / (yaw.true @ yaw.true)),
        "yaw_gyroscope_part": gyroscope_part(trial),
        "offsets": offset_numbers(trial.drive.offsets),
        "task_frames": frames,
        "tasks_alike": alike / frames if frames else float("nan"),
        "warnings": len(trial.drive.warnings),
    }


def summary_of(rows: list[Numbers], trials: list[Trial]) -> Numbers:
    """Numbers over all trials.

    Parameters
    ----------
    rows : of the trials
    trials : Trials, in the order of the rows

    Returns
    -------
    dict
    """
    ratios = np.concatenate([t.speed.error / t.speed.sd for t in trials])
    yaw_ratios = np.concatenate([t.yaw_rate.error / t.yaw_rate.sd for t in trials])
    parts = np.array([row["yaw_gyroscope_part"] for row in rows])
    held = [row["speed_rms_held_out_mps"] for row in rows if "speed_rms_held_out_mps" in row]
    return {
        "recordings": len(rows),
        "people": len({t.person for t in trials}),
        "refused": 0,
        "speed_rms_mps": spread(row["speed"]["rms"] for row in rows),
        "speed_rms_without_rocking_mps": spread(
            row["speed_rms_without_rocking_mps"] for row in rows
        ),
        "speed_rms_held_out_mps": spread(held) | {"recordings": len(held)},
        "speed_rms_wheel_alone_mps": spread(row["speed_rms_wheel_alone_mps"] for row in rows),
        "rocking_height_m": spread(row["rocking_height_m"] for row in rows),
        "path_ratio": spread(row["path_ratio"] for row in rows),
        "speed_sd_over_rms": spread(row["speed"]["sd_over_rms"] for row in rows),
        "speed_inside": float(np.mean(np.abs(ratios) < INSIDE)),
        "speed_inside_without_height": float(
            np.average(
                [row["speed_inside_without_height"] for row in rows],
                weights=[row["speed"]["samples"] for row in rows],
            )
        ),
        "speed_ratio_fractions": ratio_fractions(ratios),
        "yaw_rate_rms_degps": spread(row["yaw_rate_degps"]["rms"] for row in rows),
        "yaw_rate_sd_degps": spread(row["yaw_rate_degps"]["sd_median"] for row in rows),
        "yaw_rate_inside": float(np.mean(np.abs(yaw_ratios) < INSIDE)),
        "yaw_rate_ratio_fractions": ratio_fractions(yaw_ratios),
        "yaw_gain": spread(row["yaw_gain"] for row in rows),
        "yaw_gyroscope_part": float(parts.mean()),
        "yaw_gyroscope_part_sd": float(parts.std(ddof=1) / np.sqrt(len(parts))),
        "task_frames": sum(row["task_frames"] for row in rows),
        "tasks_alike": float(
            sum(row["tasks_alike"] * row["task_frames"] for row in rows if row["task_frames"])
            / sum(row["task_frames"] for row in rows)
        ),
    }


def trial_series(trial: Trial) -> Numbers:
    """Speed's error over time, ten times a second.

    Parameters
    ----------
    trial : Trial

    Returns
    -------
    dict of lists: ``time_s``, ``true_mps``, ``error_mps``, ``sd_mps``, ``rocking_mps``
    """
    speed = trial.speed
    step = round(SERIES_STEP_S * trial.drive.sampling_rate_hz)
    height = trial.drive.settings.assumed.point_height_m
    columns = {
        "time_s": speed.time_s,
        "true_mps": speed.true,
        "error_mps": speed.error,
        "sd_mps": speed.sd,
        "rocking_mps": -height * trial.pitch_radps,
    }
    return {name: [round(float(v), 4) for v in values[::step]] for name, values in columns.items()}


def sensor_spectra(folder: Path, trials: dict[str, Trial]) -> Numbers:
    """Spectra of the frame's sensor at rest and while the chair moves, of one person a day.

    Parameters
    ----------
    folder : of the data set
    trials : by their names

    Returns
    -------
    dict from person to dict of ``rest_acc``, ``moving_acc`` (m/s² per root hertz, upward) and
    ``rest_gyr``, ``moving_gyr`` (deg/s per root hertz, pitch rate)
    """
    found: Numbers = {}
    for person, name in SPECTRA.items():
        if name not in trials:
            continue
        trial = trials[name]
        mount = trial.calibration.mount
        for state, recording in (
            ("rest", read_recording(folder / f"{person}_static.csv.gz")),
            ("moving", trial.recording),
        ):
            moving = None
            if state == "moving":
                moving = np.abs(trial.drive.linear_velocity_mps) > MOVING_MPS
            rate = recording.sampling_rate_hz
            up = mount.frame(recording.sensor("frame").acc_mps2)[:, 2]
            pitch = np.rad2deg(mount.frame(recording.gyroscope("frame"))[:, 1])
            found.setdefault(person, {}).update(
                {
                    f"{state}_acc": spectrum(up, rate, moving),
                    f"{state}_gyr": spectrum(pitch, rate, moving),
                }
            )
    return found


def simulated(model: SensorModel = MTI_1) -> Numbers:
    """Simulated courts, judged alike: one wheel and the frame, 50 Hz, exact geometry, no slip.

    Parameters
    ----------
    model : of both sensors

    Returns
    -------
    dict with ``speed_rms_mps``, ``path_ratio``, ``yaw_rate_rms_degps``, ``speed_inside``
    """
    rows, ratios, yaws, paths = [], [], [], []
    for seed in SIMULATED_SEEDS:
        court = random_court(seed, slips=0, largest_toe_rad=0.0)
        static, straight = court.calibration_trials(model, sampling_rate_hz=50.0)
        cal = calibrate_mount(static.recording, straight.recording)
        run = court.drive(model, sampling_rate_hz=50.0)
        sensors = {k: v for k, v in run.recording.sensors.items() if k != "left_wheel"}
        one = Recording(run.recording.time_s, sensors)
        drive = estimate_velocity(one, court.geometry, cal.mount, offsets=cal.offsets)
        pairs = (
            (run.linear_velocity_mps, drive.linear_velocity_mps, drive.linear_velocity_sd_mps),
            (run.yaw_rate_radps, drive.yaw_rate_radps, drive.yaw_rate_sd_radps),
        )
        speed, yaw = (
            against(
                drive.time_s,
                low_passed(true, 50.0, CUTOFF_HZ),
                drive.time_s,
                low_passed(found, 50.0, CUTOFF_HZ),
                sd,
            )
            for true, found, sd in pairs
        )
        rows.append(rms(speed.error))
        yaws.append(float(np.rad2deg(rms(yaw.error))))
        paths.append(speed.path_ratio)
        ratios.append(speed.error / speed.sd)
    return {
        "recordings": len(rows),
        "speed_rms_mps": spread(rows),
        "path_ratio": spread(paths),
        "yaw_rate_rms_degps": spread(yaws),
        "speed_inside": float(np.mean(np.abs(np.concatenate(ratios)) < INSIDE)),
    }


def real_numbers(folder: Path, names: list[str] | None = None) -> Numbers:
    """Numbers of the record that come from the recordings alone.

    Parameters
    ----------
    folder : of the data set
    names : trials that are looked at; None takes all that were not held back

    Returns
    -------
    dict with ``files``, ``rows``, ``summary``, ``series``, ``spectra``
    """
    names = names or [name for name in trial_names(folder) if not is_held_back(name)]
    trials = [load_trial(folder, name) for name in names]
    held = held_out(trials)
    rows = [
        trial_row(t) | ({"speed_rms_held_out_mps": held[t.name]} if t.name in held else {})
        for t in trials
    ]
    in_order = sorted(trials, key=lambda t: rms(t.speed.error))
    shown = {"middle": in_order[len(in_order) // 2], "worst": in_order[-1]}
    people = sorted({t.person for t in trials})
    files = [
        *(f"{t.name}{end}.csv.gz" for t in trials for end in ("", "_truth")),
        *(f"{p}_{part}" for p in people for part in ("static.csv.gz", "straight.csv.gz")),
        *(f"{p}_geometry.toml" for p in people),
    ]
    return {
        "files": checksums(folder, files),
        "rows": rounded(rows),
        "summary": rounded(summary_of(rows, trials)),
        "series": {kind: {"trial": t.name, **trial_series(t)} for kind, t in shown.items()},
        "spectra": rounded(sensor_spectra(folder, {t.name: t for t in trials})),
    }


def study(executor: Any = None) -> Numbers | None:
    """All numbers of the record, those of the simulation beside them.

    Parameters
    ----------
    executor : not used: the study takes seconds

    Returns
    -------
    dict with ``numbers`` and ``inputs``, or None if the data set is not here
    """
    return recorded_study(
        DATASET,
        RECORD,
        real_numbers,
        {"simulated": simulated, "simulated_as_real": lambda: simulated(REAL)},
    )
