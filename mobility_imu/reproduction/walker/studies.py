"""Walker (Doan & Pham): the calibration and the two walks repeated with simulated recordings.

The paper's recordings are not published. The simulated frame has the five mountings of Table 1, at
three levels of what goes wrong. The sensor's noise and its gyroscope's bias are from data sheets;
its other errors and all sizes of frame and user are ours, set by hand when the paper's tables were
known. :func:`sources` switches them on one at a time.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from mobility_imu.errors import InputError
from mobility_imu.executors import run_all
from mobility_imu.frames import STANDARD_GRAVITY_MPS2, FloatArray
from mobility_imu.reproduction.walker.tables import POSES, pose_mount
from mobility_imu.simulation import levels as levels_of_simulation
from mobility_imu.simulation.levels import DATASHEET as DATASHEET
from mobility_imu.simulation.levels import FOOTPRINT as FOOTPRINT
from mobility_imu.simulation.levels import tilt_run as tilt_run
from mobility_imu.simulation.levels import unit_of as unit_of
from mobility_imu.simulation.walker import (
    PERFECT,
    Imperfections,
    Leg,
    SimulatedWalker,
    WalkerMotion,
    attach_imu,
    simulate_tilts,
    simulate_walk,
)
from mobility_imu.walker.calibration import Method, calibrate_from_path
from mobility_imu.walker.follow import navigate_recording
from mobility_imu.walker.mount import WalkerMount
from mobility_imu.walker.navigation import ClosedLoop, NavigationSettings
from mobility_imu.walker.stillness import StillnessSettings
from mobility_imu.walker.tilt_equations import Form
from mobility_imu.walker.trajectory import trajectory_from_path

if TYPE_CHECKING:
    import pandas as pd

_DEG = float(np.deg2rad(1))


@dataclass(frozen=True)
class Level(levels_of_simulation.Level):
    """What goes wrong in a simulation, and the settings that its recordings are judged with.

    Parameters
    ----------
    sensor : SensorModel
    imperfections : Imperfections of tilting and walking
    stillness : StillnessSettings of the detector
    navigation : NavigationSettings of the filter
    """

    stillness: StillnessSettings = field(default_factory=StillnessSettings)
    navigation: NavigationSettings = field(default_factory=NavigationSettings)


LEVELS = {
    name: Level(level.sensor, level.imperfections)
    for name, level in levels_of_simulation.LEVELS.items()
}
"""The levels of :mod:`mobility_imu.simulation.levels`, judged with the standard settings."""


class Variant(NamedTuple):
    """A way to calibrate.

    Parameters
    ----------
    name : str
    smooth : whether the smoother follows the filter
    method, form : as in :func:`mobility_imu.walker.calibration.calibrate_mount`
    velocity_tilt_deg : deg, tilt at which "two-tilts" takes the velocity. Eqs 16-17 ask for the
        velocity at the start, which is zero, and the paper gives no later moment: this is ours
    """

    name: str
    smooth: bool
    method: Method
    form: Form
    velocity_tilt_deg: float = 3.0


METHOD_1, METHOD_1_ROOTLESS = "method 1, eq. 15 printed", "method 1, without roots"
METHOD_2_TILTS_DEG = (1.0, 2.0, 3.0, 5.0)


def method_2(tilt_deg: float) -> str:
    """Name of method 2, eqs 16-19 as printed, with the velocity taken at a tilt in deg.

    Examples
    --------
    >>> method_2(3)
    'method 2, velocity taken at 3 deg'
    """
    return f"method 2, velocity taken at {tilt_deg:g} deg"


_WAYS: tuple[tuple[str, Method, Form, float], ...] = (
    (METHOD_1, "four-tilts", "printed", 3.0),
    (METHOD_1_ROOTLESS, "four-tilts", "corrected", 3.0),
    *((method_2(tilt), "two-tilts", "printed", tilt) for tilt in METHOD_2_TILTS_DEG),
    ("method 2, tilt added back", "two-tilts", "corrected", 3.0),
    ("all samples", "all-samples", "corrected", 3.0),
)
VARIANTS = tuple(
    Variant(name, smooth, method, form, tilt_deg)
    for smooth in (False, True)
    for name, method, form, tilt_deg in _WAYS
)
"""The paper's two methods as printed and corrected, and the fit; filter alone, then smoothed."""
PAPERS_WAY = tuple(
    v for v in VARIANTS if not v.smooth and v.name in (METHOD_1, METHOD_1_ROOTLESS, method_2(3))
)
"""The filter alone. Method 1 as printed, the same without roots (for runs in which eq. 15 has no
real root), and method 2 as printed, its velocity taken at 3 deg."""


