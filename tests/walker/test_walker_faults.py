"""Faults of a walking frame's one sensor: each is found and named, priced, and never imagined."""

import functools
import pickle

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from walker_recordings import placed

from mobility_imu.errors import InputError
from mobility_imu.faults import rescaled
from mobility_imu.recording import Imu, Recording
from mobility_imu.reproduction.walker.fault_kinds import KINDS, TILT_KINDS, clean_walk
from mobility_imu.reproduction.walker.fault_motions import foot_motion, rolling_motion, shaken
from mobility_imu.simulation import faults as inject
from mobility_imu.walker import (
    NavigationSettings,
    WalkerGeometry,
    WalkerMount,
    estimate_trajectory,
    find_faults,
    find_tilt_faults,
    valid_samples,
)
from mobility_imu.walker.faults import not_told
from mobility_imu.walker.geometry import TILT_DIRECTIONS
from mobility_imu.walker.rest_checks import Readings, fit_halves, moves_between_rests

SEED = 4001


@functools.cache
def walked(level="realistic", seed=SEED):
    return clean_walk(seed, level, with_sd=False)


@functools.cache
def path(level="realistic"):
    walk = walked(level)
    return estimate_trajectory(walk.walk.recording, walk.tape, walk.mount)


def found_in(recording, mount=None, **options):
    walk = walked()
    return find_faults(recording, walk.tape, mount or walk.mount, **options)


def turned(recording, axis_deg):
    """Recording of a sensor that is turned in its place, by a rotation vector of the body."""
    body = walked().mount.rotation_imu_to_body
    turn = body.T @ Rotation.from_rotvec(np.deg2rad(axis_deg)).as_matrix() @ body
    return inject.turn(recording, "frame", turn)


def jumped(recording):
    late = (recording.time_s > 25)[:, None]
    imu = recording.sensor("frame")
    rates = imu.gyr_radps + late * np.deg2rad([1.0, 0.0, 1.0])
    return Recording(recording.time_s, {"frame": Imu(imu.acc_mps2, rates)}, source="jumps")


CLEAR = {
    "gyroscope freezes": ("frozen", lambda r: inject.freeze(r, "frame", "gyr", 14.0, 4.0)),
    "accelerometer freezes": ("frozen", lambda r: inject.freeze(r, "frame", "acc", 14.0, 4.0)),
    "gyroscope dies": ("frozen", lambda r: inject.silence(r, "frame", 20.0)),
    "axis dies": ("dead axis", lambda r: inject.scale(r, "frame", "gyr", [1, 0, 1])),
    "range, gyroscope": ("range", lambda r: inject.clip(r, "frame", "gyr", np.deg2rad(30))),
    "range, accelerometer": ("range", lambda r: inject.clip(r, "frame", "acc", 9.6)),
    "spike of the gyroscope": ("spike", lambda r: inject.spike(r, "frame", "gyr", [2500], 1, 5.0)),
    "spike, small": ("spike", lambda r: inject.spike(r, "frame", "acc", [2500], 0, 15.0)),
    "offset jumps": ("offset", jumped),
    "scale": ("scale", lambda r: inject.scale(r, "frame", "gyr", 1.2)),
    "gravity": ("gravity", lambda r: inject.scale(r, "frame", "acc", 1.1)),
    "late": ("lag", lambda r: inject.late_half(r, "frame", "gyr", 0.15)),
    "early": ("lag", lambda r: inject.late_half(r, "frame", "gyr", -0.3)),
    "reversed": ("reversed", lambda r: inject.reverse(r, "frame")),
    "one axis reversed": ("reversed", lambda r: inject.reverse(r, "frame", [1, -1, 1])),
    "leans": ("turned", lambda r: turned(r, [8.0, 0.0, 0.0])),
    "turned aside": ("turned", lambda r: turned(r, [0.0, 0.0, 15.0])),
    "backward": ("turned", lambda r: turned(r, [0.0, 0.0, 180.0])),
}


@pytest.mark.parametrize("level", ["data sheet", "sensor", "realistic", "real"])
def test_nothing_is_found_where_nothing_is_wrong(level):
    walk = walked(level)
    assert find_faults(walk.walk.recording, walk.tape, walk.mount) == ()
    assert find_tilt_faults(walk.tilts.recording, walk.tape) == ()
    assert valid_samples(path(level), ()).all()


