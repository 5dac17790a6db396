"""What users hand over that is no array: refused by name at every door, the same in all devices."""

import os
import stat
from dataclasses import replace

import numpy as np
import pytest

from mobility_imu import scooter, walker, wheelchair
from mobility_imu.arguments import check_columns, expect, for_each, settings_or_default
from mobility_imu.errors import InputError
from mobility_imu.files import as_path, write_text
from mobility_imu.readers import read_recording, recording_files
from mobility_imu.recording import Imu, Recording
from mobility_imu.simulation import walker as walks
from mobility_imu.simulation import wheelchair as chairs

EYE = np.eye(3)
STILL = np.tile([0.0, 0.0, 9.81], (400, 1)) + np.random.default_rng(1).normal(0, 0.02, (400, 3))
RECORDING = Recording(
    np.arange(400) / 100,
    {
        name: Imu(STILL, np.zeros_like(STILL))
        for name in ("lever", "body", "frame", "left_wheel", "right_wheel")
    },
)
GEOMETRIES = {
    scooter: scooter.SUZUKI_ET4D,
    wheelchair: wheelchair.SAMPLE_CHAIR,
    walker: walker.WalkerGeometry(0.6, 0.52),
}
MOUNTS = {
    scooter: scooter.ScooterMount(EYE, EYE),
    wheelchair: wheelchair.WheelchairMount(EYE, EYE, EYE),
    walker: walker.WalkerMount(EYE, np.zeros(3)),
}
ESTIMATES = {
    scooter: scooter.estimate_ride,
    wheelchair: wheelchair.estimate_velocity,
    walker: walker.estimate_trajectory,
}
DEVICES = pytest.mark.parametrize("device", ESTIMATES, ids=lambda d: d.__name__.split(".")[-1])
STRANGE = (
    "abc", 3.0, float("nan"), True, [1, 2], {}, (), object(), EYE, np.array([]), dict,
    scooter.RideSettings, walker.GaitSettings(), RECORDING,
)  # fmt: skip


def estimate(device, **changed):
    given = {"recording": RECORDING, "geometry": GEOMETRIES[device], "mount": MOUNTS[device]}
    return ESTIMATES[device](**{**given, **changed})


@DEVICES
def test_one_recording_and_several_get_the_same(device):
    one, several = estimate(device), estimate(device, recording=[RECORDING, RECORDING])
    assert isinstance(several, list) and len(several) == 2
    for column, values in one.to_frame().items():
        for each in several:
            np.testing.assert_array_equal(values, each.to_frame()[column])
    assert estimate(device, recording=()) == []


@DEVICES
@pytest.mark.parametrize("name", ["geometry", "mount", "settings"])
@pytest.mark.parametrize("value", STRANGE, ids=lambda v: type(v).__name__)
def test_other_objects_are_named(device, name, value):
    """Empty ones too: they do not stand for the default."""
    with pytest.raises(InputError, match=rf"^{name}: got .*, expected \w+( or None)?$"):
        estimate(device, **{name: value})


@DEVICES
def test_what_belongs_to_another_device_is_named(device):
    for other in set(ESTIMATES) - {device}:
        with pytest.raises(InputError, match=r"^geometry: got \w+Geometry, expected"):
            estimate(device, geometry=GEOMETRIES[other])
        with pytest.raises(InputError, match=r"^mount: got \w+Mount, expected"):
            estimate(device, mount=MOUNTS[other])


@DEVICES
@pytest.mark.parametrize("value", [None, "ride.csv", 3, np.empty((0, 3)), {}, {"a": RECORDING}])
def test_what_is_no_recording_is_named(device, value):
    with pytest.raises(InputError, match=r"^recording: got \w+, expected Recording or a list"):
        estimate(device, recording=value)
    with pytest.raises(InputError, match=r"^recording 1: got \w+, expected Recording$"):
        estimate(device, recording=[RECORDING, value])


@DEVICES
@pytest.mark.parametrize("value", ["processes", 4, dict])
def test_what_is_no_executor_is_named(device, value):
    for recording in (RECORDING, [RECORDING]):
        with pytest.raises(InputError, match=r"^executor = .* with submit"):
            estimate(device, recording=recording, executor=value)


@pytest.mark.parametrize("value", [np.ones(3), "yes", 1, None])
def test_flags_are_true_or_false(value):
    with pytest.raises(InputError, match=r"smooth = .*: expected True or False"):
        estimate(walker, smooth=value)
    with pytest.raises(InputError, match=r"zero_rate = .*: expected True or False"):
        walker.NavigationSettings(zero_rate=value)
    with pytest.raises(InputError, match=r"smooth = .*: expected True or False"):
        walker.calibrate_mount(RECORDING, GEOMETRIES[walker], smooth=value)


