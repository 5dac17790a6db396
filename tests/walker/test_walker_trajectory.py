"""Walker: the path of the frame against simulated truth, equations 25 to 28."""

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from walker_recordings import (
    DATASHEET,
    FRAME,
    cut_out,
    pose_mount,
    rebuilt,
    walked,
)

from mobility_imu.errors import InputError
from mobility_imu.frames import STANDARD_GRAVITY_MPS2
from mobility_imu.recording import Imu, Recording
from mobility_imu.reproduction.walker.tables import POSES
from mobility_imu.simulation.sensor import IDEAL, MTI_1
from mobility_imu.simulation.walker import (
    CORRIDOR,
    REALISTIC,
    RECTANGLE,
    Leg,
    attach_imu,
    simulate_walk,
)
from mobility_imu.walker import (
    WalkerMount,
    estimate_trajectory,
    find_faults,
    valid_samples,
)
from mobility_imu.walker.follow import navigate_recording
from mobility_imu.walker.given_rests import LEAST_FITTING, shifted_rests
from mobility_imu.walker.navigation import (
    ClosedLoop,
    NavigationSettings,
    NavigationState,
    integrate_strapdown,
)
from mobility_imu.walker.trajectory import (
    _backward_fraction,
    _far_off,
    body_position,
    trajectory_from_path,
    walking_displacement,
)


@given(st.integers(0, 10**6))
@settings(max_examples=30, deadline=None)
def test_eq25_body_position_undoes_the_lever_arm(seed):
    rng = np.random.default_rng(seed)
    mount = WalkerMount(Rotation.random(random_state=seed).as_matrix(), rng.normal(size=3) / 3)
    body, attitude = rng.normal(size=(4, 3)), Rotation.random(4, random_state=seed + 1)
    imu = body + attitude.apply(np.array(mount.translation_body_m))
    q = (attitude * Rotation.from_matrix(mount.rotation_imu_to_body)).as_quat(scalar_first=True)
    place, turn = body_position(imu, q, mount)
    assert np.allclose(place, body) and np.allclose(turn, attitude.as_matrix())


@given(st.integers(0, 10**6), st.floats(-3, 3))
@settings(max_examples=30, deadline=None)
def test_eq26_to_eq28_an_error_of_the_mount_counts_by_the_turn(seed, heading):
    rng = np.random.default_rng(seed)
    arm, error, ends = rng.normal(size=3), rng.normal(size=3), rng.normal(size=(2, 3))
    one = np.eye(3)
    other = Rotation.from_rotvec([0, 0, heading]).as_matrix()
    body = [r - c @ arm for r, c in zip(ends, (one, other), strict=True)]
    assert np.allclose(walking_displacement(*ends, one, other, arm), body[1] - body[0])
    shift = walking_displacement(*ends, one, other, arm, error) - (body[1] - body[0])
    assert np.allclose(shift, -(other - one) @ error)
    assert np.isclose(np.linalg.norm(shift), 2 * abs(np.sin(heading / 2)) * np.hypot(*error[:2]))
    straight = walking_displacement(*ends, one, one, arm, error)
    assert np.allclose(straight, ends[1] - ends[0])


def test_saturation_is_said_and_survived():
    """Landings that hit the range: a warning, and a path that the next still phase catches."""
    motion = simulate_walk(CORRIDOR, seed=2)
    walk = attach_imu(motion, pose_mount("1"), DATASHEET, seed=1, unit_seed=1)
    imu = walk.recording.sensors["frame"]
    acc = imu.acc_mps2.copy()
    for step in motion.steps[3:6]:
        k = int(np.searchsorted(walk.recording.time_s, step.place_s - 0.05))
        acc[k : k + 4, 0] = 156.9
    recording = Recording(walk.recording.time_s, {"frame": Imu(acc, imu.gyr_radps)})
    found = estimate_trajectory(recording, FRAME, pose_mount("1"))
    assert any("saturated in 12 samples" in said for said in found.warnings)
    end = found.position_m[-1] - walk.position_body_m[-1]
    assert np.linalg.norm(end) < 0.1  # 7.9 m if the cut samples are believed
    whole = estimate_trajectory(walk.recording, FRAME, pose_mount("1"))
    assert found.horizontal_sd_m[-1] > whole.horizontal_sd_m[-1]


