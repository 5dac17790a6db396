"""Walker: what spoils a calibration by tilting, one thing at a time, and what the tables look like.

Small studies of the chapters on the calibration; the large ones, in ``studies``, are recorded.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from mobility_imu.filters import rms
from mobility_imu.frames import FloatArray
from mobility_imu.recording import Imu, Recording
from mobility_imu.reproduction.walker.studies import (
    DATASHEET,
    FOOTPRINT,
    METHOD_1,
    METHOD_1_ROOTLESS,
    VARIANTS,
    Level,
    calibration_study,
    method_2,
    tilt_run,
)
from mobility_imu.reproduction.walker.tables import POSES, pose_mount, pose_translation
from mobility_imu.simulation.sensor import IDEAL
from mobility_imu.simulation.walker import (
    Imperfections,
    SimulatedWalker,
    attach_imu,
    simulate_tilts,
)
from mobility_imu.walker.calibration import calibrate_from_path
from mobility_imu.walker.follow import navigate_recording
from mobility_imu.walker.geometry import TiltDirection, WalkerGeometry
from mobility_imu.walker.navigation import Navigation
from mobility_imu.walker.tilt_equations import Form, position_gain

if TYPE_CHECKING:
    import pandas as pd

__all__ = [
    "SIZES",
    "TiltPath",
    "edge_distances",
    "first_part",
    "gain_table",
    "late_velocity_bias",
    "source_table",
    "table_1_simulated",
    "tilt_paths",
    "tilts_on_a_slope",
]

_DEG = float(np.deg2rad(1))
FORMS: tuple[Form, ...] = ("printed", "corrected")

SIZES: dict[str, Imperfections] = {
    "none": Imperfections(),
    "edge slips 5 mm": Imperfections(edge_slip_m=0.005),
    "edge slips 15 mm": Imperfections(edge_slip_m=0.015),
    "frame twists 1°": Imperfections(edge_twist_rad=_DEG),
    "frame twists 3°": Imperfections(edge_twist_rad=3 * _DEG),
    "tips turn 15 mm outside": Imperfections(ferrule_edge_m=0.015),
    "tips turn 30 mm outside": Imperfections(ferrule_edge_m=0.030),
    "tape errs by 5 mm": Imperfections(tape_m=0.005),
    "tape errs by 15 mm": Imperfections(tape_m=0.015),
    "hold trembles 0.3°": Imperfections(hold_tremor_rad=0.3 * _DEG),
    "hold trembles 0.6°": Imperfections(hold_tremor_rad=0.6 * _DEG),
}
"""What may go wrong with frame and user; all sizes are assumptions."""


class TiltPath(NamedTuple):
    """A simulated recording of tilts, the geometry by tape, and the path of the IMU."""

    run: SimulatedWalker
    tape: WalkerGeometry
    path: Navigation


def tilt_paths(
    seeds: Iterable[int], level: Level, *, poses: Sequence[str] = POSES
) -> list[TiltPath]:
    """Tilts of each pose and seed, with filter and smoother.

    Parameters
    ----------
    seeds : one per repetition; the poses of one seed are neighbours
    level : what goes wrong
    poses : mountings of Table 1

    Returns
    -------
    list of TiltPath
    """
    runs = [tilt_run(seed, pose, level) for seed in seeds for pose in poses]
    return [TiltPath(run, tape, navigate_recording(run.recording)[0]) for run, tape in runs]


def edge_distances(place_m: Sequence[float] | FloatArray) -> dict[TiltDirection, float]:
    """Distance of a place from the four edges of the simulated frame's footprint.

    Parameters
    ----------
    place_m : x, y, z in the body's axes, m

    Returns
    -------
    dict : by the tilt about that edge, m

    Examples
    --------
    >>> round(edge_distances([0.3, 0.0, 0.4])["back"], 3)
    0.5
    """
    x, y, z = (float(v) for v in place_m)
    half = FOOTPRINT.footprint_width_m / 2
    across: dict[TiltDirection, float] = {
        "front": FOOTPRINT.footprint_length_m - x,
        "back": x,
        "right": half + y,
        "left": half - y,
    }
    return {direction: float(np.hypot(length, z)) for direction, length in across.items()}


def gain_table() -> pd.DataFrame:
    """How much eq. 15 magnifies errors of the distances, by pose of Table 1.

    Returns
    -------
    DataFrame : index pose; gains of x and y by the form of eq. 15
    """
    import pandas as pd

    rows = {}
    for pose in POSES:
        distances = edge_distances(pose_translation(pose, 1))
        gains = [position_gain(distances, FOOTPRINT, form=form)[:2] for form in FORMS]
        rows[pose] = np.concatenate(gains)
    names = ["x, paper's root", "y, paper's root", "x, ours", "y, ours"]
    return pd.DataFrame(rows, index=names).T


def late_velocity_bias(
    paths: Sequence[TiltPath], late_deg: Iterable[float]
) -> dict[Form, FloatArray]:
    """Mean error of method 2's position by the tilt at which it takes the velocity.

    Parameters
    ----------
    paths : calibrations
    late_deg : k tilts, deg

    Returns
    -------
    dict : by the form of eq. 17, (k, 3) array, m
    """
    late_deg = list(late_deg)
    found: dict[Form, FloatArray] = {}
    for form in FORMS:
        rows = []
        for at in np.deg2rad(late_deg):
            errors = [
                calibrate_from_path(
                    path, tape, method="two-tilts", form=form, velocity_tilt_rad=float(at)
                ).mount.translation_body_m
                - run.mount.translation_body_m
                for run, tape, path in paths
            ]
            rows.append(np.mean(errors, axis=0))
        found[form] = np.array(rows)
    return found


def source_table(seeds: Iterable[int], sizes: Mapping[str, Imperfections] = SIZES) -> pd.DataFrame:
    """Errors of three smoothed methods with one thing wrong at a time.

    Parameters
    ----------
    seeds : one per repetition of the five poses
    sizes : by name, Imperfections on top of the data sheet's noise and bias

    Returns
    -------
    DataFrame : index source; 3-D rms error of the position by method (mm), and of the rotation by
        all samples (deg)
    """
    levels = {name: Level(DATASHEET, imperfections=size) for name, size in sizes.items()}
    wanted = (METHOD_1_ROOTLESS, "method 2, tilt added back", "all samples")
    variants = [v for v in VARIANTS if v.smooth and v.name in wanted]
    study = calibration_study(seeds, levels, variants=variants)
    key: dict[str, Any] = {"index": "level", "columns": "name", "aggfunc": rms, "sort": False}
    by_source = 1000 * study.pivot_table(values="error_m", **key)
    turned = study.pivot_table(values="turn_deg", **key)
    by_source["rotation by all samples, deg"] = turned["all samples"]
    return by_source


def table_1_simulated(one_seed: pd.DataFrame) -> pd.DataFrame:
    """Table 1's positions beside those of one simulated calibration in the paper's way.

    Parameters
    ----------
    one_seed : :func:`mobility_imu.reproduction.walker.studies.calibration_study` of one seed at
        one level

    Returns
    -------
    DataFrame : index pose; positions by the two methods, the paper's and ours, and how far the two
        are apart (mm)
    """
    import pandas as pd

    first = one_seed[~one_seed["smooth"]].set_index(["pose", "name"])[["x_m", "y_m", "z_m"]]
    rows = []
    for pose in POSES:
        here = first.loc[pose]
        how, one = "paper's", here.loc[METHOD_1].to_numpy()
        if np.isnan(one).any():
            how, one = "no root: without", here.loc[METHOD_1_ROOTLESS].to_numpy()
        ours = [one, here.loc[method_2(3)].to_numpy()]
        paper = [pose_translation(pose, k) for k in (1, 2)]
        rows.append(
            {
                "pose": pose,
                "paper T1 (= truth), m": _in_words(paper[0]),
                "ours T1, m": _in_words(ours[0]),
                "form": how,
                "paper T2, m": _in_words(paper[1]),
                "ours T2, m": _in_words(ours[1]),
                "paper |T1−T2|, mm": 1000 * np.linalg.norm(paper[0] - paper[1]),
                "ours, mm": 1000 * np.linalg.norm(ours[0] - ours[1]),
            }
        )
    return pd.DataFrame(rows).set_index("pose")


def _in_words(place_m: FloatArray) -> str:
    return ", ".join(f"{value:.3f}" for value in place_m)


def first_part(recording: Recording, until_s: float) -> Recording:
    """Recording of a walking frame up to a time.

    Parameters
    ----------
    recording : with a sensor "frame"
    until_s : s

    Returns
    -------
    Recording
    """
    keep, frame = recording.time_s < until_s, recording.sensors["frame"]
    gyr = recording.gyroscope("frame")
    return Recording(recording.time_s[keep], {"frame": Imu(frame.acc_mps2[keep], gyr[keep])})


def tilts_on_a_slope(slope_deg: float, pose: str = "1") -> SimulatedWalker:
    """Tilts of a frame on a floor that rises to the front, without other errors.

    Parameters
    ----------
    slope_deg : deg
    pose : mounting of Table 1

    Returns
    -------
    SimulatedWalker
    """
    lean = Rotation.from_rotvec([0, -np.deg2rad(slope_deg), 0]).as_matrix()  # the nose is up
    level_floor = simulate_tilts(FOOTPRINT, seed=1)
    slope = replace(
        level_floor,
        position_m=level_floor.position_m @ lean.T,
        rotation_body_to_world=lean @ level_floor.rotation_body_to_world,
    )
    return attach_imu(slope, pose_mount(pose), IDEAL, seed=0, unit_seed=0)
