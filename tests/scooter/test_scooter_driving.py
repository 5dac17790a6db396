"""Scooter, driving: the paper's processing of a ride, baselines, and the study over scooters."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from mobility_imu.errors import InputError
from mobility_imu.filters import median_filter
from mobility_imu.frames import STANDARD_GRAVITY_MPS2
from mobility_imu.reproduction.scooter import driving as study
from mobility_imu.reproduction.scooter import driving_rides as rides
from mobility_imu.reproduction.scooter.paper_method import (
    clipped_angles,
    paper_angles,
    subtract_body,
)
from mobility_imu.scooter import SUZUKI_ET4D
from mobility_imu.scooter.angles import estimate_angles, steering_angle
from mobility_imu.scooter.fusion import complementary_angles
from mobility_imu.scooter.geometry import (
    ScooterGeometry,
    body_specific_force,
    lever_acceleration,
)

LEVEL = body_specific_force(0.0, 0.0)


class TestPrintedForms:
    def test_clipping_changes_nothing_where_an_angle_exists(self):
        steering, throttle = np.deg2rad(np.array([[-50, -20, 0, 30, 50], [0, 10, 20, 30, 40]]))
        body = body_specific_force(np.deg2rad(5), np.deg2rad(-4))
        angles = clipped_angles(
            lever_acceleration(body, steering, throttle, SUZUKI_ET4D), body, SUZUKI_ET4D
        )
        assert np.allclose(angles.steering_rad, steering) and not angles.clipped.any()
        assert np.allclose(angles.throttle_rad, throttle)

    def test_where_none_exists_the_arcsine_stops_at_a_right_angle(self):
        """Uphill at 7 deg and full lock one IMU saturates: NaN as printed, 90 deg if clipped."""
        uphill = body_specific_force(np.deg2rad(7), 0.0)
        lever = lever_acceleration(uphill, np.deg2rad([50]), 0.0, SUZUKI_ET4D)
        assert np.isnan(steering_angle(lever, LEVEL, SUZUKI_ET4D)).all()
        angles = clipped_angles(lever, None, SUZUKI_ET4D)
        assert np.allclose(np.rad2deg(angles.steering_rad), 90, atol=1e-3)
        assert angles.clipped.all() and np.isfinite(angles.throttle_rad).all()

    def test_subtraction_is_right_for_parallel_axes_only(self):
        """Frames parallel (alpha - beta = alpha, controls at rest): exact. Turned: not."""
        parallel = ScooterGeometry.from_degrees(20, 0)
        moved = body_specific_force(0.0, 0.0) + np.array([0.4, -0.7, 0.3])
        for steering_deg, exact in ((0, True), (40, False)):
            turned = np.deg2rad(steering_deg)
            lever = lever_acceleration(moved, turned, 0.0, parallel)
            angles = clipped_angles(subtract_body(lever, moved), None, parallel)
            off = np.rad2deg(abs(angles.steering_rad - turned))
            assert (off < 1e-9) if exact else (off > 1)

    def test_subtraction_takes_out_what_both_imus_feel(self):
        lever, body = np.array([0.1, 1.0, 9.6]), LEVEL + np.array([0.5, -0.2, 0.1])
        assert np.allclose(subtract_body(lever, body), lever - [0.5, -0.2, 0.1])


class TestPaperAngles:
    def ride(self, count=400):
        steering = np.deg2rad(20) * np.sin(np.arange(count) / 60)
        throttle = np.full(count, np.deg2rad(30))
        body = np.tile(LEVEL, (count, 1))
        return lever_acceleration(body, steering, throttle, SUZUKI_ET4D), body, steering

    def test_spikes_do_not_pass(self):
        lever, body, steering = self.ride()
        lever[50::60] += 6.0
        moving = np.ones(len(lever), bool)
        angles = paper_angles(lever, body, moving, SUZUKI_ET4D, method="dual", edge="nearest")
        assert np.rad2deg(np.abs(angles.steering_rad - steering)[20:-20].max()) < 1.5
        bare = paper_angles(lever, body, moving, SUZUKI_ET4D, method="dual", window=1)
        assert np.rad2deg(np.abs(bare.steering_rad - steering).max()) > 20

    def test_edges_differ_within_half_a_window_only(self):
        lever, body, _ = self.ride()
        lever = lever + np.random.default_rng(0).normal(0, 0.3, lever.shape)
        moving = np.ones(len(lever), bool)
        zero, nearest = (
            paper_angles(lever, body, moving, SUZUKI_ET4D, method="dual", edge=edge)
            for edge in ("zero", "nearest")
        )
        same = zero.steering_rad == nearest.steering_rad
        assert same[12:-12].all() and not same[:12].all() and not same[-12:].all()

    def test_extraction_comes_before_the_filter(self):
        """Samples at rest do not reach the window: cutting them by hand gives the same."""
        lever, body, _ = self.ride()
        moving = np.ones(len(lever), bool)
        moving[:100] = moving[200:250] = False
        whole = paper_angles(lever, body, moving, SUZUKI_ET4D, method="dual")
        cut = paper_angles(
            lever[moving], body[moving], np.ones(250, bool), SUZUKI_ET4D, method="dual"
        )
        assert np.array_equal(whole.steering_rad, cut.steering_rad)

    @pytest.mark.parametrize(
        ("change", "words"),
        [
            ({"body": None}, "body's sensor, which is missing"),
            ({"moving": np.zeros(400, bool)}, "only 0 samples in motion"),
            ({"moving": np.ones(9, bool)}, "moving: expected shape"),
            ({"method": "triple"}, "method = 'triple'"),
        ],
    )
    def test_bad_input(self, change, words):
        lever, body, _ = self.ride()
        given_ = {"body": body, "moving": np.ones(400, bool), "method": "dual"} | change
        with pytest.raises(InputError, match=words):
            paper_angles(
                lever, given_["body"], given_["moving"], SUZUKI_ET4D, method=given_["method"]
            )


class TestComplementary:
    def turning(self, bias_radps=0.0):
        """Controls moving on a scooter that stands level: gyroscopes from the hinges' rates."""
        time_s = np.arange(0, 40, 0.01)
        ease = np.clip(time_s - 1, 0, 1)
        steering = np.deg2rad(30) * np.sin(0.8 * time_s) * ease
        throttle = np.deg2rad(20) * (1 - np.cos(0.5 * time_s)) * ease
        body = np.tile(LEVEL, (len(time_s), 1))
        lever = lever_acceleration(body, steering, throttle, SUZUKI_ET4D)
        rates = np.gradient(steering, 0.01), np.gradient(throttle, 0.01)
        tipped = throttle + np.deg2rad(11)
        gyr = np.column_stack(
            [-rates[1] - bias_radps, -np.sin(tipped) * rates[0], np.cos(tipped) * rates[0]]
        )
        return lever, gyr, body, np.zeros_like(body), steering, throttle

    def test_follows_motion_without_lag(self):
        *signals, steering, throttle = self.turning()
        found = complementary_angles(*signals, 100.0, SUZUKI_ET4D)
        assert np.rad2deg(np.abs(found[0] - steering).max()) < 0.1
        assert np.rad2deg(np.abs(found[1] - throttle).max()) < 0.1

    def test_bias_leaves_bias_times_time_constant(self):
        bias = np.deg2rad(0.3)
        *signals, _, throttle = self.turning(bias)
        found = complementary_angles(*signals, 100.0, SUZUKI_ET4D, time_constant_s=1.5)
        assert np.isclose(np.median((found[1] - throttle)[1000:]), 1.5 * bias, rtol=0.1)

    def test_sees_no_future(self):
        *signals, _, _ = self.turning()
        whole = complementary_angles(*signals, 100.0, SUZUKI_ET4D)
        part = complementary_angles(*(s[:1000] for s in signals), 100.0, SUZUKI_ET4D)
        assert np.array_equal(whole[0][:1000], part[0])

    def test_bad_input(self):
        *signals, _, _ = self.turning()
        with pytest.raises(InputError, match="time_constant_s = 0"):
            complementary_angles(*signals, 100.0, SUZUKI_ET4D, time_constant_s=0)
        with pytest.raises(InputError, match="expected all"):
            complementary_angles(signals[0][:-1], *signals[1:], 100.0, SUZUKI_ET4D)