def test_strapdown_alone_over_ten_metres_with_the_true_stillness():
    """Noise-free: within 1e-4 m (issue)."""
    walk = attach_imu(simulate_walk(CORRIDOR, seed=4), pose_mount("2"), IDEAL, seed=0, unit_seed=0)
    imu = walk.recording.sensors["frame"]
    q = Rotation.from_matrix(walk.rotation_imu_to_world[0]).as_quat(scalar_first=True)
    start = NavigationState(q, *np.zeros((4, 3)))
    path = integrate_strapdown(
        walk.recording.time_s, imu.acc_mps2, imu.gyr_radps, start, still=walk.stationary
    )
    way = walk.position_imu_m - walk.position_imu_m[0]
    assert np.abs(path.position_m - way)[walk.stationary].max() < 1e-4


@pytest.mark.parametrize(
    ("sensor", "corridor_m", "rectangle_m"), [(DATASHEET, 0.02, 0.03), (MTI_1, 0.05, 0.10)]
)
def test_walks_are_as_good_as_asked(sensor, corridor_m, rectangle_m):
    """Mean absolute error of the 10 m, mean closing error of the rectangle; 4 seeds x 5 poses.

    The corridor-and-rectangle chapter holds the same limits over 20 seeds.
    """
    for course, limit in ((CORRIDOR, corridor_m), (RECTANGLE, rectangle_m)):
        off = []
        for seed in range(4):
            motion = simulate_walk(course, seed=seed)
            for pose in POSES:
                unit = 10 * seed + int(pose)
                walk = attach_imu(motion, pose_mount(pose), sensor, seed=unit, unit_seed=unit)
                found = estimate_trajectory(walk.recording, FRAME, pose_mount(pose))
                ends = [
                    np.linalg.norm(p[-1] - p[0]) for p in (found.position_m, walk.position_body_m)
                ]
                off.append(abs(ends[0] - ends[1]))
        assert np.mean(off) <= limit


def test_trajectory_table_and_heading():
    walk = attach_imu(simulate_walk(RECTANGLE, seed=1), pose_mount("4"), DATASHEET, seed=1, unit_seed=1)  # noqa: E501  # fmt: skip
    found = estimate_trajectory(walk.recording, FRAME, pose_mount("4"))
    table = found.to_frame()
    first = ["time_s", "x_m", "y_m", "z_m", "yaw_deg", "stationary"]
    assert list(table) == [*first, "x_sd_m", "y_sd_m", "z_sd_m", "yaw_sd_deg"]
    # Four corners to the left: once around.
    assert np.isclose(found.yaw_rad[-1], 2 * np.pi, atol=np.deg2rad(1))
    assert np.abs(found.position_m[found.stationary, 2]).max() < 0.01
    assert not found.warnings


@pytest.mark.parametrize("other", ["2", "3", "4", "5"])
def test_another_frames_mount_is_refused(other):
    """The mounts of Table 1 lean by 40 deg and more against each other."""
    with pytest.raises(InputError, match="leans by"):
        estimate_trajectory(walked().recording, FRAME, pose_mount(other))


def test_a_mount_that_moved_a_little_is_said():
    tilt = Rotation.from_rotvec([0, np.deg2rad(6.5), 0]).as_matrix()
    mount = pose_mount("1")
    moved = WalkerMount(tilt @ mount.rotation_imu_to_body, mount.translation_body_m)
    found = estimate_trajectory(walked().recording, FRAME, moved)
    assert any(re.search(r"leans by [67]\.\d deg", said) for said in found.warnings)


