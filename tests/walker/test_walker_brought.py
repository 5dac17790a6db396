"""Walker: recordings, rests and arguments as people bring them, each answered or refused."""

import functools
import warnings
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation
from walker_recordings import FRAME, cut_out, pose_mount, tilt_recording

from mobility_imu._compiled import HAVE_NUMBA
from mobility_imu.errors import InputError
from mobility_imu.recording import Imu, Recording
from mobility_imu.reproduction.walker.fault_kinds import clean_walk
from mobility_imu.reproduction.walker.fault_motions import turned_on_the_way, up_a_ramp
from mobility_imu.simulation import faults as inject
from mobility_imu.simulation.levels import LEVELS, MOUNTS, REAL_LEVEL, unit_of
from mobility_imu.simulation.walker import CORRIDOR, REALISTIC, attach_imu, simulate_walk
from mobility_imu.walker import (
    NavigationSettings,
    calibrate_mount,
    estimate_trajectory,
    find_faults,
    find_tilt_faults,
    valid_samples,
)
from mobility_imu.walker.calibration import calibrate_from_path
from mobility_imu.walker.error_state import NavigationState
from mobility_imu.walker.floor import KERB_M, slope_of_floor
from mobility_imu.walker.follow import as_sentences, navigate_recording
from mobility_imu.walker.geometry import rotation_body_to_world, rotation_world_to_imu
from mobility_imu.walker.navigation import integrate_strapdown, navigate, run_filter
from mobility_imu.walker.rest_checks import NO_ERROR, USUAL_ERRORS, _step
from mobility_imu.walker.stillness import find_stillness
from mobility_imu.walker.tilt_detection import find_tilts
from mobility_imu.walker.trajectory import body_position, trajectory_from_path

MOUNT = pose_mount("1")
SEED = 900_010

# A floor that is not level.


@functools.cache
def corridor(seed=SEED):
    return simulate_walk(CORRIDOR, seed=seed, imperfections=REALISTIC)


def rising(way_m, height_m, begin_m, length_m=0.35):
    """Height of a smooth rise along the way."""
    part = np.clip((way_m - begin_m) / length_m, 0, 1)
    return height_m * part**3 * (10 - 15 * part + 6 * part**2)


def on_floor(height_of_way, seed=SEED):
    """Walk of a frame that is set down on a floor of some height along x."""
    motion = corridor(seed)
    place = motion.position_m.copy()
    place[:, 2] += height_of_way(place[:, 0])
    return attached(replace(motion, position_m=place))


def attached(motion):
    return attach_imu(motion, MOUNT, LEVELS["realistic"].sensor, seed=SEED, unit_seed=SEED)


def on_ramp(degrees):
    motion = corridor()
    turn = Rotation.from_euler("y", -degrees, degrees=True).as_matrix()
    return attached(
        replace(
            motion,
            position_m=motion.position_m @ turn.T,
            rotation_body_to_world=turn @ motion.rotation_body_to_world,
        )
    )


@pytest.mark.parametrize("degrees", [9.0, 5.0, -8.0])
def test_a_ramp_that_z_follows_is_no_fault(degrees):
    """It begins level. The filter drops the height of a leaning frame; a late half was told."""
    walk = attached(up_a_ramp(corridor(), np.deg2rad(degrees)))
    path = estimate_trajectory(walk.recording, FRAME, MOUNT)
    rise = walk.position_body_m[-1, 2] - walk.position_body_m[0, 2]
    assert abs(rise) > 0.7
    assert abs(path.position_m[-1, 2] - rise) < 4 * path.position_sd_m[-1, 2] + 0.02
    assert told(walk.recording) == ()


def told(recording, **options):
    return find_faults(recording, FRAME, MOUNT, **options)


def placement(seed, number=14):
    """Where a step goes over a kerb: from the place of a placement on."""
    motion = corridor(seed)
    step = motion.steps[number]
    return motion.position_m[np.searchsorted(motion.time_s, step.lift_s), 0]