def calibration_study(
    seeds: Iterable[int],
    levels: Mapping[str, Level] = LEVELS,
    *,
    variants: Sequence[Variant] = VARIANTS,
    poses: Sequence[str] = POSES,
    executor: Any = None,
) -> pd.DataFrame:
    """Calibrate simulated recordings in several ways.

    Parameters
    ----------
    seeds : one per repetition
    levels : name to Level
    variants : ways to calibrate
    poses : mountings of Table 1
    executor : anything with ``submit``; None works in this process

    Returns
    -------
    DataFrame, one row per level, seed, pose and variant: x_m, y_m, z_m as found, error_x_m,
    error_y_m, error_z_m, error_m (3-D), turn_deg (error of the rotation), heading_deg (its part
    about the vertical); NaN where the method gave none
    """
    import pandas as pd

    work = partial(_calibrate_seed, levels=dict(levels), variants=variants, poses=poses)
    return pd.DataFrame(spread(work, seeds, executor))


def _calibrate_seed(
    seed: int, levels: Mapping[str, Level], variants: Sequence[Variant], poses: Sequence[str]
) -> list[dict[str, Any]]:
    rows = []
    for name, level in levels.items():
        motion = simulate_tilts(FOOTPRINT, seed=seed, imperfections=level.imperfections)
        for pose in poses:
            run, tape = tilt_run(seed, pose, level, motion)
            for smooth in dict.fromkeys(variant.smooth for variant in variants):
                path, _ = navigate_recording(
                    run.recording,
                    smooth=smooth,
                    settings=level.navigation,
                    stillness=level.stillness,
                )
                for variant in variants:
                    if variant.smooth != smooth:
                        continue
                    key = {"level": name, "seed": seed, "pose": pose, **variant._asdict()}
                    try:
                        found = calibrate_from_path(
                            path,
                            tape,
                            method=variant.method,
                            form=variant.form,
                            velocity_tilt_rad=variant.velocity_tilt_deg * _DEG,
                        ).mount
                    except InputError:
                        rows.append(key)
                        continue
                    rows.append(key | _against(found, run.mount))
    return rows


def _against(found: WalkerMount, true: WalkerMount) -> dict[str, float]:
    place, off = found.translation_body_m, found.translation_body_m - true.translation_body_m
    turn = Rotation.from_matrix(found.rotation_imu_to_body @ true.rotation_imu_to_body.T)
    return {
        **{f"{axis}_m": float(place[k]) for k, axis in enumerate("xyz")},
        **{f"error_{axis}_m": float(off[k]) for k, axis in enumerate("xyz")},
        "error_m": float(np.linalg.norm(off)),
        "turn_deg": float(np.rad2deg(turn.magnitude())),
        "heading_deg": float(np.rad2deg(turn.as_rotvec()[2])),
    }