def test_wrong_units_and_signs_are_said():
    recording = walked().recording
    imu = recording.sensors["frame"]
    with pytest.raises(InputError, match="is time_s in ms"):
        estimate_trajectory(
            rebuilt(recording, time_s=1000 * recording.time_s), FRAME, pose_mount("1")
        )
    with pytest.raises(InputError, match="is the gyroscope in deg/s"):
        degrees = np.rad2deg(imu.gyr_radps)
        estimate_trajectory(rebuilt(recording, gyr=degrees), FRAME, pose_mount("1"))
    # What is said of a wrong sign does not depend on how many samples share an update.
    excess = []
    for resting in (1, 4):
        reversed_gyr = estimate_trajectory(
            rebuilt(recording, gyr=-imu.gyr_radps),
            FRAME,
            pose_mount("1"),
            settings=NavigationSettings(resting_stride=resting),
        )
        said = " ".join(reversed_gyr.warnings)
        excess.append(float(re.search(r"rests are ([\d.]+) times.*signs reversed", said)[1]))
    assert np.isclose(*excess, rtol=0.3), excess
    with pytest.raises(InputError, match="reversed"):
        estimate_trajectory(rebuilt(recording, acc=-imu.acc_mps2), FRAME, pose_mount("1"))
    acc, gyr = imu.acc_mps2.copy(), imu.gyr_radps.copy()
    acc[2000:2400], gyr[2000:2400] = acc[2000], gyr[2000]
    frozen = estimate_trajectory(rebuilt(recording, acc=acc, gyr=gyr), FRAME, pose_mount("1"))
    assert any("was the sensor frozen" in said for said in frozen.warnings)


def test_the_mounts_errors_are_in_the_paths(tmp_path):
    """A heading of the mount that is off by 1 deg turns 10 m by 17 cm; a file carries it."""
    mount, walk = pose_mount("1"), walked()
    stated = WalkerMount(
        mount.rotation_imu_to_body, mount.translation_body_m, [0, 0, np.deg2rad(1)], [0, 0, 0]
    )
    plain, doubtful = (estimate_trajectory(walk.recording, FRAME, m) for m in (mount, stated))
    extra = np.sqrt(doubtful.horizontal_sd_m[-1] ** 2 - plain.horizontal_sd_m[-1] ** 2)
    assert np.isclose(extra, 10 * np.deg2rad(1), rtol=0.02)
    text = (
        f"[walker.mount]\nrotation_imu_to_body = {mount.rotation_imu_to_body.tolist()}\n"
        "translation_body_m = [0.4, 0, 0.6]\nrotation_sd_rad = [0.1, 0.2, 0.3]\n"
    )
    (tmp_path / "m.toml").write_text(text)
    read = WalkerMount.from_toml(tmp_path / "m.toml")
    assert read.rotation_sd_rad.tolist() == [0.1, 0.2, 0.3] and read.translation_sd_m is None
    with pytest.raises(InputError, match="between 0 and"):
        WalkerMount(mount.rotation_imu_to_body, mount.translation_body_m, [-1, 0, 0])


def test_a_mount_turned_back_to_front_is_noticed_on_the_first_walk():
    walk = attach_imu(simulate_walk(CORRIDOR, seed=1), pose_mount("4"), DATASHEET, seed=1, unit_seed=1)  # noqa: E501  # fmt: skip
    mount = pose_mount("4")
    half = np.diag([-1.0, -1.0, 1.0])
    wrong = WalkerMount(half @ mount.rotation_imu_to_body, mount.translation_body_m)
    found = estimate_trajectory(walk.recording, FRAME, wrong)
    assert any("went backward" in said for said in found.warnings)