@pytest.mark.parametrize("height_m", [0.17, -0.17, 0.13])
@pytest.mark.parametrize("seed", [SEED, SEED + 1])
def test_a_kerb_is_told_with_its_height(seed, height_m):
    """The path stays at the height of the start, with a standard deviation of a millimetre."""
    begin = placement(seed)
    walk = on_floor(lambda x: rising(x, height_m, begin, 0.2), seed)
    (fault,) = told(walk.recording)
    path = estimate_trajectory(walk.recording, FRAME, MOUNT)
    assert abs(path.position_m[-1, 2]) < 0.01
    assert fault.code == "floor" and ("higher" if height_m > 0 else "lower") in fault.sentence
    assert fault.size == pytest.approx(abs(height_m), abs=0.035)
    assert fault.costs[0].name == "place"
    valid, lifted = valid_samples(path, [fault]), fault.first_s
    assert valid[: np.searchsorted(path.time_s, lifted - 3)].all() and not valid[-1]


def test_stairs_are_told_and_z_follows_if_the_floor_is_unknown():
    walk = on_floor(lambda x: sum(rising(x, 0.17, 2 + 0.6 * k) for k in range(8)))
    (fault,) = told(walk.recording)
    assert fault.code == "floor" and "height_noise_m_sqrthz=10" in fault.sentence
    free = NavigationSettings(height_noise_m_sqrthz=10)
    path = estimate_trajectory(walk.recording, FRAME, MOUNT, free)
    assert path.position_m[-1, 2] == pytest.approx(8 * 0.17, abs=3 * path.position_sd_m[-1, 2])
    assert told(walk.recording, settings=free) == ()


CALIBRATED = NavigationSettings.for_calibrated_sensor()


@pytest.mark.parametrize(
    ("degrees", "words", "settings"),
    [
        (3.0, "rises by 0.", CALIBRATED),
        (-3.0, "falls by 0.", CALIBRATED),
        (4.2, "rises by 0.", None),
        (-4.2, "falls by 0.", None),
    ],
)
def test_a_ramp_is_told(degrees, words, settings):
    """3 deg of 10 m are 0.52 m; gravity at rest errs by some hundredths of them.

    A sensor that may be 20 mg off, and its axes by 1 %, sees 1.4 deg of any straight way: only what
    is steep is told of it.
    """
    (fault,) = told(on_ramp(degrees).recording, settings=settings)
    assert fault.code == "floor" and words in fault.sentence
    assert fault.size == pytest.approx(10 * np.sin(np.deg2rad(abs(degrees))), abs=0.15)


@pytest.mark.parametrize("degrees", [2.9, 3.1])
def test_a_ramp_that_begins_level_is_told_by_any_sensor(degrees):
    """The frame comes to lean with it, which no constant error of the sensor does."""
    (fault,) = told(attached(up_a_ramp(corridor(), np.deg2rad(degrees))).recording)
    assert fault.code == "floor"
    assert fault.size == pytest.approx(0.45, abs=0.1)


@pytest.mark.parametrize("level", ["data sheet", "realistic", "real"])
def test_a_level_floor_is_not_told(level):
    for seed in range(900_020, 900_023):
        walk = clean_walk(seed, level, with_sd=False)
        found = find_faults(walk.walk.recording, walk.tape, walk.mount)
        assert "floor" not in {fault.code for fault in found}


def along_the_corridor(seed, pose):
    """Walk of a sensor as real ones are, whose accelerometer is 20 mg off (one sd)."""
    motion = simulate_walk(CORRIDOR, seed=seed, imperfections=REALISTIC)
    seeds = {"seed": 100 * seed + pose, "unit_seed": unit_of(seed, str(pose))}
    return attach_imu(motion, pose_mount(str(pose)), REAL_LEVEL.sensor, **seeds).recording


@pytest.mark.parametrize(("seed", "pose"), [(930_014, 5), (930_028, 4), (930_038, 4)])
def test_a_leaning_sensor_is_no_slope(seed, pose):
    """An accelerometer that is 20 mg off sees a level corridor rise or fall by 0.4 to 0.6 m."""
    found = find_faults(along_the_corridor(seed, pose), FRAME, pose_mount(str(pose)))
    assert "floor" not in {fault.code for fault in found}


