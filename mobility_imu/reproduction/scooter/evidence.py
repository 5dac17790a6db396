"""Numbers behind the findings S1 to S8 about Suzurikawa et al. 2022."""

from __future__ import annotations

import numpy as np

from mobility_imu.frames import FloatArray
from mobility_imu.reproduction.findings import Evidence, Relation, quoted
from mobility_imu.reproduction.published import load_published
from mobility_imu.reproduction.recorded import numbers
from mobility_imu.reproduction.scooter.driving_record import recorded_study, smaller_than
from mobility_imu.reproduction.scooter.paper_method import clipped_angles, subtract_body
from mobility_imu.reproduction.scooter.static_table import (
    SLOPE_RAD,
    STEERING_POSITIONS_RAD,
    static_table,
)
from mobility_imu.rotations import elementary_rotation
from mobility_imu.scooter.angles import estimate_angles, steering_angle
from mobility_imu.scooter.geometry import (
    SUZUKI_ET4D,
    body_specific_force,
    lever_acceleration,
)

Evidences = tuple[Evidence, ...]


def range_of_the_throttle() -> Evidences:
    """S1: what 11.3 % of the throttle's range is."""
    share = quoted("S1", r"and ([0-9.]+)% of the movable")
    limit = quoted("S1", r"and ([0-9.]+)° for the steering and throttle angles")
    stated = quoted("S1", r"±50° and ([0-9.]+)°")
    return (
        Evidence(
            what="largest 90 % error of the throttle",
            first_from="11.3 % is the measured error, range of exactly 40°",
            first=share / 100 * stated,
            second_from='at most, if 11.3 % is the stated limit, range "approximately" 40°',
            second=limit,
            tolerance=0.05,
            unit="deg",
        ),
        Evidence(
            what="largest 90 % error in percent of the range",
            first_from="stated limit of 5°, range of exactly 40°",
            first=100 * limit / stated,
            second_from="as in the paper",
            second=share,
            tolerance=0.05,
            unit="%",
        ),
    )


def steering_about_a_vertical_axis() -> Evidences:
    """S2: how much the lever's reading changes with the steering."""

    def change(steering_inclination_deg: float) -> float:
        # By the rotations themselves: the package refuses a scooter with a vertical shaft.
        readings = [
            (
                elementary_rotation("x", np.deg2rad(steering_inclination_deg))
                @ elementary_rotation("z", np.deg2rad(wheel_deg))
                @ elementary_rotation("x", -np.deg2rad(steering_inclination_deg - 9))
                @ elementary_rotation("x", -0.3)
            ).T
            @ body_specific_force(0.0, 0.0)
            for wheel_deg in (-45, 0, 45)
        ]
        return float(np.ptp(readings, axis=0).max())

    return (
        Evidence(
            what="change of the lever's reading while the steering wheel turns from −45° to 45°",
            first_from='steering axis vertical, throttle axis level ("at least one")',
            first=change(0.0),
            second_from='neither axis vertical, the test scooter ("neither")',
            second=change(20.0),
            tolerance=1e-9,
            unit="m/s²",
        ),
    )


def beyond_the_domain() -> Evidences:
    """S3: mean error uphill over the steering range, readings without a real angle two ways."""
    wheel = np.deg2rad(np.linspace(-50, 50, 101))
    reading = lever_acceleration(body_specific_force(np.deg2rad(7), 0.0), wheel, 0.0, SUZUKI_ET4D)
    level = np.broadcast_to(body_specific_force(0.0, 0.0), reading.shape)
    plain = steering_angle(reading, level, SUZUKI_ET4D)
    clipped = clipped_angles(reading, None, SUZUKI_ET4D).steering_rad
    return (
        Evidence(
            what="mean absolute error of steering with one IMU, 7° uphill",
            first_from="arcsine's argument clipped to 1",
            first=float(np.rad2deg(np.abs(clipped - wheel).mean())),
            second_from="readings without a real angle dropped",
            second=float(np.rad2deg(np.nanmean(np.abs(plain - wheel)))),
            tolerance=0.1,
            unit="deg",
        ),
        Evidence(
            what="smallest steering angle without a real value, one IMU, 7° uphill",
            first_from="equation 6",
            first=_first_lost_deg(),
            second_from="end of the stated range",
            second=50.0,
            relation="first below",
            unit="deg",
        ),
    )


def _first_lost_deg() -> float:
    wheel = np.deg2rad(np.arange(0, 60, 0.01))
    reading = lever_acceleration(body_specific_force(np.deg2rad(7), 0.0), wheel, 0.0, SUZUKI_ET4D)
    level = np.broadcast_to(body_specific_force(0.0, 0.0), reading.shape)
    lost = np.isnan(steering_angle(reading, level, SUZUKI_ET4D))
    return float(np.rad2deg(wheel[lost][0]))