ADVICE = (
    "leave these times out", "use another sensor", "choose a wider range", "remove them",
    "calibrate the mount again", "read both halves with one clock", "check the export's axes",
)  # fmt: skip
"""What a sentence ends with: what the reader does next."""


@pytest.mark.parametrize("kind", CLEAR)
def test_a_clear_fault_is_named(kind):
    code, change = CLEAR[kind]
    faulty = change(walked().walk.recording)
    found = found_in(faulty)
    # And nothing else, but for rests that do not fit because of it.
    assert [fault.code for fault in found if fault.code != "at odds"] == [code], found
    for fault in found:
        assert fault.flags.any() and fault.first_s == faulty.time_s[fault.flags.argmax()]
        assert fault.code == "at odds" or any(words in fault.sentence for words in ADVICE)
    pickle.loads(pickle.dumps(found))


@pytest.mark.parametrize(
    "kind",
    ["range, gyroscope", "spike of the gyroscope", "offset jumps", "scale", "gravity", "late",
     "early", "reversed", "leans", "turned aside"],
)  # fmt: skip
def test_the_stated_cost_is_what_the_fault_moves(kind):
    """Within 30 %, of each result that it moves by more than the standard deviation at the end."""
    code, change = CLEAR[kind]
    faulty = change(walked().walk.recording)
    moved = estimate_trajectory(faulty, walked().tape, walked().mount)
    clean = path()
    if len(moved) != len(clean):  # a late half cuts the ends off

        def at(series):
            return np.interp(moved.time_s, clean.time_s, series)

        apart = [moved.position_m[:, k] - at(clean.position_m[:, k]) for k in range(3)]
        place = np.linalg.norm(apart, axis=0)
        heading = np.abs(moved.yaw_rad - at(clean.yaw_rad))
    else:
        place = np.linalg.norm(moved.position_m - clean.position_m, axis=1)
        heading = np.abs(moved.yaw_rad - clean.yaw_rad)
    real = {"place": place.max(), "heading": np.rad2deg(heading).max()}
    (fault,) = [one for one in found_in(faulty) if one.code == code][:1]
    stated = {cost.name: cost.largest for cost in fault.costs}
    sds = np.linalg.norm(moved.position_sd_m[-1]), np.rad2deg(moved.yaw_sd_rad[-1])
    names = [name for name, sd in zip(real, sds, strict=True) if real[name] > sd]
    assert "place" in names
    for name in names:
        assert 1 / 1.3 < stated[name] / real[name] < 1.3
        assert f"the {name} by up to" in fault.told


@pytest.mark.parametrize("kind", ["gyroscope freezes", "gyroscope dies", "axis dies"])
def test_what_cannot_be_known_has_no_cost(kind):
    """And everything after it, from the rest before it on, is not valid."""
    _, change = CLEAR[kind]
    faulty = change(walked().walk.recording)
    found = found_in(faulty)
    assert not found[0].costs and "is not known" in found[0].told
    moved = estimate_trajectory(faulty, walked().tape, walked().mount)
    valid = valid_samples(moved, found)
    first = int(np.argmax(found[0].flags[-len(moved) :]))
    rested = np.flatnonzero(moved.stationary[:first])
    first = int(rested[-1]) if len(rested) else 0
    assert valid[:first].all() and not valid[first:].any()


def test_a_spike_that_costs_little_spoils_its_own_sample_alone():
    faulty = inject.spike(walked().walk.recording, "frame", "gyr", [2500], 1, 1.0)
    moved = estimate_trajectory(faulty, walked().tape, walked().mount)
    valid = valid_samples(moved, found_in(faulty))
    assert np.flatnonzero(~valid).tolist() == [2500 - len(faulty) + len(moved)]


def test_an_offset_is_taken_off_and_costs_nothing():
    wrong = inject.offset(walked().walk.recording, "frame", "gyr", np.deg2rad([3.0, -2.0, 1.0]))
    assert found_in(wrong) == ()
    moved = estimate_trajectory(wrong, walked().tape, walked().mount)
    assert any("has an offset" in said for said in moved.warnings)
    assert np.abs(moved.yaw_rad - path().yaw_rad).max() < np.deg2rad(0.1)


