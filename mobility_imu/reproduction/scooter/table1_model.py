"""Suzurikawa et al. 2022, Table 1: the table that a scooter with given faults would have given.

The faults are turns of the two IMUs (mounting), slopes that are not quite as stated, and reading
noise of the reference angles; further ones are the rivals. Every fault has a prior of zero mean.
:class:`TableCost` is what a fit makes small and what a posterior is made of: the misfit of all
cells in units of what a cell may differ by, and the faults in units of their prior sd.

All angles of this module's tables and parameters are in degrees, as printed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray
from mobility_imu.reproduction.scooter.static_table import (
    COLUMNS,
    ROWS,
    SLOPE_RAD,
    STEERING_POSITIONS_RAD,
    THROTTLE_POSITIONS_RAD,
)
from mobility_imu.results import Result
from mobility_imu.scooter.angles import three_axis_angles
from mobility_imu.scooter.geometry import (
    SUZUKI_ET4D,
    ScooterGeometry,
    body_specific_force,
    rotation_lever_to_body,
)

QUANTITIES = ("single_mae", "single_sd", "dual_mae", "dual_sd")
SINGLE, DUAL = slice(0, 2), slice(2, 4)

YAW = ("lever z",)
LEVER_TURN = ("lever x", "lever y", "lever z")
BODY_TURN = ("body x", "body y", "body z")
MOUNTING = (*YAW, "lever x", "lever y", *BODY_TURN)
PITCHES = tuple(f"pitch {row}" for row in ROWS)
ROLLS = tuple(f"roll {row}" for row in ROWS)
NOISE = ("steering noise", "throttle noise")
"""Reading noise of the reference angles, that of steering and that of the throttle."""
OFFSETS = ("steering reference offset", "throttle reference offset")
STRETCHES = ("steering reference at lock", "throttle reference at end")
LEVER_BIAS = tuple(f"lever bias {axis}" for axis in "xyz")
BODY_BIAS = tuple(f"body bias {axis}" for axis in "xyz")
RIVALS = ("alpha", *OFFSETS, *STRETCHES, *LEVER_BIAS, *BODY_BIAS)
"""Other causes of the same size. They show whether a fitted value survives."""

# Fixed before the fit. Mounting: set by eye and tape. Slopes: CELL_TOLERANCE_REASON of the static
# test. Noise: backlash and reading of the wire sensors, half-normal. Biases as the tilt that they
# look like: 5 milli-g.
PRIOR_SD_DEG = {
    **dict.fromkeys(MOUNTING, 2.0),
    **dict.fromkeys((*PITCHES, *ROLLS), 1.0),
    **dict.fromkeys(NOISE, 1.0),
    **dict.fromkeys(RIVALS[:5], 1.0),
    **dict.fromkeys((*LEVER_BIAS, *BODY_BIAS), 0.286),
}
PARAMETERS = tuple(PRIOR_SD_DEG)
"""Names of all free parameters, in the order of the vectors."""
MODELS: dict[str, tuple[str, ...]] = {
    "geometry": (),
    "+ yaw": YAW,
    "+ mounting": MOUNTING,
    "+ slopes": (*MOUNTING, *PITCHES, *ROLLS),
    "+ noise": (*MOUNTING, *PITCHES, *ROLLS, *NOISE),
}
"""The nested models and their free parameters."""
OTHER_MODELS: dict[str, tuple[str, ...]] = {
    "geometry and noise only": NOISE,
    "yaw and noise": (*YAW, *NOISE),
    "yaw, side slopes, noise": (*YAW, "roll left", "roll right", *NOISE),
    "mounting and noise": (*MOUNTING, *NOISE),
    "+ noise + rivals": PARAMETERS,
}
"""Models beside the chain. They show which of its steps matter, and whether its values survive.