def walking_study(
    seeds: Iterable[int],
    course: tuple[Leg, ...],
    levels: Mapping[str, Level] = LEVELS,
    *,
    smooth: bool = True,
    poses: Sequence[str] = POSES,
    positions: pd.DataFrame | None = None,
    closed_loop: ClosedLoop | None = None,
    executor: Any = None,
) -> pd.DataFrame:
    """Follow simulated walks.

    Parameters
    ----------
    seeds : one per repetition
    course : what is walked, see ``mobility_imu.simulation.walker``
    levels : name to Level
    smooth : whether to smooth
    poses : mountings of Table 1
    positions : what :func:`calibration_study` found, to place the frame with them as well
    closed_loop : constraint for the smoother, see
        :class:`mobility_imu.walker.navigation.ClosedLoop`
    executor : anything with ``submit``; None works in this process

    Returns
    -------
    DataFrame, one row per level, seed, pose and source of the IMU's position ("true", or a
    variant's name): arm_x_m and arm_y_m of that position, distance_m and true_distance_m between
    start and end, closing_x_m, closing_y_m (end less start, in the frame's axes at the start) and
    closing_m (their length), height_m (of the end over the start), end_m (on the floor, from the
    true end), heading_deg (error at the end), mixed_x_m, mixed_y_m, mixed_m (from the IMU's start
    to the frame's end), corner_m (error before the last turn), rms_m over the walk
    """
    import pandas as pd

    known: dict[tuple[str, int, str], dict[str, FloatArray]] = {}
    if positions is not None:
        for row in positions.to_dict("records"):
            place = np.array([row["x_m"], row["y_m"], row["z_m"]])
            key = (row["level"], row["seed"], row["pose"])
            known.setdefault(key, {})[str(row["name"])] = place
    work = partial(
        _walk_seed,
        course=course,
        levels=dict(levels),
        smooth=smooth,
        poses=poses,
        known=known,
        closed_loop=closed_loop,
    )
    return pd.DataFrame(spread(work, seeds, executor))


def _walk_seed(
    seed: int,
    course: tuple[Leg, ...],
    levels: Mapping[str, Level],
    smooth: bool,
    poses: Sequence[str],
    known: Mapping[tuple[str, int, str], dict[str, FloatArray]],
    closed_loop: ClosedLoop | None,
) -> list[dict[str, Any]]:
    rows = []
    motions: dict[Imperfections, WalkerMotion] = {}
    for name, level in levels.items():
        frame = level.imperfections
        if frame not in motions:
            motions[frame] = simulate_walk(course, seed=seed, imperfections=frame)
        motion = motions[frame]
        for pose in poses:
            mount, unit = pose_mount(pose), unit_of(seed, pose)
            run = attach_imu(motion, mount, level.sensor, seed=unit, unit_seed=unit)
            path, _ = navigate_recording(
                run.recording,
                smooth=smooth,
                settings=level.navigation,
                stillness=level.stillness,
                closed_loop=closed_loop,
            )
            offset = len(run.time_s) - len(path.time_s)
            places = {"true": mount.translation_body_m, **known.get((name, seed, pose), {})}
            for source, place in places.items():
                if not np.isfinite(place).all():
                    continue
                guess = WalkerMount(mount.rotation_imu_to_body, place)
                found = trajectory_from_path(path, guess)
                rows.append(
                    {
                        "level": name,
                        "seed": seed,
                        "pose": pose,
                        "source": source,
                        "arm_x_m": float(place[0]),
                        "arm_y_m": float(place[1]),
                        **_walk_errors(run, offset, found.position_m, found.yaw_rad, place),
                    }
                )
    return rows


def _walk_errors(
    run: SimulatedWalker, offset: int, found: FloatArray, yaw: FloatArray, place: FloatArray
) -> dict[str, float]:
    true = run.position_body_m[offset:] - run.position_body_m[offset]
    off = (found - true)[:, :2]
    forward = run.rotation_body_to_world[-1, :2, 0]
    turned = yaw[-1] - np.arctan2(forward[1], forward[0])
    # The last moment at rest before the walk's last turn, if it turns.
    turning = [step.lift_s for step in run.steps if abs(step.turn_rad) > 0.1]
    last = max(turning, default=None)
    corner = np.nan
    if last is not None:
        final = [t for t in turning if last - t < 15]
        k = int(np.searchsorted(run.time_s[offset:], min(final))) - 1
        corner = float(np.linalg.norm(off[k]))
    end = found[-1]
    # r_N - C_N T - r_1: only the end is corrected for the lever arm. At the start the IMU is at T,
    # seen from where the frame stands.
    mixed = end[:2] - place[:2]
    return {
        "distance_m": float(np.linalg.norm(end)),
        "true_distance_m": float(np.linalg.norm(true[-1])),
        "closing_x_m": float(end[0]),
        "closing_y_m": float(end[1]),
        "closing_m": float(np.linalg.norm(end[:2])),
        "height_m": float(end[2]),
        "end_m": float(np.linalg.norm(off[-1])),
        "heading_deg": float(np.rad2deg(np.angle(np.exp(1j * turned)))),
        "mixed_x_m": float(mixed[0]),
        "mixed_y_m": float(mixed[1]),
        "mixed_m": float(np.linalg.norm(mixed)),
        "corner_m": corner,
        "rms_m": float(np.sqrt(np.mean(np.sum(off**2, axis=1)))),
    }