def test_a_scale_about_the_vertical_leaves_no_trace():
    """A frame that is turned on the spot without a tilt: nothing tells 10 % of the yaw rate."""
    time_s = np.arange(3000) / 100
    rate = np.zeros((3000, 3))
    rate[:, 2] = np.clip(np.sin(2 * np.pi * time_s / 3), 0, 1) ** 2
    acc = np.tile([0.0, 0.0, 9.80665], (3000, 1))
    still = rate[:, 2] == 0
    for factor in (1.0, 1.1):
        moves = moves_between_rests(Readings(time_s, acc, factor * rate, still))
        assert len(moves.spans) >= 9
        assert np.abs(moves.misfit).max() < 1e-9
    assert not fit_halves(Readings(time_s, acc, 1.1 * rate, still)).seen


def test_a_frame_that_rolls_is_told():
    walk = walked()
    for seed, shaking in ((1, 0.02), (2, 0.3), (3, 2.0)):
        motion = rolling_motion(seed)
        recording = shaken(walk.followed(motion).recording, motion, shaking, seed)
        codes = {fault.code for fault in found_in(recording)}
        assert codes == {"rolls"}, (shaking, codes)


def test_a_foot_is_told_unless_the_settings_are_those_of_a_foot():
    walk = walked()
    mount = WalkerMount(walk.mount.rotation_imu_to_body, np.array([0.1, 0.0, 0.08]))
    true = WalkerMount(walk.walk.mount.rotation_imu_to_body, np.array([0.1, 0.0, 0.08]))
    foot = walk.followed(foot_motion(5, np.deg2rad(60)), true).recording
    found = found_in(foot, mount)
    assert "foot" in {fault.code for fault in found}
    assert any("no walking frame does" in fault.sentence for fault in found)
    known = found_in(foot, mount, settings=NavigationSettings.for_foot())
    assert "foot" not in {fault.code for fault in known}


def test_tilts_are_looked_at_too():
    walk = walked()
    tilts = walk.tilts.recording
    scaled = inject.scale(tilts, "frame", "gyr", 1.1)
    (fault,) = [f for f in find_tilt_faults(scaled, walk.tape) if f.code == "scale"]
    clean, wrong = (placed(r, walk.tape).mount for r in (tilts, scaled))
    turn = wrong.rotation_imu_to_body @ clean.rotation_imu_to_body.T
    moved = {
        "position of the IMU": np.linalg.norm(wrong.translation_body_m - clean.translation_body_m),
        "turn of the IMU": np.rad2deg(Rotation.from_matrix(turn).magnitude()),
    }
    assert {cost.name for cost in fault.costs} == set(moved)
    assert all(0.5 < cost.largest / moved[cost.name] < 2 for cost in fault.costs)
    other = WalkerGeometry(walk.tape.footprint_length_m, walk.tape.footprint_width_m)
    assert "poses" in {fault.code for fault in find_tilt_faults(tilts, other)}
    order = ("back", "right", "front", "left")
    assert "poses" in {f.code for f in find_tilt_faults(tilts, walk.tape, order=order)}


def test_tilts_stated_half_a_turn_off_cannot_be_told_apart_before_a_walk():
    """All directions turned by 180 deg: the same arcs. The walk then goes backward, and is told."""
    walk = walked()
    half = ("back", "front", "left", "right")
    assert find_tilt_faults(walk.tilts.recording, walk.tape, order=half) == ()
    mount = placed(walk.tilts.recording, walk.tape, order=half).mount
    assert "turned" in {fault.code for fault in found_in(walk.walk.recording, mount)}


@pytest.mark.parametrize("degrees", [15.0, 90.0, -120.0, 180.0])
def test_a_mount_is_told_by_the_angle_that_it_is_turned_by(degrees):
    """Its IMU lies elsewhere than it says, so that steps which turn seem to go another way."""
    wrong = turned(walked().walk.recording, [0.0, 0.0, degrees])
    (fault,) = [f for f in found_in(wrong) if f.code == "turned"]
    assert abs((fault.size - degrees + 180) % 360 - 180) < 1.0
    side = "left" if fault.size > 0 else "right"
    assert f"steps {abs(fault.size):.0f} deg to the {side}" in fault.sentence
    mended = estimate_trajectory(fault.repair(wrong), walked().tape, walked().mount)
    assert np.linalg.norm(mended.position_m - path().position_m, axis=1).max() < 0.1


