"""Drives with pushes, coasting and braking, wheels that slip or skid, toe and slopes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray
from mobility_imu.recording import Recording
from mobility_imu.simulation.sensor import SensorModel, measure
from mobility_imu.simulation.wheelchair.chair import (
    SIDES,
    Leg,
    Mounting,
    check_legs,
    frame_imu,
    sloping,
    stepped,
    wheel_imu,
)
from mobility_imu.simulation.wheelchair.drive import SimulatedDrive
from mobility_imu.simulation.wheelchair.pushing import Pushing, SlipEpisode, pushed
from mobility_imu.wheelchair.geometry import WheelchairGeometry

if TYPE_CHECKING:
    import pandas as pd

# Simulated motion per sample of a sensor model: 2.5 ms at 100 Hz, a hundredth of a push.
FINER = 4


@dataclass(frozen=True)
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

    @property
    def slipping(self) -> np.ndarray:
        """Where at least one wheel slips, (n,) of bool."""
        return (self.slip_left_mps != 0) | (self.slip_right_mps != 0)

    def truth(self) -> pd.DataFrame:
        """Give the truth as the velocity and task tables name it, and the slip of each wheel."""
        return (
            super()
            .truth()
            .assign(slip_left_mps=self.slip_left_mps, slip_right_mps=self.slip_right_mps)
        )


def simulate_court(
    legs: Sequence[Leg],
    geometry: WheelchairGeometry,
    mounting: dict[str, Mounting],
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
    model : SensorModel; None for ideal sensors
    sampling_rate_hz : Hz
    transition_s : s, length of a change of yaw rate or slope

    Returns
    -------
    SimulatedCourt

    Raises
    ------
    InputError
        If a leg is shorter than a change or too short to brake in, or the model loses samples.
    """
    check_legs(legs, transition_s)
    if model is not None and model.dropped_share:
        raise InputError(
            f"dropped_share = {model.dropped_share}: the three sensors need one clock, expected 0"
        )
    count = round(sum(leg.duration_s for leg in legs) * sampling_rate_hz)
    # A sensor model samples by itself, out of something faster.
    finer = 1 if model is None else FINER
    time_s = np.arange((count - 1) * finer + 1) / (sampling_rate_hz * finer)
    velocity, acceleration, onsets = pushed(legs, pushing or Pushing(), time_s)
    ends = np.cumsum([leg.duration_s for leg in legs])[:-1]
    rates = [np.deg2rad(leg.yaw_rate_degps) for leg in legs]
    inside = _changes_inside_turns(rates, ends, transition_s)
    yaw, yaw_change, _ = stepped(rates, inside, time_s, transition_s)
    pitch = stepped([np.deg2rad(leg.slope_deg) for leg in legs], ends, time_s, transition_s)
    motion = sloping(velocity, acceleration, yaw, yaw_change, pitch)

    imus = {"frame": frame_imu(motion, mounting["frame"])}
    slipped = {}
    for side in SIDES:
        profiles = [slip.profile(time_s) for slip in slips if slip.side == side]
        total, change = np.sum(profiles, axis=0) if profiles else np.zeros((2, len(time_s)))
        slipped[side] = total[::finer]
        imus[f"{side}_wheel"] = wheel_imu(
            time_s,
            motion,
            geometry,
            side,
            mounting[f"{side}_wheel"],
            toe_rad=toe_rad,
            slip_mps=total,
            slip_change_mps2=change,
        )
    if model is not None:
        for k, (name, imu) in enumerate(imus.items()):
            assert imu.gyr_radps is not None
            imus[name] = measure(
                time_s,
                imu.acc_mps2,
                imu.gyr_radps,
                model,
                sampling_rate_hz=sampling_rate_hz,
                seed=3 * seed + k,
                unit_seed=3 * unit_seed + k,
            ).imu
    stated = time_s[::finer]
    task = np.array([leg.task for leg in legs], np.int8)
    return SimulatedCourt(
        recording=Recording(stated, imus, source="simulated wheelchair court"),
        linear_velocity_mps=velocity[::finer],
        yaw_rate_radps=yaw[::finer],
        task=task[np.searchsorted(ends, stated, side="right")],
        acceleration_mps2=acceleration[::finer],
        slip_left_mps=slipped["left"],
        slip_right_mps=slipped["right"],
        pitch_rad=pitch[0][::finer],
        push_onset_s=onsets,
    )


def _changes_inside_turns(
    rates: Sequence[float], ends: FloatArray, transition_s: float
) -> FloatArray:
    """Middles of the changes of yaw rate: a turn begins and ends with its leg."""
    before, after = np.asarray(rates[:-1]), np.asarray(rates[1:])
    shift = np.where(before == 0, 0.5, np.where(after == 0, -0.5, 0.0))
    return ends + shift * transition_s
