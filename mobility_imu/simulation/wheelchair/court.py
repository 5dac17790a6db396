"""Drives with pushes, coasting and braking, wheels that slip or skid, toe and slopes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mobility_imu.arguments import check_columns, expect, settings_or_default
from mobility_imu.errors import InputError
from mobility_imu.fields import check_fields
from mobility_imu.frames import FloatArray, as_count, as_number
from mobility_imu.recording import Imu, Recording
from mobility_imu.simulation.sensor import SensorModel, measure
from mobility_imu.simulation.wheelchair.chair import (
    SIDES,
    ChairMotion,
    Leg,
    Mounting,
    check_legs,
    check_mounting,
    checked_rate,
    frame_imu,
    samples_of,
    sloping,
    stepped,
    wheel_imu,
)
from mobility_imu.simulation.wheelchair.drive import SimulatedDrive
from mobility_imu.simulation.wheelchair.pushing import Pushing, SlipEpisode, pushed
from mobility_imu.wheelchair.geometry import Side, WheelchairGeometry

if TYPE_CHECKING:
    import pandas as pd

# Simulated motion per sample of a sensor model: 2.5 ms at 100 Hz, a hundredth of a push.
FINER = 4
FULL_SPEED_MPS = 1.0
"""Speed that the sizes of a sensor model's vibration are for."""


@dataclass(frozen=True, eq=False, repr=False)
class SimulatedCourt(SimulatedDrive):
    """A court with its truth: that of a drive, and what only a court has.

    Parameters
    ----------
    acceleration_mps2 : (n,) array, m/s², change of the speed
    slip_left_mps, slip_right_mps : (n,) arrays, m/s, the rim's speed beyond rolling; 0 where the
        wheel rolls
    pitch_rad : (n,) array, rad, nose up positive
    push_onset_s : (k,) array, s, when pushes begin
    """

    acceleration_mps2: FloatArray
    slip_left_mps: FloatArray
    slip_right_mps: FloatArray
    pitch_rad: FloatArray
    push_onset_s: FloatArray

    def __post_init__(self) -> None:
        """Check that there is one number for each sample."""
        expect("SimulatedCourt.recording", self.recording, Recording)
        names = ("acceleration_mps2", "slip_left_mps", "slip_right_mps", "pitch_rad")
        check_fields(self, **dict.fromkeys(names, (len(self.recording),)))
        check_columns(self, "push_onset_s")
        super().__post_init__()

    @property
    def slipping(self) -> NDArray[np.bool_]:
        """Where at least one wheel slips, (n,) of bool."""
        return np.asarray((self.slip_left_mps != 0) | (self.slip_right_mps != 0))

    def truth(self) -> pd.DataFrame:
        """Table of the truth as of a drive, and the slip of each wheel."""
        return (
            super()
            .truth()
            .assign(slip_left_mps=self.slip_left_mps, slip_right_mps=self.slip_right_mps)
        )


def simulate_court(
    legs: Sequence[Leg],
    geometry: WheelchairGeometry,
    mounting: Mapping[str, Mounting],
    *,
    seed: int,
    unit_seed: int = 0,
    slips: Sequence[SlipEpisode] = (),
    toe_rad: float = 0.0,
    pushing: Pushing | None = None,
    model: SensorModel | None = None,
    sampling_rate_hz: float = 100.0,
    transition_s: float = 0.8,
) -> SimulatedCourt:
    """Drive along legs with pushes, coasting and braking, and record it.

    A leg's task begins with the leg: a push begins there, a turn begins there if the chair went
    straight before, and a rest begins where the brake has ended. The true speed and yaw rate do
    not know of the slips: those are added to the wheels' spin alone.

    Parameters
    ----------
    legs : the court
    geometry : WheelchairGeometry, the true one
    mounting : of ``frame``, ``left_wheel``, ``right_wheel``
    seed : of this power-up: biases and noise; the same seed gives the same bytes
    unit_seed : of the three sensors as made: scale, misalignment
    slips : episodes of slip; those of one wheel add up
    toe_rad : rad, both wheels' fronts point inward by this
    pushing : Pushing; its default values if None
    model : SensorModel; None for ideal sensors, whose samples are exact
    sampling_rate_hz : Hz
    transition_s : s, length of a change of yaw rate or slope

    Returns
    -------
    SimulatedCourt

    Raises
    ------
    InputError
        If there is no leg, a leg is shorter than a change or too short to brake in, the mounting
        of a sensor is missing, the model loses samples, a number is out of its range, or a seed
        is negative or not whole.
    """
    transition_s = check_legs(legs, transition_s)
    check_mounting(mounting)
    expect("geometry", geometry, WheelchairGeometry)
    sampling_rate_hz = checked_rate(sampling_rate_hz)
    if abs(as_number(toe_rad, "toe_rad", negative=True)) > np.pi / 4:
        raise InputError(f"toe_rad = {toe_rad:g}: expected up to pi/4 (in deg?)")
    seeds = as_count(seed, "seed", least=0), as_count(unit_seed, "unit_seed", least=0)
    _check_model(model)
    _check_slips(slips)
    count = samples_of(legs, sampling_rate_hz)
    # A sensor model samples by itself, out of something faster.
    finer = 1 if model is None else FINER
    time_s = np.arange((count - 1) * finer + 1) / (sampling_rate_hz * finer)
    pushing = settings_or_default("pushing", pushing, Pushing)
    motion, pitch, onsets = _motion(legs, pushing, time_s, transition_s)
    rim = {side: _slipped(slips, side, time_s) for side in SIDES}
    imus = {"frame": frame_imu(motion, mounting["frame"])}
    for side in SIDES:
        imus[f"{side}_wheel"] = wheel_imu(
            time_s,
            motion,
            geometry,
            side,
            mounting[f"{side}_wheel"],
            toe_rad=toe_rad,
            slip_mps=rim[side][0],
            slip_change_mps2=rim[side][1],
        )
    if model is not None:
        share = np.abs(motion.velocity) / FULL_SPEED_MPS
        imus = _measured(time_s, imus, model, sampling_rate_hz, seeds, share)
    stated = time_s[::finer]
    ends = np.cumsum([leg.duration_s for leg in legs])[:-1]
    task = np.array([leg.task for leg in legs], np.int8)
    return SimulatedCourt(
        recording=Recording(stated, imus, source="simulated wheelchair court"),
        linear_velocity_mps=motion.velocity[::finer],
        yaw_rate_radps=motion.yaw[::finer],
        task=task[np.searchsorted(ends, stated, side="right")],
        acceleration_mps2=motion.acceleration[::finer],
        slip_left_mps=rim["left"][0][::finer],
        slip_right_mps=rim["right"][0][::finer],
        pitch_rad=pitch[::finer],
        push_onset_s=onsets,
    )