def right_side_slope() -> Evidences:
    """S4: single minus dual mean error of the throttle in row 5, by geometry and as printed."""
    printed = load_published("scooter_table1").set_index(["row", "column", "quantity"])["value"]
    ours = static_table().set_index(["row", "column", "quantity"])["value"]
    return tuple(
        Evidence(
            what=f"mean error of one IMU minus that of two, cell 5-{column}",
            first_from="as in the paper",
            first=float(
                printed["right", column, "single_mae"] - printed["right", column, "dual_mae"]
            ),
            second_from="change that the side slope causes, by geometry",
            second=float(ours["right", column, "single_mae"]),
            tolerance=0.25,
            unit="deg",
        )
        for column in "cde"
    )


def mean_and_percentile() -> Evidences:
    """S5: the paper's errors in percent of the throttle's range, as a mean and as a percentile."""
    cells = load_published("scooter_table1")
    throttle = cells[cells["column"].isin(list("cde")) & (cells["quantity"] == "dual_mae")]
    stated = quoted("S1", r"±50° and ([0-9.]+)°")
    return (
        Evidence(
            what="largest error of the throttle in percent of its range",
            first_from="mean absolute error, Table 1, two IMUs",
            first=100 * float(throttle["value"].max()) / stated,
            second_from="90 % error, section 3.2",
            second=quoted("S1", r"and ([0-9.]+)% of the movable"),
            tolerance=0.5,
            unit="%",
        ),
    )


def meaning_of_the_sd() -> Evidences:
    """S6: SD of cell 2-a by geometry, in two readings."""
    wheel = np.array(STEERING_POSITIONS_RAD)
    reading = lever_acceleration(body_specific_force(SLOPE_RAD, 0.0), wheel, 0.0, SUZUKI_ET4D)
    error = np.rad2deg(estimate_angles(reading, None, SUZUKI_ET4D).steering_rad - wheel)
    return (
        Evidence(
            what="SD of cell 2-a (published: 9.30°), by geometry",
            first_from="SD of the signed error",
            first=float(error.std(ddof=1)),
            second_from="SD of the absolute error",
            second=float(np.abs(error).std(ddof=1)),
            tolerance=1.0,
            unit="deg",
        ),
    )


def side_that_is_up() -> Evidences:
    """S7: the cell that changes most with the side that is up, and the cells that match."""
    keys = ["row", "column", "quantity"]
    printed = load_published("scooter_table1").set_index(keys)["value"]
    left, right = (static_table(left_row_ax_sign=sign).set_index(keys)["value"] for sign in (-1, 1))
    single = [key for key in left.index if key[2] == "single_mae"]
    cell = (left - right).abs()[single].idxmax()
    near = [float(((way - printed)[single].abs() <= 1).sum()) for way in (left, right)]
    return (
        Evidence(
            what=f'mean error with one IMU, row "{cell[0]} side slope", column {cell[1]}',
            first_from="left side up",
            first=float(left[cell]),
            second_from="left side down",
            second=float(right[cell]),
            tolerance=0.5,
            unit="deg",
        ),
        Evidence(
            what="cells of 25 with one IMU that geometry gives within 1°",
            first_from="left side up",
            first=near[0],
            second_from="left side down",
            second=near[1],
            relation="together",
        ),
    )


def merit_over_subtraction() -> Evidences:
    """S8: steering error of both methods, on a side slope and while braking on level ground."""

    def errors(body: FloatArray, wheel_deg: float, off_mps2: float) -> tuple[float, float]:
        wheel = np.deg2rad([-wheel_deg, wheel_deg])
        lever = lever_acceleration(body, wheel, np.deg2rad(30), SUZUKI_ET4D)
        lever = lever + np.array([off_mps2, 0.0, 0.0])  # whatever error the lever's x has
        ways = (
            clipped_angles(lever, np.broadcast_to(body, lever.shape), SUZUKI_ET4D),
            clipped_angles(subtract_body(lever, body), None, SUZUKI_ET4D),
        )
        dual, subtraction = (
            float(np.rad2deg(np.abs(way.steering_rad - wheel)).mean()) for way in ways
        )
        return dual, subtraction

    slope = body_specific_force(0.0, np.deg2rad(7))
    braking = body_specific_force(0.0, 0.0) + np.array([0.0, -1.0, 0.0])
    cases: tuple[tuple[str, tuple[float, float], Relation], ...] = (
        ("wheel at ±20°, side slope of 7°, ideal sensors", errors(slope, 20.0, 0.0), "first below"),
        (
            "wheel straight, braking by 1 m/s², lever's x wrong by 0.1 m/s²",
            errors(braking, 0.0, 0.1),
            "first above",
        ),
    )
    at_rest = tuple(
        Evidence(
            what=f"mean absolute steering error, {what}",
            first_from="the paper's form (equations 6 and 7)",
            first=dual,
            second_from="subtraction",
            second=subtraction,
            tolerance=0.05,
            unit="deg",
            relation=relation,
        )
        for what, (dual, subtraction), relation in cases
    )
    study = recorded_study(numbers("scooter_driving"))
    wins = int(smaller_than(study, "subtraction", "dual").loc["steering"].sum())
    return (
        *at_rest,
        Evidence(
            what="pairs of scooter and course, of 100, with the smaller 90 % error of steering",
            first_from="subtraction, simulated",
            first=float(wins),
            second_from="the paper's form, simulated",
            second=float(100 - wins),
            relation="first above",
        ),
    )
