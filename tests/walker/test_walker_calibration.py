"""Walker: the mount against simulated truth, and recordings that do not serve."""

import re
from dataclasses import replace

import numpy as np
import pytest
from walker_recordings import (
    DATASHEET,
    FRAME,
    cut_out,
    errors,
    placed,
    pose_mount,
    rebuilt,
    tilt_recording,
)

from mobility_imu.errors import InputError
from mobility_imu.recording import Imu, Recording
from mobility_imu.reproduction.walker.tables import POSES
from mobility_imu.simulation.levels import LEVELS, REAL_LEVEL, tilt_run
from mobility_imu.simulation.sensor import IDEAL, MTI_1, REAL
from mobility_imu.simulation.walker import (
    REALISTIC,
    measured_geometry,
    simulate_tilts,
)
from mobility_imu.walker import (
    NavigationSettings,
    WalkerGeometry,
    calibrate_mount,
    find_tilt_faults,
)
from mobility_imu.walker.arc_fit import ArcFit
from mobility_imu.walker.calibration import (
    _mount,
    _position_from_arcs,
    calibrate_from_path,
    with_sensor_errors,
)
from mobility_imu.walker.follow import navigate_recording
from mobility_imu.walker.footprint import footprint_warnings
from mobility_imu.walker.geometry import TILT_DIRECTIONS
from mobility_imu.walker.sensor_errors import (
    REST_WORDS,
    SCALES_OF_ACC,
    check_deviations,
    wrong_readings,
)
from mobility_imu.walker.tilt_detection import Tilt


@pytest.mark.parametrize("pose", POSES)
@pytest.mark.parametrize("method", ["four-tilts", "two-tilts", "all-samples"])
def test_perfect_recordings_give_the_mount_back(pose, method):
    """Without sensor errors what is left is the 100 Hz sampling: 1 mm and 0.05 deg."""
    found = calibrate_mount(tilt_recording(1, pose, IDEAL), FRAME, method=method)
    place, turn = errors(found, pose)
    assert np.abs(place).max() < 1e-3 and turn < np.deg2rad(0.05)
    assert [tilt.direction for tilt in found.tilts] == (
        ["back", "right"] if method == "two-tilts" else list(TILT_DIRECTIONS)
    )


# Of 25 draws a root mean square is known to 14 %, of 100 to 7 %.
draws = pytest.mark.parametrize("seeds", [5, pytest.param(20, marks=pytest.mark.slow)])


def monte_carlo(seeds, sensor, methods):
    """Root mean squares of the errors of each method over seeds x 5 poses: m, deg."""
    squares = []
    for seed in range(seeds):
        for pose in POSES:
            path, _ = navigate_recording(tilt_recording(seed, pose, sensor))
            off = [errors(calibrate_from_path(path, FRAME, method=m), pose) for m in methods]
            squares.append([(place @ place, np.rad2deg(turn) ** 2) for place, turn in off])
    return np.sqrt(np.mean(squares, axis=0))


@draws
def test_calibration_is_as_good_as_asked_with_noise_alone(seeds):
    (place, turn), (by_two_tilts, _) = monte_carlo(seeds, DATASHEET, ("all-samples", "two-tilts"))
    assert place <= 0.005 and turn <= 0.1 and by_two_tilts <= 0.008, (place, turn, by_two_tilts)


@draws
def test_calibration_is_as_good_as_asked_with_all_that_a_sensor_does(seeds):
    ((place, turn),) = monte_carlo(seeds, MTI_1, ("all-samples",))
    assert place <= 0.020 and turn <= 0.4, (place, turn)


def test_width_and_height_need_no_tape_with_the_whole_arcs():
    """A wrong width moves nothing when both side tilts are there; the arcs say what it is."""
    right = placed(tilt_recording(2), FRAME)
    wrong = placed(tilt_recording(2), WalkerGeometry(0.70, 0.52))
    assert np.allclose(
        right.mount.translation_body_m[1:], wrong.mount.translation_body_m[1:], atol=2e-3
    )
    assert np.allclose(right.footprint_m, (0.60, 0.52), atol=0.01)


def test_realistic_tilting_is_calibrated_within_a_few_centimetres():
    places = [
        errors(
            placed(
                tilt_recording(seed, pose, MTI_1, REALISTIC),
                measured_geometry(FRAME, REALISTIC, seed),
            ),
            pose,
        )[0]
        for seed in range(4)
        for pose in POSES
    ]
    assert np.sqrt(np.mean(np.sum(np.square(places), axis=1))) < 0.03