def _check_slips(slips: Sequence[SlipEpisode]) -> None:
    if not isinstance(slips, Sequence) or isinstance(slips, str | bytes):
        raise InputError(f"slips: got {type(slips).__name__}, expected a list of SlipEpisode")
    for slip in slips:
        expect("slips", slip, SlipEpisode)


def _check_model(model: SensorModel | None) -> None:
    if model is None:
        return
    expect("model", model, SensorModel)
    if model.dropped_share:
        raise InputError(
            f"dropped_share = {model.dropped_share}: the three sensors need one clock, expected 0"
        )


def _motion(
    legs: Sequence[Leg], pushing: Pushing, time_s: FloatArray, transition_s: float
) -> tuple[ChairMotion, FloatArray, FloatArray]:
    """Motion of the chair, its pitch (n,), rad, and the push onsets (k,), s."""
    velocity, acceleration, onsets = pushed(legs, pushing, time_s)
    ends = np.cumsum([leg.duration_s for leg in legs])[:-1]
    rates = [np.deg2rad(leg.yaw_rate_degps) for leg in legs]
    inside = _changes_inside_turns(rates, ends, transition_s)
    yaw, yaw_change, _ = stepped(rates, inside, time_s, transition_s)
    pitch = stepped([np.deg2rad(leg.slope_deg) for leg in legs], ends, time_s, transition_s)
    return sloping(velocity, acceleration, yaw, yaw_change, pitch), pitch[0], onsets


def _slipped(
    slips: Sequence[SlipEpisode], side: Side, time_s: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Excess speed of one wheel's rim and its change; the episodes add up."""
    profiles = [slip.profile(time_s) for slip in slips if slip.side == side]
    speed, change = np.sum(profiles, axis=0) if profiles else np.zeros((2, len(time_s)))
    return speed, change


def _measured(
    time_s: FloatArray,
    imus: Mapping[str, Imu],
    model: SensorModel,
    sampling_rate_hz: float,
    seeds: tuple[int, int],
    speed_share: FloatArray,
) -> dict[str, Imu]:
    """Readings of the three sensors through a sensor model; seeds of power-up and unit."""
    readings = {}
    for k, (name, imu) in enumerate(imus.items()):
        assert imu.gyr_radps is not None
        readings[name] = measure(
            time_s,
            imu.acc_mps2,
            imu.gyr_radps,
            model,
            sampling_rate_hz=sampling_rate_hz,
            seed=3 * seeds[0] + k,
            unit_seed=3 * seeds[1] + k,
            speed_share=speed_share,
        ).imu
    return readings


def _changes_inside_turns(
    rates: Sequence[float], ends: FloatArray, transition_s: float
) -> FloatArray:
    """Middles of the changes of yaw rate: a turn begins and ends with its leg."""
    before, after = np.asarray(rates[:-1]), np.asarray(rates[1:])
    shift = np.where(before == 0, 0.5, np.where(after == 0, -0.5, 0.0))
    return ends + shift * transition_s