The rivals are an error of alpha (one of beta is one of the lever IMU about x, exactly), offset and
range of the two reference angles, and both accelerometers' biases.
"""

# A cell is a mean of 4 or 7 positions: reading noise of 1 deg leaves 0.3 to 0.5 deg of chance in
# it. What grows with the error itself (positions and range of the dials) is taken as a share.
FLOOR_DEG = 0.5
SHARE_MAE, SHARE_SD = 0.08, 0.15


def places(names: Sequence[str]) -> NDArray[np.int64]:
    """Where these parameters stand in the vectors of :data:`PARAMETERS`.

    Parameters
    ----------
    names : of parameters

    Returns
    -------
    (p,) array of int

    Raises
    ------
    InputError
        If a name is unknown.
    """
    unknown = [name for name in names if name not in PRIOR_SD_DEG]
    if unknown:
        raise InputError(f"names: {unknown[0]!r} is not a parameter of Table 1's models")
    return np.array([PARAMETERS.index(name) for name in names], np.int64)


def pick(values: FloatArray, *names: str) -> FloatArray:
    """Values of some parameters out of vectors of all of them, (..., 29) to (..., p).

    Parameters
    ----------
    values : (..., 29) array, in the order of :data:`PARAMETERS`
    *names : of parameters

    Returns
    -------
    (..., p) array
    """
    return values[..., places(names)]


def published_table() -> FloatArray:
    """Table 1 as printed, (5, 5, 4), deg: row, column, quantity."""
    from mobility_imu.reproduction.published import load_published

    cells = load_published("scooter_table1").set_index(["row", "column", "quantity"])["value"]
    return np.array([[[cells[r, c, q] for q in QUANTITIES] for c in COLUMNS] for r in ROWS])


def table_checksum() -> dict[str, str]:
    """SHA-256 of the file with Table 1, by its name, for a record."""
    import hashlib

    from mobility_imu.data import published_folder

    table = published_folder() / "scooter_table1.csv"
    return {table.name: hashlib.sha256(table.read_bytes()).hexdigest()}


def cell_sd(table_deg: FloatArray, floor_deg: float = FLOOR_DEG) -> FloatArray:
    """What each cell of a table may differ by, (5, 5, 4), deg (standard deviation).

    Parameters
    ----------
    table_deg : (5, 5, 4) array, deg
    floor_deg : deg, smallest standard deviation

    Returns
    -------
    (5, 5, 4) array, deg
    """
    return np.maximum(floor_deg, table_deg * [SHARE_MAE, SHARE_SD, SHARE_MAE, SHARE_SD])


@dataclass(frozen=True, eq=False, repr=False)
class TableCost(Result):
    """Misfit of a model to a table and its distance from the priors.

    Parameters
    ----------
    table_deg : (5, 5, 4) array, deg, as :func:`published_table`
    names : free parameters, the others stay zero
    left_row_ax_sign : -1 or +1, which side of "left side slope" is up, see
        :func:`mobility_imu.reproduction.scooter.static_table`
    use : quantities that count: all, ``SINGLE`` or ``DUAL``
    spread_deg : (5, 5, 4) array, deg, sd of each cell; None is :func:`cell_sd` of the table
    """

    table_deg: FloatArray
    names: tuple[str, ...]
    left_row_ax_sign: int = -1
    use: slice = field(default_factory=lambda: slice(0, 4))
    spread_deg: FloatArray | None = None

    @property
    def prior_sd_deg(self) -> FloatArray:
        """Prior sd of the free parameters, (p,), deg."""
        return np.array([PRIOR_SD_DEG[name] for name in self.names])

    @property
    def is_noise(self) -> NDArray[np.bool_]:
        """Which of the free parameters are reading noise, (p,); of these only the size counts."""
        return np.isin(self.names, NOISE)

    def full(self, part_deg: FloatArray) -> FloatArray:
        """Vectors of all parameters, (..., 29), from those of the free ones, (..., p).

        Parameters
        ----------
        part_deg : (..., p) array, deg, values of the free parameters

        Returns
        -------
        (..., 29) array, deg
        """
        values = np.zeros((*part_deg.shape[:-1], len(PARAMETERS)))
        values[..., places(self.names)] = part_deg
        return values

    def predict(self, part_deg: FloatArray) -> FloatArray:
        """Expected tables, (..., 5, 5, 4), deg, for values of the free parameters, (..., p).

        Parameters
        ----------
        part_deg : (..., p) array, deg, values of the free parameters

        Returns
        -------
        (..., 5, 5, 4) array, deg
        """
        return predict_table(self.full(part_deg), left_row_ax_sign=self.left_row_ax_sign)

    def residuals(self, part_deg: FloatArray) -> FloatArray:
        """Misfit of every cell over its sd, then every parameter over its prior sd.

        Parameters
        ----------
        part_deg : (..., p) array, deg

        Returns
        -------
        (..., cells + p) array; the sum of its squares is the cost
        """
        spread = cell_sd(self.table_deg) if self.spread_deg is None else self.spread_deg
        misfit = ((self.predict(part_deg) - self.table_deg) / spread)[..., self.use]
        misfit = misfit.reshape(*part_deg.shape[:-1], -1)
        return np.concatenate([misfit, part_deg / self.prior_sd_deg], axis=-1)

    def log_density(self, part_deg: FloatArray) -> FloatArray:
        """Logarithm of the posterior density but for a constant: minus half the cost, (...).

        Parameters
        ----------
        part_deg : (..., p) array, deg, values of the free parameters

        Returns
        -------
        (...) array
        """
        return np.asarray(-0.5 * (self.residuals(part_deg) ** 2).sum(axis=-1))

    def derivative(self, part_deg: FloatArray) -> FloatArray:
        """Derivative of the residuals, (cells + p, p), at one point (p,), by differences.

        Parameters
        ----------
        part_deg : (p,) array, deg, values of the free parameters

        Returns
        -------
        (cells + p, p) array, 1/deg
        """
        step = 1e-3 * np.eye(len(part_deg))
        both = self.residuals(np.concatenate([part_deg + step, part_deg - step]))
        return (both[: len(part_deg)] - both[len(part_deg) :]).T / 2e-3


def predict_table(
    values_deg: ArrayLike,
    *,
    left_row_ax_sign: int = -1,
    geometry: ScooterGeometry = SUZUKI_ET4D,
) -> FloatArray:
    """Expected Table 1 for given nuisances.

    Noise is handled in expectation: the mean of ``|e + n|`` with Gaussian n (folded normal), and
    the root of the expected squared SD. Where noise is all there is, that root is 11 % (4
    positions) or 6 % (7) above the expected SD; less than the 15 % and 0.5 deg that an SD may
    differ by.

    Parameters
    ----------
    values_deg : (..., 29) array, deg, in the order of :data:`PARAMETERS`; zeros are geometry alone
    left_row_ax_sign : -1 or +1
    geometry : ScooterGeometry

    Returns
    -------
    (..., 5, 5, 4) array, deg: row, column, quantity

    Raises
    ------
    InputError
        If the sign is not +1 or -1, or there are not 29 values.
    """
    if left_row_ax_sign not in (-1, 1):
        raise InputError(f"left_row_ax_sign = {left_row_ax_sign}: expected +1 or -1")
    values = np.asarray(values_deg, float)
    if values.shape[-1:] != (len(PARAMETERS),):
        raise InputError(f"values_deg: shape {values.shape}, expected {len(PARAMETERS)} values")
    lead = values.shape[:-1]
    values = values.reshape(-1, len(PARAMETERS))
    level = body_specific_force(0.0, 0.0)
    body_bias = np.tan(np.deg2rad(pick(values, *BODY_BIAS))) * level[2]
    force = _row_forces(values, left_row_ax_sign)
    # A row times a rotation: its inverse.
    felt = force @ _turn(pick(values, *BODY_TURN)) + body_bias[:, None]

    table = np.empty((len(values), len(ROWS), len(COLUMNS), len(QUANTITIES)))
    for columns, which, steering, throttle in _conditions():
        lever = _lever_readings(values, force, rotation_lever_to_body(steering, throttle, geometry))
        truth = (steering, throttle)[which]
        reference_deg = pick(values, OFFSETS[which])[..., None] + pick(values, STRETCHES[which])[
            ..., None
        ] * (truth / truth.max())
        noise_deg = np.abs(pick(values, NOISE[which]))[..., None, None]
        for mode, body in ((SINGLE, level), (DUAL, felt[:, :, None, None])):
            angle = three_axis_angles(lever, body, geometry)[which]
            error_deg = np.rad2deg(angle - truth) - reference_deg[:, None]
            table[:, :, columns, mode] = _expected_cell(error_deg, noise_deg)
    return table.reshape(*lead, *table.shape[1:])


def _row_forces(values_deg: FloatArray, left_row_ax_sign: int) -> FloatArray:
    """Specific force of the body in each row, (n, 5, 3), m/s², in the body's true axes."""
    side = left_row_ax_sign * SLOPE_RAD
    stated_pitch = np.array([0.0, SLOPE_RAD, -SLOPE_RAD, 0.0, 0.0])
    stated_roll = np.array([0.0, 0.0, 0.0, side, -side])
    pitch = np.deg2rad(pick(values_deg, *PITCHES)) + stated_pitch
    roll = np.deg2rad(pick(values_deg, *ROLLS)) + stated_roll
    return body_specific_force(pitch, roll)