@pytest.mark.parametrize(("seed", "pose"), [(930_026, 2), (930_030, 1), (940_074, 5)])
def test_a_leaning_sensor_is_no_lag(seed, pose):
    """The heights, which tell it from a lag, were dropped as those of a slope; or the fit began at
    the lag that explains most beside no offset, and stayed there. A true lag is still told, if not
    its size: without the heights it may be 0.14 s off.
    """
    sound, mount = along_the_corridor(seed, pose), pose_mount(str(pose))
    assert "lag" not in {fault.code for fault in find_faults(sound, FRAME, mount)}
    late = inject.late_half(sound, "frame", "gyr", 0.2)
    (lag,) = [fault for fault in find_faults(late, FRAME, mount) if fault.code == "lag"]
    assert lag.size == pytest.approx(0.2, abs=0.17)


def test_a_low_kerb_is_within_what_moves_show():
    walk = on_floor(lambda x: rising(x, KERB_M / 3, 5.0))
    assert told(walk.recording) == ()


def test_the_slope_of_a_floor_there_and_back():
    ways = np.array([[0.4, 0.1], [0.3, -0.1], [0.0, 0.5], [-0.4, 0.0], [-0.3, 0.0], [0.0, -0.5]])
    assert slope_of_floor(ways, ways @ [0.05, -0.02]) == pytest.approx([0.05, -0.02])
    assert not slope_of_floor(ways[:4], ways[:4] @ [0.05, -0.02]).any()


# Rests that are given.


@functools.cache
def clean(level="realistic"):
    return clean_walk(900_030, level, with_sd=False)


def with_rests(rests, **options):
    walk = clean()
    return find_faults(walk.walk.recording, walk.tape, walk.mount, rests=rests, **options)


def found_rests():
    walk = clean()
    path = estimate_trajectory(walk.walk.recording, walk.tape, walk.mount)
    late = len(walk.walk.recording) - len(path)
    return np.r_[np.zeros(late, bool), path.stationary]


def test_rests_whose_flags_are_exchanged_are_told_as_such():
    """Of many tables 1 is a move; a shift was told instead."""
    (fault,) = with_rests(~found_rests())
    assert fault.code == "rests" and "are 0 and 1 exchanged?" in fault.sentence
    assert "s later" not in fault.sentence and "s earlier" not in fault.sentence


def test_given_rests_may_be_what_is_wrong():
    """Not the frame, which would have rolled, nor the units of the sensor."""
    rests = found_rests()
    told = with_rests(np.ones_like(rests))
    assert told and all("or are the given rests wrong there?" in f.sentence for f in told)
    more = rests | (np.arange(len(rests)) % 200 < 40)
    assert any("or are the given rests wrong there?" in f.sentence for f in with_rests(more))
    assert with_rests(rests) == ()


# Rounded readings.


def rounded(recording, acc=None, gyr=None):
    imu = recording.sensor("frame")
    values = [
        half if step is None else np.round(half / step) * step
        for half, step in ((imu.acc_mps2, acc), (imu.gyr_radps, gyr))
    ]
    return Recording(recording.time_s, {"frame": Imu(*values)}, source="rounded.csv")


@pytest.mark.parametrize("steps", [(0.1, None), (0.25, None), (0.1, 0.01), (None, 0.0175)])
@pytest.mark.parametrize("seed", [900_201, 900_202])
@pytest.mark.parametrize("level", ["data sheet", "real"])
def test_coarse_steps_are_no_lag_and_no_scale(level, seed, steps):
    """Gravity of each rest errs alike by them, and a sound gyroscope was to be calibrated."""
    walk = clean_walk(seed, level, with_sd=False)
    found = find_faults(rounded(walk.walk.recording, *steps), walk.tape, walk.mount)
    assert {fault.code for fault in found} <= {"coarse"}


def test_a_gross_scale_is_told_in_coarse_steps_too():
    walk = clean_walk(900_201, "data sheet", with_sd=False)
    recording = rounded(walk.walk.recording, 0.1)
    imu = recording.sensor("frame")
    wrong = Recording(recording.time_s, {"frame": Imu(imu.acc_mps2, 1.5 * imu.gyr_radps)})
    assert "scale" in {f.code for f in find_faults(wrong, walk.tape, walk.mount)}


# Tilts.


