"""Scooter: huge and tiny numbers are answered or refused, without a warning of numpy's own."""

import importlib
import inspect
import pkgutil

import numpy as np
import pytest
from scooters import parked

from mobility_imu import scooter
from mobility_imu.errors import InputError
from mobility_imu.scooter import SUZUKI_ET4D, ScooterGeometry, ScooterMount, estimate_angles
from mobility_imu.scooter.calibration import ParkedPose, mount_from_poses
from mobility_imu.scooter.fusion import complementary_angles, fuse_angles, move_specific_force
from mobility_imu.scooter.fusion_noise import acceleration_noise
from mobility_imu.scooter.geometry import body_specific_force, lever_acceleration

READINGS = parked(40)
MODULES = sorted(
    info.name
    for info in pkgutil.iter_modules(scooter.__path__)
    if info.name not in ("angles", "geometry", "pulses")
)
MOUNT = ScooterMount(
    [[0.6, -0.8, 0], [0.8, 0.6, 0], [0, 0, 1]], [[1, 0, 0], [0, 0.6, -0.8], [0, 0.8, 0.6]]
)
POSES = [
    ParkedPose(lever[0], body[0], steering, throttle)
    for steering, throttle in ((0.8, 0.0), (0.8, 0.6), (0.0, 0.6), (-0.8, 0.0))
    for lever, _, body, _ in [parked(1, steering=steering, throttle=throttle)]
]
CALLS = {
    "ScooterGeometry": (ScooterGeometry, [0.3, 0.1]),
    "acceleration_noise": (acceleration_noise, READINGS[::2]),
    "body_specific_force": (body_specific_force, [0.1, 0.1]),
    "complementary_angles": (
        lambda *a: complementary_angles(*a[:5], SUZUKI_ET4D, time_constant_s=a[5]),
        [*READINGS, 100.0, 1.5],
    ),
    "estimate_angles": (lambda *a: estimate_angles(*a, SUZUKI_ET4D), READINGS[::2]),
    "estimate_angles, one IMU": (lambda a: estimate_angles(a, None, SUZUKI_ET4D), READINGS[:1]),
    "fuse_angles": (lambda *a: fuse_angles(*a, SUZUKI_ET4D), [*READINGS, 100.0]),
    "lever_acceleration": (
        lambda *a: lever_acceleration(*a, SUZUKI_ET4D),
        [READINGS[2], np.full(40, 0.1), 0.2],
    ),
    "mount.body": (MOUNT.body, READINGS[:1]),
    "mount.lever": (MOUNT.lever, READINGS[:1]),
    "mount_from_poses": (
        lambda a, b: mount_from_poses(POSES, SUZUKI_ET4D, pose_sd_rad=a, prior_sd_rad=b),
        [0.01, 0.05],
    ),
    "move_specific_force": (
        lambda *a: move_specific_force(*a[:4], smoothing_s=a[4]),
        [*READINGS[:2], [0.0, 0.1, 0.2], 100.0, 0.02],
    ),
}
ONE = (1e300, 1.7e308, -1e300, 1e160, 10**12, 2**70, 1e-160, 1e-300)


def large(shape):
    """Arrays of the shape that are large everywhere, here and there, or up and down."""
    number = np.arange(np.prod(shape)).reshape(shape)
    yield from (np.full(shape, size) for size in (1e160, 1e300, 1.7e308))
    yield np.where(number % 7 == 0, 1e300, 1.0)
    yield 1.7e308 * (-1.0) ** number


@pytest.mark.parametrize("name", CALLS)
def test_numbers_of_any_size_are_answered_or_refused(name):
    function, good = CALLS[name]
    function(*good)
    for place, value in enumerate(good):
        others = ONE if np.ndim(value) == 0 else large(np.shape(value))
        for other in others:
            try:
                function(*good[:place], other, *good[place + 1 :])
            except InputError as error:
                assert str(error)


@pytest.mark.parametrize("function", [fuse_angles, complementary_angles])
def test_a_rate_that_no_sensor_has_is_refused(function):
    """A filter over 20 ms of 1e12 samples each second would fill any memory."""
    with pytest.raises(InputError, match=r"sampling_rate_hz = 1e\+12: .*1e\+06 at most"):
        function(*READINGS, 1e12, SUZUKI_ET4D)


@pytest.mark.parametrize("smoothing_s", [1e-300, 1e-6, 1e5, 1e300])
def test_a_derivative_is_smoothed_over_samples_that_can_be(smoothing_s):
    with pytest.raises(InputError, match=r"smoothing_s = .*: expected 0\.001 to 1e\+06 samples"):
        move_specific_force(*READINGS[:2], [0, 0, 1], 100.0, smoothing_s=smoothing_s)


@pytest.mark.parametrize("name", ["pose_sd_rad", "prior_sd_rad"])
def test_a_standard_deviation_that_cannot_be_divided_by_is_refused(name):
    with pytest.raises(InputError, match=f"{name} = 1e-300: expected at least 1e-09 rad"):
        mount_from_poses(POSES, SUZUKI_ET4D, **{name: 1e-300})


def test_a_length_that_overflows_is_named_by_its_row():
    lever, body = READINGS[0].copy(), READINGS[2]
    lever[7] = 1e300
    with pytest.raises(InputError, match="row 7: too large to have a length"):
        acceleration_noise(lever, body)


@pytest.mark.parametrize("name", MODULES)
def test_a_module_lists_what_it_offers_and_no_more(name):
    """Functions and classes of its own without an underscore; constants and kept names beside."""
    module = importlib.import_module(f"mobility_imu.scooter.{name}")
    own = {
        what
        for what, value in vars(module).items()
        if not what.startswith("_")
        and (inspect.isclass(value) or callable(value))
        and getattr(value, "__module__", "") == module.__name__
    }
    assert own <= set(module.__all__)
    assert all(what in own or what.isupper() or what in KEPT for what in module.__all__)


KEPT = {"FusionSettings"}
"""Names that another module also offers: settings beside the function that takes them."""