@pytest.mark.parametrize("value", STRANGE, ids=lambda v: type(v).__name__)
def test_smaller_doors_name_other_objects(value):
    drive = estimate(wheelchair)
    doors = [
        lambda: estimate(walker, stillness=value),
        lambda: estimate(walker, closed_loop=value),
        lambda: walker.find_steps(value),
        lambda: wheelchair.identify_tasks(drive, value),
        lambda: walker.find_turns(value),
        lambda: walker.walking_summary(value),
        lambda: walker.six_minute_walk(value),
        lambda: walker.timed_up_and_go(value),
        lambda: walker.ten_metre_walk(value, start="static"),
        lambda: scooter.RideSettings(fusion=value),
        lambda: scooter.calibrate_mount(RECORDING, [(0.0, 0.0)] * 3, value),
        lambda: wheelchair.SlipWindows(np.array([1]), np.array([2]), value),
        lambda: MOUNTS[scooter].to_toml(geometry=value),
        lambda: MOUNTS[wheelchair].to_toml(geometry=value),
        lambda: MOUNTS[walker].to_toml(geometry=value),
        lambda: walks.simulate_walk(walks.CORRIDOR, seed=1, style=value),
        lambda: walks.simulate_walk(walks.CORRIDOR, seed=1, imperfections=value),
        lambda: walks.simulate_tilts(GEOMETRIES[walker], seed=1, style=value),
        lambda: chairs.simulate_court(
            chairs.COURT, GEOMETRIES[wheelchair], chairs.random_mounting(1), seed=1, pushing=value
        ),
    ]
    for door in doors:
        with pytest.raises(InputError) as refused:
            door()
        assert len(str(refused.value)) < 200 and "\n" not in str(refused.value)


@pytest.mark.parametrize(
    "poses", [3.0, "abc", [1, 2, 3], [(1, 2, 3)], [(1, "a")], [(0.0, float("nan"))], None]
)
def test_poses_are_pairs_of_numbers(poses):
    with pytest.raises(InputError, match="settings of the poses: "):
        scooter.calibrate_mount(RECORDING, poses, GEOMETRIES[scooter])


# Results that a script makes itself
def test_results_hold_series_of_one_length():
    ride, drive = estimate(scooter), estimate(wheelchair)
    tasks = wheelchair.identify_tasks(drive)
    pushes = wheelchair.Pushes(np.ones(2), np.ones(2), np.ones(2))
    for result in (ride, drive, tasks, pushes):
        names = list(result.to_frame())
        assert len(result.to_frame()) and names
        for field in vars(result):
            if isinstance(getattr(result, field), np.ndarray):
                # A drive whose ``valid`` is None is valid throughout.
                values = ("abc", 1.0, np.ones(3), np.ones((400, 1)))
                for value in (
                    values if field == "valid" and result in (drive, tasks) else (None, *values)
                ):
                    with pytest.raises(InputError, match=field.removesuffix("s")):
                        replace(result, **{field: value})
        if hasattr(result, "settings"):
            with pytest.raises(InputError, match="settings: got "):
                replace(result, settings=None)


def test_a_walk_holds_series_of_one_length():
    walk = estimate(walker)
    none = np.zeros(0)
    steps = walker.Steps(*[none] * 9, np.zeros((0, 2)), np.zeros(2), np.ones(2))
    for result in (walk, steps):
        for field in vars(result):
            if isinstance(getattr(result, field), np.ndarray):
                for value in (None, "abc", 1.0, np.ones(3), np.ones((7, 3)), np.ones((400, 1))):
                    with pytest.raises(InputError, match=f"{type(result).__name__}[.]"):
                        replace(result, **{field: value})
        with pytest.raises(InputError, match="settings: got "):
            replace(result, settings=None)
        with pytest.raises(InputError, match="stillness: got "):
            replace(result, stillness="none")


def test_columns_are_checked_by_name():
    class Made:
        def __init__(self, **fields):
            vars(self).update(fields)

    made = Made(a=[1, 2], b=[np.nan, 1], c=[0, 1])
    check_columns(made, "a", "b", flags=("c",))
    assert made.c.dtype == np.bool_ and made.b.dtype == float
    for wrong, name in (({"a": [[1]]}, "a"), ({"b": [1]}, "b"), ({"c": [0, 2]}, "c")):
        with pytest.raises(InputError, match=rf"Made.{name}: expected"):
            check_columns(Made(**{**vars(made), **wrong}), "a", "b", flags=("c",))


def test_settings_and_kinds():
    expect("geometry", None, dict, none=True)
    with pytest.raises(InputError, match="geometry: got NoneType, expected dict"):
        expect("geometry", None, dict)
    with pytest.raises(InputError, match="geometry: got the class dict itself, expected dict"):
        expect("geometry", dict, dict)
    assert settings_or_default("settings", None, walker.GaitSettings) == walker.GaitSettings()
    assert for_each(len, [RECORDING, RECORDING]) == [400, 400]