def test_a_late_half_of_the_tilts_is_not_told_as_rolled():
    recording = tilt_recording(seed=900_040)
    imu = recording.sensor("frame")
    gyr = pd.DataFrame(imu.gyr_radps).shift(20).bfill().to_numpy()
    late = Recording(recording.time_s, {"frame": Imu(imu.acc_mps2, gyr)}, source="late.csv")
    codes = [fault.code for fault in find_tilt_faults(late, FRAME)]
    assert "lag" in codes and "rolls" not in codes


@pytest.mark.parametrize("begin_s", [3.4, 4.0])
def test_tilts_whose_first_rest_is_a_tilt_are_refused_as_such(begin_s):
    """None of the tilts ends "before the recording ends"."""
    recording = tilt_recording(seed=900_040)
    cut = cut_out(recording, recording.time_s > begin_s)
    with pytest.raises(InputError, match=r"first rest, at .* s, is tilted by \d+ deg") as error:
        calibrate_mount(cut, FRAME)
    assert "before the recording ends" not in str(error.value)


# Sensors that are turned on the frame, or mirrored.


def remounted(degrees, from_s):
    """Recording of a sensor that is turned about the frame's vertical at rest."""
    recording, body = clean().walk.recording, clean().mount.rotation_imu_to_body
    turn = body.T @ Rotation.from_euler("z", degrees, degrees=True).as_matrix() @ body
    imu, late = recording.sensor("frame"), (recording.time_s > from_s)[:, None]
    halves = (np.where(late, half @ turn, half) for half in (imu.acc_mps2, imu.gyr_radps))
    return Recording(recording.time_s, {"frame": Imu(*halves)}, source="remounted.csv")


@pytest.mark.parametrize("degrees", [-30, 90, 180])
def test_a_sensor_that_is_turned_on_the_way_is_told(degrees):
    """The path bends, or comes back, from there on; the mean of all steps says another angle."""
    walk = clean()
    path = estimate_trajectory(walk.walk.recording, walk.tape, walk.mount)
    rests = np.flatnonzero(path.stationary & (path.time_s > 25))
    recording = remounted(degrees, path.time_s[rests[5]])
    found = find_faults(recording, walk.tape, walk.mount)
    (turned,) = [fault for fault in found if fault.code == "turned"]
    assert abs(turned.size) == pytest.approx(abs(degrees), abs=8)
    assert f"{abs(turned.size):.0f} deg further" in turned.sentence
    assert abs(turned.first_s - path.time_s[rests[5]]) < 6
    bent = estimate_trajectory(recording, walk.tape, walk.mount)
    valid = valid_samples(bent, found)
    assert valid[bent.time_s < 15].all() and not valid[-1]


def test_a_sensor_that_is_turned_after_three_steps_is_told():
    """It was told as one that was turned throughout, or not at all."""
    walk = clean()
    path = estimate_trajectory(walk.walk.recording, walk.tape, walk.mount)
    third = walk.walk.motion.steps[2].place_s
    found = find_faults(
        remounted(60, path.time_s[path.stationary & (path.time_s > third)][5]),
        walk.tape,
        walk.mount,
    )
    (turned,) = [fault for fault in found if fault.code == "turned"]
    assert "further to the" in turned.sentence and not turned.flags.all()
    assert abs(turned.size) == pytest.approx(60, abs=12)
    assert abs(turned.first_s - third) < 6


@pytest.mark.parametrize("degrees", [-15, 20, 60])
def test_a_turn_on_the_way_that_the_gyroscope_feels_costs_the_heading_so_much(degrees):
    """Told as a mount that is turned throughout, it seemed to cost a tenth of a degree."""
    walk = clean()
    motion = walk.walk.motion
    fits = turned_on_the_way(
        motion, MOUNTS[walk.pose], np.deg2rad(degrees), 0.25 * motion.time_s[-1]
    )
    recording = walk.followed(fits).recording
    found = find_faults(recording, walk.tape, walk.mount)
    (turned,) = [fault for fault in found if fault.code == "turned"]
    assert "further to the" in turned.sentence and not turned.flags.all()
    right = estimate_trajectory(walk.walk.recording, walk.tape, walk.mount)
    wrong = estimate_trajectory(recording, walk.tape, walk.mount)
    off = abs(wrong.yaw_rad[-1] - right.yaw_rad[-1])
    costs = {cost.name: cost.largest for cost in turned.costs}
    assert costs["heading"] == pytest.approx(np.rad2deg(off), abs=5)
    apart = np.linalg.norm((wrong.position_m[-1] - right.position_m[-1])[:2])
    assert costs["place"] == pytest.approx(apart, rel=0.3, abs=0.02)
    assert not valid_samples(wrong, found)[-1]