def test_nothing_is_said_twice():
    faulty = CLEAR["leans"][1](walked().walk.recording)
    found = found_in(faulty)
    moved = estimate_trajectory(faulty, walked().tape, walked().mount)
    assert any("leans by" in said for said in moved.warnings)
    assert not any("leans by" in said for said in not_told(moved.warnings, found))


def test_what_no_path_can_be_found_from_has_the_sensors_faults_alone():
    """Two spikes and rates without a rest: the spikes are told, nothing that asks for a path."""
    recording = walked().walk.recording
    restless = inject.offset(recording, "frame", "gyr", [0, 0, 15.0])
    spiked = inject.spike(restless, "frame", "gyr", [2000, 3000], 1, 25.0)
    with pytest.raises(InputError, match="not still"):
        estimate_trajectory(spiked, None, walked().mount)
    (found,) = find_faults(spiked, None, walked().mount)
    assert (found.code, found.sensor, found.costs) == ("spike", "frame_gyr", ())
    assert np.flatnonzero(found.flags).tolist() == [2000, 3000]
    assert found_in(restless) == ()
    with pytest.raises(InputError, match="no sensor 'frame'"):
        found_in(Recording(recording.time_s, {"lever": recording.sensor("frame")}))


def test_a_part_in_another_unit_is_told_where_it_is_no_path():
    """Of both halves at once, and nothing else."""
    recording = walked().walk.recording
    part = np.zeros(len(recording), np.bool_)
    part[2000:2060] = True
    both = rescaled(rescaled(recording, "frame", "acc", part, 9.81), "frame", "gyr", part, 1 / 57.3)
    told = found_in(both)
    assert [(fault.code, fault.sensor) for fault in told] == [
        ("unit", "frame_acc"),
        ("unit", "frame_gyr"),
    ]
    assert all(np.count_nonzero(fault.flags ^ part) <= 4 for fault in told)


@pytest.mark.parametrize("kind", [*KINDS, *TILT_KINDS])
def test_every_kind_of_the_study_can_be_injected(kind):
    """What is given differs from what was without a fault, or refuses the fault by itself."""
    injection, _ = {**KINDS, **TILT_KINDS}[kind]
    walk = walked()
    if kind in ("clock", "left-handed", "beyond any range"):
        with pytest.raises(InputError):
            injection(walk, np.random.default_rng(7))
        return
    rng = np.random.default_rng(7)
    if kind in ("tilts, another order", "tilts, another footprint"):
        given = injection(walk, rng)
        assert (given.order != TILT_DIRECTIONS) == (kind == "tilts, another order")
        assert (given.tape != walk.tape) == (kind == "tilts, another footprint")
        return
    clean = (walk.tilts if kind in TILT_KINDS else walk.walk).recording
    drawn = (injection(walk, rng).recording for _ in range(20))  # a range may end beyond them all
    assert not all(same_readings(given, clean) for given in drawn)


def same_readings(first, second):
    return len(first) == len(second) and all(
        np.array_equal(a, b)
        for a, b in (
            (first.time_s, second.time_s),
            (first.sensor("frame").acc_mps2, second.sensor("frame").acc_mps2),
            (first.gyroscope("frame"), second.gyroscope("frame")),
        )
    )


def test_injected_lags_and_mirrors():
    """A late half holds the same readings, later; a mirror held twice is none."""
    recording = walked().walk.recording
    for lag in (0.25, -0.25):
        late = inject.late_half(recording, "frame", "gyr", lag)
        assert len(late) == len(recording) - 25
        first = int(np.searchsorted(recording.time_s, late.time_s[0]))
        assert (late.sensor("frame").acc_mps2[0] == recording.sensor("frame").acc_mps2[first]).all()
        shifted = recording.gyroscope("frame")[first - round(100 * lag) :][: len(late)]
        assert (late.gyroscope("frame") == shifted).all()
    once = inject.left_handed(recording, "frame", 1)
    twice = inject.left_handed(once, "frame", 1)
    assert (twice.gyroscope("frame") == recording.gyroscope("frame")).all()
    assert (once.gyroscope("frame")[:, 1] == -recording.gyroscope("frame")[:, 1]).all()