# Files
@pytest.mark.parametrize("path", [None, 3, 3.0, b"x", ["a", 1], EYE, object()])
def test_what_is_no_name_of_a_file_is_said(path):
    for read in (
        read_recording, recording_files, wheelchair.read_settings, as_path,
        scooter.ScooterGeometry.from_toml, scooter.ScooterMount.from_toml,
        wheelchair.WheelchairGeometry.from_toml, wheelchair.WheelchairMount.from_toml,
        walker.WalkerGeometry.from_toml, walker.WalkerMount.from_toml,
    ):  # fmt: skip
        with pytest.raises(InputError, match=r"path: got .* expected the name of a file"):
            read(path)


WRITERS = [
    *[pytest.param(MOUNTS[d].to_toml, id=f"{d.__name__} mount") for d in MOUNTS],
    *[
        pytest.param(GEOMETRIES[d].to_toml, id=f"{d.__name__} geometry")
        for d in (wheelchair, walker)
    ],
]


@pytest.mark.parametrize("to_toml", WRITERS)
def test_toml_is_written_whole_or_not_at_all(to_toml, tmp_path):
    target = tmp_path / "geometry.toml"
    text = to_toml(target)
    assert target.read_text() == text
    target.chmod(0o600)
    assert to_toml(str(target)) == text and stat.S_IMODE(target.stat().st_mode) == 0o600
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "link").symlink_to(tmp_path / "nowhere")
    for name in ("", "pipe", "no/a.toml", "link", "a\0b"):
        with pytest.raises(InputError):
            to_toml(tmp_path / name)
    for strange in (3, b"x", [target]):
        with pytest.raises(InputError, match="path: got "):
            to_toml(strange)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["geometry.toml", "link", "pipe"]


def test_an_unwritten_file_leaves_the_old_one(tmp_path, monkeypatch):
    target = tmp_path / "mount.toml"
    target.write_text("old")
    monkeypatch.setattr(os, "replace", lambda *a: (_ for _ in ()).throw(OSError(28, "full")))
    with pytest.raises(InputError, match=r"mount.toml: cannot be written \(full\)"):
        write_text(target, "new")
    assert target.read_text() == "old" and len(list(tmp_path.iterdir())) == 1


def test_a_comment_stays_one_line(tmp_path):
    mount = MOUNTS[walker]
    mount.to_toml(tmp_path / "m.toml", comment="by hand\n[walker]\x00\rx = 1")
    again = walker.WalkerMount.from_toml(tmp_path / "m.toml")
    np.testing.assert_array_equal(again.rotation_imu_to_body, mount.rotation_imu_to_body)


@pytest.mark.parametrize(
    ("kind", "field"),
    [
        (walker.NavigationSettings, "gyr_noise_radps_sqrthz"),
        (walker.NavigationSettings, "acc_bias_walk_mps2_sqrts"),
        (walker.NavigationSettings, "upright_rad"),
        (walker.ClosedLoop, "position_sd_m"),
        (walker.StillnessSettings, "mean_s"),
        (walker.StillnessSettings, "margin_s"),
        (wheelchair.PushSettings, "smoothing_s"),
    ],
)
def test_sizes_that_cannot_be_computed_with_are_refused(kind, field):
    for value in (1e300, 1e155, 1e9):
        with pytest.raises(InputError, match=rf"{kind.__name__}.{field} = .*: expected between"):
            kind(**{field: value})


def test_strides_fit_their_integers():
    with pytest.raises(InputError, match=r"moving_stride = 1000\d*\.\.\.: expected between 1 and"):
        walker.NavigationSettings(moving_stride=10**400)


def test_a_walking_test_goes_forward_and_knows_its_settings():
    with pytest.raises(InputError, match=r"stop_s = 1: expected after start_s, 2"):
        walker.WalkTest(2.0, 1.0, 3.0, 4)
    with pytest.raises(InputError, match="step_count = 'four'"):
        walker.WalkTest(0.0, 1.0, 3.0, "four")
    assert walker.WalkTest(0.0, 2.0, 3.0, 4).settings == walker.GaitSettings()


@pytest.mark.parametrize("camber_rad", [-0.1, 0.0, np.deg2rad(19), np.deg2rad(35)])
def test_cambers_at_the_limits_go_through_a_file(camber_rad, tmp_path):
    chair = wheelchair.WheelchairGeometry(camber_rad, 0.3, 0.3, 1.0)
    chair.to_toml(tmp_path / "g.toml")
    again = wheelchair.WheelchairGeometry.from_toml(tmp_path / "g.toml")
    assert again.camber_rad == pytest.approx(camber_rad, abs=1e-12)


def test_tilts_and_drawn_courts_can_be_kept_in_sets_and_printed():
    tilt = walker.Tilt("left", slice(0, 9), 4, 0.5)
    court = chairs.random_court(1)
    assert len({tilt, walker.Tilt("left", slice(0, 9), 4, 0.5)}) == 1 and len({court}) == 1
    assert "\n" not in repr(court) and len(repr(court)) < 300