@pytest.mark.parametrize("after_s", [14, 25])
@pytest.mark.parametrize("degrees", [-25, 40])
def test_a_turn_that_the_gyroscope_did_not_feel_has_no_cost(degrees, after_s):
    """The heading goes on as if nothing were, and the way is bent: by how much nobody knows.

    At the walk's corner the heading turns by itself, which is not the turn of the sensor.
    """
    walk = clean()
    path = estimate_trajectory(walk.walk.recording, walk.tape, walk.mount)
    rests = np.flatnonzero(path.stationary & (path.time_s > after_s))
    found = find_faults(remounted(degrees, path.time_s[rests[5]]), walk.tape, walk.mount)
    told = [fault for fault in found if fault.code == "turned"]
    assert told and not any(fault.costs for fault in told)


@pytest.mark.parametrize("degrees", [-8, 15])
def test_a_mount_that_is_turned_throughout_is_not_turned_on_the_way(degrees):
    walk = clean()
    found = find_faults(remounted(degrees, -1.0), walk.tape, walk.mount)
    (turned,) = [fault for fault in found if fault.code == "turned"]
    assert turned.flags.all() and turned.repair is not None
    assert abs(turned.size) == pytest.approx(abs(degrees), abs=3)


def test_readings_that_come_twice_make_no_end_of_a_range():
    """One axis seemed to end at 5.9 m/s², while another read twice as much."""
    walk = clean_walk(312_048, "real", with_sd=False)
    sound = walk.walk.recording
    assert find_faults(sound, walk.tape, walk.mount) == ()
    cut = inject.clip(sound, "frame", "acc", 10.0)
    assert "range" in {f.code for f in find_faults(cut, walk.tape, walk.mount)}


def test_what_moves_do_not_show_is_as_unsure_as_it_was_known():
    """An offset that no move feels has the deviation of data sheets, however well all fit."""
    rng = np.random.default_rng(1)
    slopes = rng.standard_normal((8, 20, 6))
    slopes[2] = 0.0
    _, sd = _step(0.01 * rng.standard_normal((20, 6)), slopes, NO_ERROR)
    assert sd[2] == pytest.approx(USUAL_ERRORS[2])
    assert sd[0] < 0.05 * USUAL_ERRORS[0]


@pytest.mark.parametrize("seed", [500_027, 500_111, 500_127])
def test_scales_that_cheap_sensors_make_up_are_not_told(seed):
    """The accelerometer's offset, which few moves show, was 7 to 12 % of the gyroscope's scale."""
    walk = clean_walk(seed, "real", with_sd=False)
    assert find_faults(walk.walk.recording, walk.tape, walk.mount) == ()


@pytest.mark.parametrize("axis", [0, 2])
def test_a_mirrored_accelerometer_may_have_mirrored_the_path(axis):
    """From rest to rest two axes of the gyroscope read the same; what it costs is not the same."""
    walk = clean()
    recording = walk.walk.recording
    imu, signs = recording.sensor("frame"), np.ones(3)
    signs[axis] = -1
    wrong = Recording(recording.time_s, {"frame": Imu(signs * imu.acc_mps2, imu.gyr_radps)})
    (fault,) = [f for f in find_faults(wrong, walk.tape, walk.mount) if f.code == "reversed"]
    assert f"or axis {'xyz'[axis]} of the accelerometer has, and the path is mi" in fault.sentence


# Arguments of the functions inside.


@functools.cache
def short():
    """Times, readings, rests, start and path of some seconds."""
    recording = clean().walk.recording
    path, _ = navigate_recording(cut_out(recording, recording.time_s < 6))
    kept = recording.time_s < 6
    imu = recording.sensor("frame")
    late = int(kept.sum()) - len(path.time_s)
    return (
        path.time_s, imu.acc_mps2[kept][late:], imu.gyr_radps[kept][late:], path.still, path,
    )  # fmt: skip


STRANGE = (None, 3, "x", "1", 1j, [1, 2], {}, np.ones((3, 2)), pd.DataFrame([[1.0]]), object())