def test_no_still_phase_at_the_start():
    recording = tilt_recording()
    motion = simulate_tilts(FRAME, seed=0)
    shaken = recording.sensors["frame"].gyr_radps + 0.5 * np.sin(
        40 * recording.time_s
    )[:, None] * (recording.time_s < 6)[:, None]  # fmt: skip
    with pytest.raises(InputError, match="not still within the first 5 s"):
        calibrate_mount(
            Recording(
                recording.time_s, {"frame": Imu(recording.sensors["frame"].acc_mps2, shaken)}
            ),
            FRAME,
        )
    tilts = motion.tilts
    held = cut_out(recording, recording.time_s > tilts[0].held_from_s)
    with pytest.raises(InputError, match="expected rest on all four tips"):
        calibrate_mount(held, FRAME)
    late = cut_out(recording, recording.time_s > tilts[0].held_until_s + 0.3)
    found = calibrate_mount(late, FRAME, order=("back", "right", "left"))
    assert [tilt.direction for tilt in found.tilts] == ["back", "right", "left"]
    assert any("the frame moves at the start" in said for said in found.warnings)
    assert np.abs(errors(found, "1")[0]).max() < 0.01


def test_ill_conditioned_mounting_is_said():
    found = calibrate_mount(tilt_recording(1, "5"), FRAME, method="four-tilts", form="printed")
    assert any("ill-conditioned" in said and " x;" in said for said in found.warnings)


def test_calibration_from_path_refuses_an_unknown_method():
    path, _ = navigate_recording(tilt_recording())
    with pytest.raises(InputError, match="method = 'best'"):
        calibrate_from_path(path, FRAME, method="best")


def test_a_place_is_the_mean_of_its_arcs_with_what_they_scatter_by():
    """Five arcs, two of them to the front, of an IMU at (0.3, 0.1, 0.6), by hand.

    The front edge lies 2 cm farther than measured; heights of 0.60 scatter by 1 cm, ten times as
    much as stated. The sensor's noise is another standard deviation, by the same weights.
    """
    names = ["front", "front", "back", "right", "left"]
    place, heights = np.array([0.3, 0.1, 0.6]), 0.6 + 0.01 * np.array([1, -1, 1, -1, 0])
    edges = [FRAME.edge(name) for name in names]
    fits, tilts = [], []
    for name, edge, height in zip(names, edges, heights, strict=True):
        arm = (place - edge.point_m) * (1 - np.abs(edge.axis))
        arm += [-0.02 if name == "front" else 0.0, 0.0, height - place[2]]
        fits.append(ArcFit(edge.axis, arm, 1e-6 * np.eye(3), 0.001))
        tilts.append(Tilt(name, slice(0, 9), 5, 0.5))
    stated, noise = [1e-6 * np.eye(3)] * 5, [4e-6 * np.eye(3)] * 5
    found, sd, noise_sd = _position_from_arcs(fits, tilts, edges, np.eye(3), stated, noise)
    assert np.allclose(found, [0.29, 0.1, 0.6])
    # A trace of 3e-6 over two components; both fronts count as one arc.
    assert np.allclose(sd[:2], np.sqrt(1.5e-6 / 2))
    assert np.isclose(sd[2], np.std(heights, ddof=1) / np.sqrt(5))
    assert np.allclose(noise_sd, 2e-3 / np.sqrt([2 * 4 / 3, 2, 5]))


def test_the_larger_of_scatter_and_sensor_errors_is_stated():
    """Component by component; of those that scatter by nothing, the sensor's errors are left."""
    recording = tilt_recording()
    path, _ = navigate_recording(recording)
    arcs = calibrate_from_path(path, FRAME)
    scattered = replace(
        arcs,
        translation_sd_m=np.array([1.0, 1e-9, 2.0]),
        rotation_sd_rad=np.array([1e-9, 3.0, 1e-9]),
    )
    found = with_sensor_errors(
        scattered, path, recording, lambda wrong: navigate_recording(wrong)[0]
    )
    place, turn = found.translation_sd_m, found.rotation_sd_rad
    assert place[0] == 1.0 and place[2] == 2.0 and turn[1] == 3.0
    # They are larger than what the arcs tell of themselves, and smaller than any tape's.
    assert 1.2 * arcs.translation_sd_m[1] < place[1] < 0.02
    assert (1.2 * arcs.rotation_sd_rad[[0, 2]] < turn[[0, 2]]).all() and turn[[0, 2]].max() < 0.02
    assert np.array_equal(found.mount.translation_sd_m, place)
    assert np.array_equal(found.mount.rotation_sd_rad, turn)


def test_scales_of_the_accelerometer_are_those_of_the_wrong_readings():
    """One axis each is 1.003 times as large, and nothing else is changed."""
    recording = tilt_recording()
    imu = recording.sensor("frame")
    wrong = [each.sensor("frame") for each in wrong_readings(recording, 0.1, 0.003, 0.002)]
    assert len(wrong) == 21
    scaled = [
        (k, axis)
        for k, each in enumerate(wrong)
        for axis in range(3)
        if np.array_equal(each.gyr_radps, imu.gyr_radps)
        and np.allclose(each.acc_mps2, imu.acc_mps2 * (1 + 0.003 * np.eye(3)[axis]), rtol=1e-12)
    ]
    assert scaled == list(zip(SCALES_OF_ACC, range(3), strict=True))


