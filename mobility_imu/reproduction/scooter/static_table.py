"""Suzurikawa et al. 2022: the static test (Table 1) by geometry alone.

Geometry alone means: perfect sensors and mounting, the slopes and positions as stated, eq. 5
forward and eqs. 6 and 7 back. What then remains is the error of one IMU that takes a slope for
level ground. With two IMUs nothing remains, so the dual half of the table is not explained.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from mobility_imu.errors import InputError
from mobility_imu.frames import FloatArray
from mobility_imu.reproduction.scooter.paper_method import clipped_angles, subtract_body
from mobility_imu.scooter.angles import estimate_angles
from mobility_imu.scooter.geometry import (
    SUZUKI_ET4D,
    ScooterGeometry,
    body_specific_force,
    lever_acceleration,
)

if TYPE_CHECKING:
    import pandas as pd

ROWS = ("flat", "upward", "downward", "left", "right")
COLUMNS = ("a", "b", "c", "d", "e")
# Positions, ranges and slope are stated (sections 2.2, 2.4); even spacing, 0 as "min" and the
# ends of the range as "max" are our reading of it.
SLOPE_RAD = float(np.deg2rad(5))
STEERING_POSITIONS_RAD = tuple(np.deg2rad(np.linspace(-50, 50, 7)).tolist())
THROTTLE_POSITIONS_RAD = tuple(np.deg2rad(np.linspace(0, 40, 4)).tolist())

CELL_TOLERANCE_DEG = 1.0
CELL_TOLERANCE_REASON = (
    "a round number, fixed before the comparison; strict for steering, which moves by 2.9 deg per "
    "degree of side slope or tilt"
)


class _Condition(NamedTuple):
    """One of the 25 conditions: forces and true angles, at all positions of one control."""

    row: str
    column: str
    body_acc_mps2: FloatArray  # (3,), in {B}
    lever_acc_mps2: FloatArray  # (n, 3), in {T}
    steering_rad: ArrayLike
    throttle_rad: ArrayLike

    def size_deg(self, steering_rad: ArrayLike, throttle_rad: ArrayLike) -> FloatArray:
        """Absolute error of the control that the column is about, (n,) array, deg.

        Parameters
        ----------
        steering_rad, throttle_rad : (n,) arrays, rad, as estimated

        Returns
        -------
        (n,) array, deg
        """
        if self.column in "ab":
            return np.abs(np.rad2deg(np.subtract(steering_rad, self.steering_rad)))
        return np.abs(np.rad2deg(np.subtract(throttle_rad, self.throttle_rad)))


def static_table(
    geometry: ScooterGeometry = SUZUKI_ET4D,
    *,
    slope_rad: float = SLOPE_RAD,
    steering_positions_rad: Sequence[float] = STEERING_POSITIONS_RAD,
    throttle_positions_rad: Sequence[float] = THROTTLE_POSITIONS_RAD,
    left_row_ax_sign: int = -1,
) -> pd.DataFrame:
    """Table 1 by geometry alone: 25 conditions, one and two IMUs, MAE and SD of the error.

    Columns a and b of the table are steering errors with the throttle at its first and last
    position; c, d and e are throttle errors with the wheel straight, at the left and at the right
    end. The SD is that of the absolute error, with n - 1.

    Parameters
    ----------
    geometry : ScooterGeometry
    slope_rad : float, rad, of all four slopes
    steering_positions_rad : rad, positive to the left; the ends are "left max" and "right max"
    throttle_positions_rad : rad; the first is "min", the last "max"
    left_row_ax_sign : -1 if the row "left side slope" is the one with the body's x acceleration
        negative (left side up), +1 for the other; the paper does not say

    Returns
    -------
    DataFrame
        ``row`` (flat, upward, downward, left, right), ``column`` (a to e), ``quantity``
        (single_mae, single_sd, dual_mae, dual_sd), ``value`` and ``unit`` (deg).

    Raises
    ------
    InputError
        If ``left_row_ax_sign`` is not +1 or -1.

    Examples
    --------
    >>> table = static_table().set_index(["row", "column", "quantity"])["value"]
    >>> round(float(table["upward", "a", "single_mae"]), 2)
    9.92
    """
    import pandas as pd

    if left_row_ax_sign not in (-1, 1):
        raise InputError(f"left_row_ax_sign = {left_row_ax_sign}: expected +1 or -1")
    cells: list[tuple[str, str, str, float]] = []
    for one in _conditions(
        geometry,
        slope_rad,
        np.asarray(steering_positions_rad, float),
        np.asarray(throttle_positions_rad, float),
        left_row_ax_sign * slope_rad,
    ):
        for mode, known_body in (("single", None), ("dual", one.body_acc_mps2)):
            angles = estimate_angles(one.lever_acc_mps2, known_body, geometry)
            size_deg = one.size_deg(angles.steering_rad, angles.throttle_rad)
            cells.append((one.row, one.column, f"{mode}_mae", float(size_deg.mean())))
            cells.append((one.row, one.column, f"{mode}_sd", float(size_deg.std(ddof=1))))
    table = pd.DataFrame(cells, columns=["row", "column", "quantity", "value"])
    return table.assign(unit="deg")


def static_subtraction() -> pd.DataFrame:
    """Static test by geometry alone, with the body's acceleration subtracted from the lever's.

    The compensation of the paper's reference 37 under the conditions of Table 1, with the default
    assumptions of :func:`static_table`. The paper has no such table.

    Returns
    -------
    DataFrame
        MAE in deg, rows flat to right, columns a to e.
    """
    import pandas as pd

    table = pd.DataFrame(index=list(ROWS), columns=list(COLUMNS), dtype=float)
    for one in _conditions(
        SUZUKI_ET4D,
        SLOPE_RAD,
        np.asarray(STEERING_POSITIONS_RAD),
        np.asarray(THROTTLE_POSITIONS_RAD),
        -SLOPE_RAD,
    ):
        left = subtract_body(one.lever_acc_mps2, one.body_acc_mps2)
        angles = clipped_angles(left, None, SUZUKI_ET4D)
        size_deg = one.size_deg(angles.steering_rad, angles.throttle_rad)
        table.loc[one.row, one.column] = float(size_deg.mean())
    return table


def _conditions(
    geometry: ScooterGeometry,
    slope_rad: float,
    steering: FloatArray,
    throttle: FloatArray,
    left_roll_rad: float,
) -> Iterator[_Condition]:
    attitudes = [
        (0.0, 0.0), (slope_rad, 0.0), (-slope_rad, 0.0), (0.0, left_roll_rad), (0.0, -left_roll_rad)
    ]  # fmt: skip
    positions = {
        "a": (steering, throttle[0]),
        "b": (steering, throttle[-1]),
        "c": (0.0, throttle),
        "d": (steering.max(), throttle),
        "e": (steering.min(), throttle),
    }
    for row, (pitch_rad, roll_rad) in zip(ROWS, attitudes, strict=True):
        body = body_specific_force(pitch_rad, roll_rad)
        for column, (true_steering, true_throttle) in positions.items():
            lever = lever_acceleration(body, true_steering, true_throttle, geometry)
            yield _Condition(row, column, body, lever, true_steering, true_throttle)


def compare_static_table(ours: pd.DataFrame | None = None) -> pd.DataFrame:
    """Table 1 as printed beside ours, in the printed order.

    Parameters
    ----------
    ours : what :func:`static_table` gave; None computes it with the default assumptions

    Returns
    -------
    DataFrame
        ``row``, ``column``, ``quantity``, ``published``, ``ours``, ``difference`` (ours minus
        published) and ``unit`` (deg).
    """
    from mobility_imu.reproduction.published import load_published

    keys = ["row", "column", "quantity"]
    table = static_table() if ours is None else ours
    printed = load_published("scooter_table1")[[*keys, "value"]]
    both = printed.rename(columns={"value": "published"}).merge(
        table.rename(columns={"value": "ours"}), on=keys, validate="one_to_one"
    )
    both["difference"] = both["ours"] - both["published"]
    return both[[*keys, "published", "ours", "difference", "unit"]]