def spread(
    work: Callable[[int], list[dict[str, Any]]], seeds: Iterable[int], executor: Any
) -> list[dict[str, Any]]:
    """Rows of all seeds, in their order, computed here or by an executor.

    Parameters
    ----------
    work : function of a seed that returns rows
    seeds : one per repetition
    executor : anything with ``submit``; None works in this process
    """
    return [row for rows in run_all(work, [(seed,) for seed in seeds], executor) for row in rows]


def sources() -> dict[str, Level]:
    """Levels with one source of error each, on top of the data sheet."""
    plain = Level(DATASHEET)

    def sensor(**sizes: Any) -> Level:
        both = {k: v for k, v in sizes.items() if k != "g_sensitivity_sd"}
        model = replace(
            DATASHEET, acc=replace(DATASHEET.acc, **both), gyr=replace(DATASHEET.gyr, **both)
        )
        if "g_sensitivity_sd" in sizes:
            model = replace(model, g_sensitivity_sd=sizes["g_sensitivity_sd"])
        return Level(model)

    def frame(**sizes: Any) -> Level:
        return Level(DATASHEET, replace(PERFECT, **sizes))

    def detector(rate: float, acc: float) -> Level:
        return Level(
            DATASHEET, stillness=StillnessSettings(rate_radps=rate, acc_deviation_mps2=acc)
        )

    def navigation(**choice: Any) -> Level:
        return Level(DATASHEET, navigation=NavigationSettings(**choice))

    return {
        "none": plain,
        "scale factors 0.3 %": sensor(scale_sd=0.003),
        "scale factors 1 %": sensor(scale_sd=0.01),
        "misalignment 0.1 deg": sensor(misalignment_sd_rad=0.1 * _DEG),
        "misalignment 0.5 deg": sensor(misalignment_sd_rad=0.5 * _DEG),
        "g-sensitivity 0.001 deg/s/g": sensor(
            g_sensitivity_sd=0.001 * _DEG / STANDARD_GRAVITY_MPS2
        ),
        "rocking 0.06 deg": frame(rocking_rad=0.06 * _DEG),
        "rocking 0.15 deg": frame(rocking_rad=0.15 * _DEG),
        "creep 2 mm per step": frame(creep_sd_m=0.002),
        "creep 10 mm per step": frame(creep_sd_m=0.010),
        "landing at 0.02 m/s": frame(landing_mps=0.02),
        "landing at 0.10 m/s": frame(landing_mps=0.10),
        "ringing 1 m/s² after landing": frame(landing_ringing_mps2=1.0),
        "ringing 4 m/s² after landing": frame(landing_ringing_mps2=4.0),
        "placement 3 cm": frame(placement_sd_m=0.03),
        "placement 10 cm": frame(placement_sd_m=0.10),
        "detector 0.08 rad/s, 0.5 m/s²": detector(0.08, 0.5),
        "detector 0.15 rad/s, 0.9 m/s²": detector(0.15, 0.9),
        "eq. 24 corrected, no zero-rate": navigation(zero_rate=False),
        "eq. 24 printed": navigation(form="printed"),
        "eq. 24 printed, no zero-rate": navigation(form="printed", zero_rate=False),
        "eq. 24 printed, no zero-rate, no gyro mean": navigation(
            form="printed", zero_rate=False, initial_gyr_mean=False
        ),
        "eq. 24 corrected, no zero-rate, no gyro mean": navigation(
            zero_rate=False, initial_gyr_mean=False
        ),
    }