def test_settings_of_a_sensor_that_its_maker_calibrates():
    """As the simulated MTi-1; without them, as the simulated cheap sensor."""
    own, usual = NavigationSettings.for_calibrated_sensor(), NavigationSettings()
    for settings, model in ((own, MTI_1), (usual, REAL)):
        assert settings.scale_sd == model.acc.scale_sd == model.gyr.scale_sd
        assert settings.axes_sd_rad == model.acc.misalignment_sd_rad
        assert settings.axes_sd_rad == model.gyr.misalignment_sd_rad


@pytest.mark.parametrize("axis", range(3))
def test_one_component_that_the_tilts_do_not_show_is_no_mount(axis):
    """A position that is known to 2 m at worst, and axes to half a turn, say nothing."""
    known, one = np.full(3, 0.01), np.eye(3)[axis]
    check_deviations(known + 1.9 * one, known + 3.1 * one)
    for place, turn in ((2.1, 0.0), (0.0, 3.2), (np.nan, 0.0)):
        with pytest.raises(InputError, match="leave the IMU's position uncertain"):
            check_deviations(known + place * one, known + turn * one)


def test_a_side_that_the_sensors_errors_explain_is_not_told():
    """17 cm are 3 cm of the tips and 2.8 standard deviations of 5 cm, 19 cm are 3.2.

    Exchanged sides are told anyway.
    """
    frame, sd = WalkerGeometry(0.6, 0.5), (0.05, 0.01)
    assert not footprint_warnings((0.69, 0.5), frame)
    for one_side in ((np.nan, 0.6), (0.5, np.nan)):
        assert not footprint_warnings(one_side, frame)
    assert len(footprint_warnings((0.77, 0.5), frame)) == 1
    assert not footprint_warnings((0.77, 0.5), frame, sd)
    assert len(footprint_warnings((0.79, 0.5), frame, sd)) == 1
    assert len(footprint_warnings((0.5, 0.6), frame, (0.1, 0.1))) == 2


def test_tilts_of_a_cheap_sensor_on_a_right_footprint_are_not_told():
    """By a sensor as real ones are the sides are 10 cm off, too much only for a calibrated one."""
    run, tape = tilt_run(82, "1", REAL_LEVEL)
    assert "poses" not in {fault.code for fault in find_tilt_faults(run.recording, tape)}
    sensor = NavigationSettings.for_calibrated_sensor()
    told = find_tilt_faults(run.recording, tape, settings=sensor)
    assert "poses" in {fault.code for fault in told}
    found = calibrate_mount(run.recording, tape)
    assert not any("footprint" in text for text in found.warnings)


@pytest.mark.parametrize("factor", [0.95, 1.05])
def test_an_accelerometer_whose_scale_spoils_the_mount_is_told(factor):
    """5 % of its scale move the height by many of its sd; what is stated is what it does."""
    run, tape = tilt_run(1, "2", LEVELS["realistic"])
    imu = run.recording.sensor("frame")
    sensor = {"settings": NavigationSettings.for_calibrated_sensor()}
    clean = calibrate_mount(run.recording, tape, **sensor)
    assert not any(REST_WORDS in text for text in clean.warnings)
    found = calibrate_mount(rebuilt(run.recording, acc=factor * imu.acc_mps2), tape, **sensor)
    (said,) = (text for text in found.warnings if REST_WORDS in text)
    moved = np.linalg.norm(found.mount.translation_body_m - clean.mount.translation_body_m)
    stated = float(re.search(r"about ([\d.]+) m", said)[1])
    assert stated == pytest.approx(moved, rel=0.25) and moved > 5 * found.translation_sd_m[2]
    assert ("too much" in said) == (factor > 1)


def test_a_mount_beyond_reach_is_no_unit_of_the_user():
    """He typed no position: the recording is what is wrong."""
    run, tape = tilt_run(1, "2", LEVELS["realistic"])
    imu = run.recording.sensor("frame")
    wrong = rebuilt(run.recording, acc=imu.acc_mps2 * [1, 1, 2])
    with pytest.raises(InputError, match=r"within 2 m: .*axes broken") as refused:
        calibrate_mount(wrong, tape)
    assert "cm or mm" not in str(refused.value)
    with pytest.raises(InputError, match="axes broken"):
        _mount(np.eye(3), np.array([0.1, -2.5, 0.3]))


@pytest.mark.parametrize("sd", [[5.0, 5.0, 5.0], [-0.1, 0, 0], [np.nan, 0, 0], [np.inf, 0, 0]])
@pytest.mark.parametrize("name", ["translation_sd_m", "rotation_sd_rad"])
def test_a_deviation_that_cannot_be_is_refused(name, sd):
    with pytest.raises(InputError, match=f"{name} = .*between 0 and"):
        replace(pose_mount("1"), **{name: sd})
