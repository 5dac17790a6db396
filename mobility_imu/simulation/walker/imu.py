"""What an IMU that is fixed to the frame records of a motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

from mobility_imu.arguments import check_columns, expect
from mobility_imu.fields import check_fields
from mobility_imu.frames import STANDARD_GRAVITY_MPS2, FloatArray, as_rotation
from mobility_imu.recording import Recording
from mobility_imu.results import Result
from mobility_imu.simulation.sensor import MTI_1, SensorModel, measure
from mobility_imu.simulation.walker.motion import FAST_HZ, StepTruth, TiltTruth, WalkerMotion
from mobility_imu.walker.mount import WalkerMount

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, eq=False, repr=False)
class SimulatedWalker(Result):
    """What an IMU on the frame recorded, and the truth when it took its samples.

    Parameters
    ----------
    recording : Recording of ``frame``, on the IMU's clock
    motion : WalkerMotion
    mount : WalkerMount, the true one
    time_s : (n,) array, s, when the samples were really taken
    position_body_m : (n, 3) array, m, the body's origin in the world
    rotation_body_to_world : (n, 3, 3) array
    position_imu_m : (n, 3) array, m, in the world
    velocity_imu_mps : (n, 3) array, m/s, in the world
    rotation_imu_to_world : (n, 3, 3) array
    stationary : (n,) bool array, as in ``WalkerMotion``
    """

    recording: Recording
    motion: WalkerMotion
    mount: WalkerMount
    time_s: FloatArray
    position_body_m: FloatArray
    rotation_body_to_world: FloatArray
    position_imu_m: FloatArray
    velocity_imu_mps: FloatArray
    rotation_imu_to_world: FloatArray
    stationary: NDArray[np.bool_]

    def __post_init__(self) -> None:
        """Check that what belongs together has one length."""
        check_columns(self, "time_s", flags=("stationary",))
        count = len(self.time_s)
        places = ("position_body_m", "position_imu_m", "velocity_imu_mps")
        turns = ("rotation_body_to_world", "rotation_imu_to_world")
        check_fields(
            self,
            recording=Recording,
            motion=WalkerMotion,
            mount=WalkerMount,
            **dict.fromkeys(places, (count, 3)),
            **dict.fromkeys(turns, (count, 3, 3)),
        )
        super().__post_init__()

    @property
    def tilts(self) -> tuple[TiltTruth, ...]:
        """Tilts of the motion."""
        return self.motion.tilts

    @property
    def steps(self) -> tuple[StepTruth, ...]:
        """Steps of the motion."""
        return self.motion.steps

    @property
    def distance_m(self) -> float:
        """Horizontal distance of the body's origin between the first and the last sample, m."""
        way = self.position_body_m[-1] - self.position_body_m[0]
        return float(np.linalg.norm(way[:2]))

    def path_in_axes(self, rotation_imu_to_axes: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """True path of the IMU from its first sample, in level axes with a heading of their own.

        An estimate starts with a heading by choice; its axes differ from the world's by that.

        Parameters
        ----------
        rotation_imu_to_axes : (3, 3) array, attitude of the first sample in the other axes

        Returns
        -------
        (n, 3) array, m, and the rotation (3, 3) from the world's axes into the others
        """
        given = as_rotation(rotation_imu_to_axes, "rotation_imu_to_axes")
        turn = given @ self.rotation_imu_to_world[0].T
        heading = np.arctan2(turn[1, 0] - turn[0, 1], turn[0, 0] + turn[1, 1])
        level = Rotation.from_euler("z", heading).as_matrix()
        return (self.position_imu_m - self.position_imu_m[0]) @ level.T, level

    def truth(self) -> pd.DataFrame:
        """Table of the true path of the body, columns as ``walker trajectory`` writes them."""
        import pandas as pd

        forward = self.rotation_body_to_world[:, :, 0]
        return pd.DataFrame(
            {
                "time_s": self.recording.time_s,
                **{f"{axis}_m": self.position_body_m[:, k] for k, axis in enumerate("xyz")},
                "yaw_deg": np.rad2deg(np.unwrap(np.arctan2(forward[:, 1], forward[:, 0]))),
                "stationary": self.stationary.astype(int),
            }
        )


def attach_imu(
    motion: WalkerMotion,
    mount: WalkerMount,
    sensor: SensorModel = MTI_1,
    *,
    seed: int,
    unit_seed: int,
    sampling_rate_hz: float = 100.0,
) -> SimulatedWalker:
    """Record a motion by an IMU that is fixed to the frame.

    Parameters
    ----------
    motion : WalkerMotion; what all its IMUs share is worked out once
    mount : WalkerMount, where the IMU really is
    sensor : SensorModel
    seed : of this power-up: biases, noise
    unit_seed : of this unit: scale factors, misalignments, clock
    sampling_rate_hz : Hz

    Returns
    -------
    SimulatedWalker

    Raises
    ------
    InputError
        If the sensor loses samples, which no Recording allows, the sampling rate is not positive
        or above FAST_HZ, or a seed is negative or not whole.
    """
    expect("motion", motion, WalkerMotion)
    expect("mount", mount, WalkerMount)
    expect("sensor", sensor, SensorModel)
    axes, arm = mount.rotation_imu_to_body, mount.translation_body_m
    force = motion.specific_force_mps2 + motion.arm_per_s2 @ arm
    output = measure(
        motion.time_s,
        force @ axes,
        motion.rate_radps @ axes,
        sensor,
        sampling_rate_hz=sampling_rate_hz,
        seed=seed,
        unit_seed=unit_seed,
    )
    recording = Recording(output.time_s, {"frame": output.imu}, source="simulated walker")
    # Truth between two fast times: from the nearest one on, by rate and acceleration.
    true = np.clip(output.true_time_s, motion.time_s[0], motion.time_s[-1])
    near = np.round(true * FAST_HZ).astype(int)
    ahead = (true - motion.time_s[near])[:, None]
    standing, rate = motion.rotation_body_to_world[near], motion.rate_radps[near]
    force_world = np.einsum("nij,nj->ni", standing, force[near])
    force_world[:, 2] -= STANDARD_GRAVITY_MPS2
    rotation = standing @ Rotation.from_rotvec(rate * ahead).as_matrix()
    spin = np.einsum("nij,nj->ni", standing, np.cross(rate, arm))
    velocity = motion.velocity_mps[near] + spin
    imu = motion.position_m[near] + standing @ arm
    imu = imu + velocity * ahead + force_world * ahead**2 / 2
    return SimulatedWalker(
        recording=recording,
        motion=motion,
        mount=mount,
        time_s=true,
        position_body_m=imu - rotation @ arm,
        rotation_body_to_world=rotation,
        position_imu_m=imu,
        velocity_imu_mps=velocity + force_world * ahead,
        rotation_imu_to_world=rotation @ axes,
        stationary=motion.stationary[near],
    )