def calls(strange):
    time, acc, gyr, still, path = short()
    start, settings = path.state(0), NavigationSettings()
    p = 1e-4 * np.eye(15)
    yield lambda: integrate_strapdown(time, acc, gyr, strange, still=still)
    yield lambda: run_filter(time, acc, gyr, still, strange, p, settings)
    yield lambda: run_filter(time, acc, gyr, still, start, strange, settings)
    yield lambda: run_filter(time, acc, gyr, still, start._replace(quaternion=strange), p, settings)
    yield lambda: run_filter(
        time, acc, gyr, still, start._replace(velocity_mps=strange), p, settings
    )
    yield lambda: body_position(strange, path.quaternion, MOUNT)
    yield lambda: body_position(path.position_m, strange, MOUNT)
    yield lambda: body_position(path.position_m, path.quaternion, strange)
    yield lambda: trajectory_from_path(strange, MOUNT)
    yield lambda: trajectory_from_path(path, strange)
    yield lambda: find_tilts(strange)
    yield lambda: rotation_world_to_imu(strange)
    yield lambda: rotation_body_to_world(strange)
    if strange is not None:
        yield lambda: run_filter(time, acc, gyr, still, start, p, settings, observed=strange)
        yield lambda: trajectory_from_path(path, MOUNT, closed_loop=strange)
        yield lambda: calibrate_from_path(path, FRAME, settings=strange)
    if not isinstance(strange, dict):  # of no sentences
        yield lambda: as_sentences(strange)


@pytest.mark.parametrize("strange", STRANGE, ids=lambda value: type(value).__name__)
def test_arguments_of_another_kind_are_named(strange):
    for call in calls(strange):
        with pytest.raises(InputError) as error:
            call()
        assert len(str(error.value)) < 400


@pytest.mark.parametrize("warned", [None, 3, "one text", [1], (None,)])
def test_warnings_are_sentences(warned):
    path = short()[-1]
    for call in (
        lambda: trajectory_from_path(path, MOUNT, warnings=warned),
        lambda: calibrate_from_path(path, FRAME, warnings=warned),
    ):
        with pytest.raises(InputError, match="warnings: got"):
            call()


@pytest.mark.parametrize("count", [0, 3, 5])
def test_positions_belong_to_their_quaternions(count):
    path = short()[-1]
    with pytest.raises(InputError, match="expected one position for each quaternion"):
        body_position(path.position_m[:count], path.quaternion, MOUNT)


@pytest.mark.parametrize("half", [1, 2])
def test_huge_readings_are_refused_without_a_word_of_numpy(half):
    given = list(short()[:4])
    given[half] = np.full_like(given[half], 1e308)
    start = NavigationState(np.array([1e200, 0, 0, 0]), *np.zeros((4, 3)))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for call in (
            lambda: navigate(*given),
            lambda: integrate_strapdown(*given[:3], start),
            lambda: find_stillness(given[1], given[2], 100.0),
        ):
            with pytest.raises(InputError, match=r"no finite end|reaches 1e\+308"):
                call()


@pytest.mark.parametrize("rate_hz", [2e5, 1e12, 1e308])
def test_a_rate_that_no_sensor_has_is_refused_at_once(rate_hz):
    _, acc, gyr, _, _ = short()
    with pytest.raises(InputError, match="sampling_rate_hz = "):
        find_stillness(acc, gyr, rate_hz)


# Settings whose numbers lie too far apart.


@pytest.mark.parametrize("name", ["velocity_noise_mps_sqrthz", "height_noise_m_sqrthz"])
def test_settings_that_leave_the_filter_no_digits_are_refused(name):
    """The smoothed path went 1e45 m, or 91 km with a stated 1 km, and passed for a foot's."""
    walk, settings = clean(), NavigationSettings(**{name: 1e-12})

    def path(*given):
        return estimate_trajectory(walk.walk.recording, walk.tape, walk.mount, *given)

    if HAVE_NUMBA:
        with pytest.raises(InputError, match="m/s where it is still: the noises of the settings"):
            path(settings)
    else:  # the readable form keeps its digits
        usual = path()
        off = np.abs(path(settings).position_m[-1] - usual.position_m[-1])
        assert (off < usual.position_sd_m[-1]).all()