SMALL = study.StudySettings(drivers=1, runs=1, courses=("side", "tactile"), histograms=True)


@pytest.fixture(scope="module")
def small():
    return study.driving_study([0, 1], SMALL)


class TestStudy:
    def test_same_bytes_for_any_number_of_workers(self, small):
        with ThreadPoolExecutor(2) as pool:
            other = study.driving_study([0, 1], SMALL, executor=pool)
        assert small.table.to_csv() == other.table.to_csv()
        for key, values in small.durations_s.items():
            assert values.tobytes() == other.durations_s[key].tobytes()

    def test_scooters_do_not_depend_on_each_other(self, small):
        alone = study.driving_study([1], SMALL).table
        both = small.table[small.table["scooter"] == 1].reset_index(drop=True)
        assert alone.equals(both)

    def test_table_is_whole(self, small):
        table = small.table
        assert len(table) == 2 * 2 * 2 * len(study.ESTIMATORS) * 2 * 2
        assert not table.isna().any().any()
        assert (table["mae_deg"] > 0).all() and (table["p90_deg"] > table["mae_deg"]).all()

    def test_histograms_count_every_sample(self, small):
        rows = small.table[small.table["against"] == "wire"]
        for row in rows.itertuples():
            key = (row.scooter, row.course, row.mounting, row.estimator, row.angle)
            counts = small.errors[key]
            assert counts.sum() == row.n
            share = np.cumsum(counts) / row.n
            upper = study.ERROR_EDGES_DEG[1:][np.argmax(share >= 0.9)]
            # The quantile is interpolated between two samples, a bin is not.
            inside = upper - 0.6 <= row.p90_deg <= upper + 0.1
            assert inside or upper == study.ERROR_EDGES_DEG[-1]
        key = ("side", "known", "dual", "steering")
        names = ["course", "mounting", "estimator", "angle"]
        samples = rows.loc[(rows[names] == list(key)).all(axis=1), "n"].sum()
        assert np.isclose(small.durations_s[key].sum(), samples / 100)

    def test_known_mounting_takes_the_mounting_out(self):
        """Without any other effect, the drawn mounting is all the error, and knowing it heals."""
        quiet = rides.ablations()["nothing"]
        settings = study.StudySettings(
            drivers=1, runs=1, courses=("slopes",), estimators=("dual",),
            conditions=study.replace(quiet, mounting=True),
        )  # fmt: skip
        table = study.driving_study([3], settings).table
        p90 = table[table["against"] == "truth"].set_index(["mounting", "angle"])["p90_deg"]
        assert p90["as drawn"].max() > 0.5 and p90["known"].max() < 1e-6

    def test_without_any_effect_nothing_is_left(self):
        settings = study.StudySettings(
            drivers=1, runs=1, estimators=("dual",), calibrations={"as drawn": None},
            conditions=rides.ablations()["nothing"],
        )  # fmt: skip
        table = study.driving_study([0], settings).table
        assert table.loc[table["against"] == "truth", "p90_deg"].max() < 1e-6
        # The wire is read at 100 Hz on a clock found to half a sample.
        assert table.loc[table["against"] == "wire", "p90_deg"].max() < 0.5

    def test_straight_ahead_subtraction_is_the_dual_estimate_times_c1(self):
        """Wheel nearly straight: both have the lever's x less the body's x, over different C1."""
        ride = rides.make_ride(3, "slopes", 0, 0, rides.Conditions())
        moving, truth = rides.motion_and_truth(ride)
        found = study.estimate_ride(ride, moving, ["dual", "subtraction"])
        body = median_filter(ride.recording.sensor("body").acc_mps2[moving], 25, edge="zero")
        alpha = SUZUKI_ET4D.steering_inclination_rad
        c1 = body[:, 1] * np.cos(alpha) + body[:, 2] * np.sin(alpha)
        near = np.abs(truth["truth"][:, 0]) < np.deg2rad(5)
        scaled = found["dual"][:, 0] * c1 / (STANDARD_GRAVITY_MPS2 * np.sin(alpha))
        off_deg = np.rad2deg(np.abs(found["subtraction"][:, 0] - scaled))[near]
        apart_deg = np.rad2deg(np.abs(found["subtraction"] - found["dual"])[near, 0])
        assert np.quantile(off_deg, 0.95) < 0.2
        assert np.quantile(apart_deg, 0.95) > 2

    def test_body_x_only_is_the_dual_estimate_on_level_ground_without_y(self):
        """C1 = g sin(alpha) is true on a level course at constant speed: the two are the same."""
        ride = rides.make_ride(0, "straight", 0, 0, rides.ablations()["nothing"])
        moving, _ = rides.motion_and_truth(ride)
        found = study.estimate_ride(ride, moving, ["dual", "body's x only"], window=1)
        steady = np.abs(np.gradient(ride.speed_mps, ride.recording.time_s)[moving]) < 0.01
        apart = np.abs(found["dual"] - found["body's x only"])[steady, 0]
        assert np.rad2deg(apart.max()) < 0.1

    def test_single_errs_by_geometry_on_the_side_slope(self, small):
        """7 deg of roll look like asin(sin 7 / sin 20) = 20.9 deg of steering."""
        rows = small.table.set_index(["course", "mounting", "estimator", "angle", "against"])
        p90 = rows["p90_deg"]["side", "known", "single", "steering", "truth"]
        assert (p90 > 20.9).all()

    def test_bad_settings(self):
        for make, words in (
            (lambda: study.StudySettings(courses=("moon",)), "no .'moon'."),
            (lambda: study.StudySettings(estimators=("guess",)), "no .'guess'."),
            (lambda: study.StudySettings(runs=0), "runs = 0"),
            (lambda: study.driving_study([0, 0]), "different seeds"),
            (lambda: study.driving_study([-1]), "none negative"),
        ):
            with pytest.raises(InputError, match=words):
                make()


def test_printed_and_three_axis_forms_agree_on_a_ride():
    ride = rides.make_ride(0, "curves", 0, 0, rides.Conditions())
    moving, truth = rides.motion_and_truth(ride)
    dual = study.estimate_ride(ride, moving, ["dual"])["dual"]
    lever, body = (ride.recording.sensor(name).acc_mps2[moving] for name in ("lever", "body"))
    other = estimate_angles(
        median_filter(lever, 25, edge="zero"), median_filter(body, 25, edge="zero"), SUZUKI_ET4D
    )
    assert np.rad2deg(np.median(np.abs(dual[:, 0] - other.steering_rad))) < 0.5
    assert dual.shape == truth["wire"].shape == truth["truth"].shape