def _lever_readings(
    values_deg: FloatArray, force: FloatArray, lever_to_body: FloatArray
) -> FloatArray:
    """Readings of the lever's IMU, (n, 5, column, position, 3), m/s²."""
    # The true alpha is smaller than the believed one by "alpha": eq. 5 between two turns about x.
    shaft = _turn(-pick(values_deg, "alpha") * [1.0, 0.0, 0.0])
    turn = np.swapaxes(shaft, 1, 2) @ _turn(pick(values_deg, *LEVER_TURN))
    bias = np.tan(np.deg2rad(pick(values_deg, *LEVER_BIAS))) * body_specific_force(0.0, 0.0)[2]
    lever = np.einsum("cpji,krj->krcpi", lever_to_body, force @ shaft) @ turn[:, None, None]
    return np.asarray(lever + bias[:, None, None, None])


def _conditions() -> list[tuple[slice, int, FloatArray, FloatArray]]:
    """Columns, which angle is judged (0 steering, 1 throttle), positions (column, place)."""
    wheel, lever = np.array(STEERING_POSITIONS_RAD), np.array(THROTTLE_POSITIONS_RAD)
    ends = np.array([0.0, wheel.max(), wheel.min()])
    shape = (2, len(wheel)), (3, len(lever))
    return [
        (slice(0, 2), 0, np.broadcast_to(wheel, shape[0]), _across(lever[[0, -1]], shape[0])),
        (slice(2, 5), 1, _across(ends, shape[1]), np.broadcast_to(lever, shape[1])),
    ]


def _across(values: FloatArray, shape: tuple[int, int]) -> FloatArray:
    return np.broadcast_to(values[:, None], shape)


def _expected_cell(error_deg: FloatArray, noise_deg: FloatArray) -> FloatArray:
    """Mean and SD (n - 1) of ``|error + noise|`` over the last axis, as (..., 2)."""
    from scipy.special import erf

    noise = np.maximum(noise_deg, 1e-9)
    ratio = error_deg / noise
    mean = noise * np.sqrt(2 / np.pi) * np.exp(-(ratio**2) / 2) + error_deg * erf(
        ratio / np.sqrt(2)
    )
    variance = np.maximum(error_deg**2 + noise**2 - mean**2, 0)
    spread = np.sqrt(mean.var(axis=-1, ddof=1) + variance.mean(axis=-1))
    return np.stack([mean.mean(axis=-1), spread], axis=-1)


def _turn(vectors_deg: FloatArray) -> FloatArray:
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_rotvec(np.deg2rad(vectors_deg)).as_matrix())