def test_closed_loop_moves_the_end_and_is_never_exact():
    """The constraint pulls the end towards the start, by as much as its sd allows."""
    motion = simulate_walk(RECTANGLE, seed=3, imperfections=REALISTIC)
    walk = attach_imu(motion, pose_mount("1"), MTI_1, seed=31, unit_seed=31)
    free, _ = navigate_recording(walk.recording)
    tied, _ = navigate_recording(walk.recording, closed_loop=ClosedLoop())
    loose, _ = navigate_recording(walk.recording, closed_loop=ClosedLoop(10.0, 10.0))
    gap = [np.linalg.norm(path.position_m[-1, :2]) for path in (free, tied, loose)]
    assert gap[1] < gap[0] and np.isclose(gap[2], gap[0], atol=1e-3)
    assert (tied.sd[-1, 6:8] < free.sd[-1, 6:8]).all()
    assert np.isclose(trajectory_from_path(tied, pose_mount("1")).horizontal_sd_m[0], 0, atol=1e-3)


def test_resting_recording_goes_nowhere():
    """A minute at rest: the frame stays where it is, to the millimetre."""
    rng = np.random.default_rng(0)
    mount = pose_mount("2")
    rest = mount.rotation_imu_to_body.T @ [0, 0, STANDARD_GRAVITY_MPS2]
    time = np.arange(6000) / 100
    recording = Recording(
        time,
        {"frame": Imu(rest + 0.012 * rng.standard_normal((6000, 3)),
                      0.0012 * rng.standard_normal((6000, 3)))},
    )  # fmt: skip
    found = estimate_trajectory(recording, FRAME, mount)
    assert np.abs(found.position_m).max() < 2e-3 and found.stationary.all()
    with pytest.raises(InputError, match="no sensor 'frame'"):
        estimate_trajectory(Recording(time, {"lever": recording.sensors["frame"]}), FRAME, mount)


@pytest.mark.parametrize(
    ("place", "off"),
    [
        ([-0.49, 0.0, 0.5], False),
        ([-0.51, 0.0, 0.5], True),
        ([1.01, 0.0, 0.5], False),
        ([1.03, 0.0, 0.5], True),
        ([0.2, 0.79, 0.5], False),
        ([0.2, -0.79, 0.5], False),
        ([0.2, 0.81, 0.5], True),
        ([0.2, -0.81, 0.5], True),
        ([0.2, 0.0, 1.49], False),
        ([0.2, 0.0, 1.51], True),
        ([0.2, 0.0, -0.01], True),
    ],
)
def test_a_mount_is_far_off_half_a_metre_beside_the_footprint(place, off):
    """Of 0.60 x 0.52 m; the origin is the middle of the rear tips."""
    said = _far_off(WalkerMount(np.eye(3), place), FRAME)
    assert len(said) == off and all("far off a frame of 0.6 x 0.52 m" in text for text in said)


@pytest.mark.parametrize("heading", [0.0, 2.0])
def test_the_backward_part_of_the_way_is_that_of_steps_against_the_forward_axis(heading):
    """Rests at 0, 0.6, 0.4 and 1.0 m ahead: 0.2 of 1.4 m; of less than a metre nothing is said."""
    turn = Rotation.from_rotvec([0, 0, heading]).as_matrix()
    along = np.interp(
        np.arange(70), [0, 10, 20, 30, 35, 45, 55, 69], [0, 0, 0.6, 0.6, 0.4, 0.4, 1, 1]
    )
    still = np.zeros(70, bool)
    for rest in (slice(0, 11), slice(20, 31), slice(35, 46), slice(55, 70)):
        still[rest] = True
    position, attitude = np.outer(along, turn[:, 0]), np.tile(turn, (70, 1, 1))
    assert _backward_fraction(position, attitude, still) == pytest.approx(0.2 / 1.4)
    assert _backward_fraction(-position, attitude, still) == pytest.approx(1.2 / 1.4)
    assert _backward_fraction(-0.7 * position, attitude, still) == 0.0


def test_each_error_of_a_mount_by_itself_moves_the_path_as_stated():
    """Two legs at right angles: the arm's errors by the turn, the heading's across the way."""
    path, _ = navigate_recording(walked(course=(Leg(2.0, np.pi / 2), Leg(1.0))).recording)
    mount = pose_mount("1")
    arm_sd, heading_sd = np.array([0.02, 0.03, 0.01]), 0.01

    def place(**changes):
        return trajectory_from_path(path, replace(mount, **changes)).position_m

    def extra(**sds):
        """Variances by what is stated of the mount."""
        known = {"translation_sd_m": None, "rotation_sd_rad": None}
        with_, without = (
            trajectory_from_path(path, replace(mount, **{**known, **each})) for each in (sds, {})
        )
        return with_.position_sd_m**2 - without.position_sd_m**2

    arm = mount.translation_body_m
    moved = [(place(translation_body_m=arm + e) - place()) / 1e-4 for e in 1e-4 * np.eye(3)]
    expected = np.einsum("inj,i->nj", np.square(moved), arm_sd**2)
    assert np.allclose(extra(translation_sd_m=arm_sd), expected, atol=1e-9)
    assert expected.max() > 1e-3
    # Without an arm, a mount that is turned by e turns the way by -e.
    turn = Rotation.from_rotvec([0, 0, 1e-4]).as_matrix() @ mount.rotation_imu_to_body
    zero = np.zeros(3)
    across = place(rotation_imu_to_body=turn, translation_body_m=zero)
    across = (across - place(translation_body_m=zero)) / 1e-4 * heading_sd
    mount = replace(mount, translation_body_m=zero)
    found = extra(rotation_sd_rad=[0.0, 0.0, heading_sd])
    assert np.allclose(found[:, :2], across[:, :2] ** 2, rtol=1e-3, atol=1e-7)
    assert not found[:, 2].any() and found.max() > (1.9 * heading_sd) ** 2


@pytest.mark.parametrize("samples", [3, 4, 50])
def test_a_few_samples_are_no_walk(samples):
    """Their path would have deviations of a hundredth of a millimetre."""
    recording = walked().recording
    with pytest.raises(InputError, match="expected a walk"):
        estimate_trajectory(cut_out(recording, slice(0, samples)), None, pose_mount("1"))


@pytest.mark.parametrize(("inside", "told"), [(8, False), (6, True)])
def test_rests_that_lie_among_the_others_by_more_than_chance_are_of_the_recording(inside, told):
    """The frame rests half of the time, in ten rests; one sample each is given as a rest.

    Of rests by chance half lie among the others, so that eight of ten fit by 0.6 and six by 0.2.
    """
    found = np.arange(2000) % 200 < 100
    given = np.zeros(2000, bool)
    given[np.arange(10) * 200 + np.where(np.arange(10) < inside, 60, 160)] = True
    assert ((inside / 10 - 0.5) / 0.5 < LEAST_FITTING) == told
    words = shifted_rests(given, found, 100.0)
    assert "do not resemble" in words if told else words is None


@pytest.mark.parametrize(
    ("shift_s", "told"), [(0.0, None), (0.1, None), (0.6, "earlier"), (-1.0, "later")]
)
def test_given_rests_of_another_clock_are_told_and_nothing_else_is(shift_s, told):
    """They come so much late: 0.1 s is how far the ends of a rest differ anyway."""
    motion = simulate_walk((Leg(3.0),), seed=4)
    run = attach_imu(motion, pose_mount("2"), MTI_1, seed=4, unit_seed=4)
    count = round(shift_s * run.recording.sampling_rate_hz)
    rests = np.roll(run.stationary, count)
    rests[:20] = True
    faults = find_faults(run.recording, None, pose_mount("2"), rests=rests)
    found = estimate_trajectory(run.recording, None, pose_mount("2"), rests=rests)
    if told is None:
        assert "rests" not in {fault.code for fault in faults}
    else:
        (fault,) = faults
        # The detector's rests end earlier than the true ones: the frame trembles before it lifts.
        stated = float(re.search(rf"about ([\d.]+) s {told}", fault.sentence)[1])
        assert fault.code == "rests" and stated == pytest.approx(abs(shift_s), abs=0.21)
        assert not valid_samples(found, faults).any()
        assert any("the given rests fit" in text for text in found.warnings)
