"""Walker: huge numbers are answered or refused, without a warning of numpy's own."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mobility_imu.errors import InputError
from mobility_imu.walker.arc_fit import ArcFit, arm_noise, fit_arc
from mobility_imu.walker.geometry import rotation_world_to_imu
from mobility_imu.walker.tilt_equations import (
    arm_angle,
    distance_to_edge,
    forward_axis,
    quaternion_from_rotation,
    tilt_angle,
    tilt_displacement,
    tilt_quaternion,
)

TURNED = Rotation.from_rotvec(np.outer(np.linspace(0, 1, 20), [0, 1, 0])).as_matrix()
PATH = TURNED @ [0.3, 0.0, 0.5]
STRETCHED = TURNED * np.where(np.arange(20) == 7, 1.01, 1.0)[:, None, None]
STILL = np.arange(20) % 19 == 0
CALLS = {
    "arm_angle": (arm_angle, [np.array([0.1, 0.2, 0.3])]),
    "arm_noise": (
        lambda *a: arm_noise(
            a[0], STILL, a[1], acc_noise_mps2_sqrthz=a[2], gyr_noise_radps_sqrthz=a[3]
        ),
        [TURNED, 0.01, 0.01, 0.001],
    ),
    "distance_to_edge": (distance_to_edge, [0.3, 0.4]),
    "fit_arc": (fit_arc, [PATH, TURNED]),
    "forward_axis": (forward_axis, [np.array([0.1, 0.2, 0.3])]),
    "quaternion_from_rotation": (quaternion_from_rotation, [np.eye(3)]),
    "rotation_world_to_imu": (rotation_world_to_imu, [np.array([1.0, 0.0, 0.0, 0.0])]),
    "tilt_angle": (tilt_angle, [np.array([0.9, 0.1, 0.1, 0.0])]),
    "tilt_displacement": (tilt_displacement, [PATH]),
    "tilt_quaternion": (tilt_quaternion, [np.array([1.0, 0.0, 0.0]), 0.3]),
}
NAMES = {
    "arm_angle": ["velocity_mps"],
    "arm_noise": [
        "rotation_imu_to_world", "interval_s", "acc_noise_mps2_sqrthz", "gyr_noise_radps_sqrthz"
    ],
    "distance_to_edge": ["displacement_m", "angle_rad"],
    "fit_arc": ["position_m", "rotation_imu_to_world"],
    "forward_axis": ["displacement_m"],
    "quaternion_from_rotation": ["rotation"],
    "rotation_world_to_imu": ["quaternion"],
    "tilt_angle": ["quaternion"],
    "tilt_displacement": ["position_m"],
    "tilt_quaternion": ["axis", "angle_rad"],
}  # fmt: skip
"""Arguments whose value is changed: a refusal names the one that is."""


@pytest.mark.parametrize("name", CALLS)
def test_numbers_of_any_size_are_answered_or_refused(name):
    function, good = CALLS[name]
    function(*good)
    for place, value in enumerate(good):
        ups = (-1.0) ** np.arange(np.size(value)).reshape(np.shape(value))
        for size in (1e160, 1e300, 1.7e308, 10**12, 1e-160, 1e-300):
            for other in (size * np.ones_like(ups), size * ups, size * np.asarray(value)):
                try:
                    answer = function(*good[:place], other[()], *good[place + 1 :])
                except InputError as refusal:
                    assert NAMES[name][place] in str(refusal)
                else:
                    numbers = vars(answer).values() if isinstance(answer, ArcFit) else [answer]
                    # Infinite where the true number is beyond all floats, but a number.
                    assert not any(np.isnan(number).any() for number in numbers)


@pytest.mark.parametrize("size", [1e-100, 1.0, 1e120, 1e300])
def test_angles_and_directions_do_not_depend_on_the_size(size):
    vector = np.array([0.1, 0.2, 0.3])
    assert arm_angle(size * vector) == pytest.approx(arm_angle(vector), rel=1e-12)
    quaternion = np.array([0.9, 0.1, -0.2, 0.3])
    assert tilt_angle(size * quaternion) == pytest.approx(tilt_angle(quaternion), rel=1e-12)
    if size >= 1:
        assert forward_axis(size * vector) == pytest.approx(forward_axis(vector), rel=1e-12)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: forward_axis([1.7e308, 1.7e308, 0]), "displacement_m: too large"),
        (lambda: fit_arc(1e10 * PATH, TURNED), "position_m: reaches"),
        (lambda: fit_arc(PATH, 3 * TURNED), r"rotation_imu_to_world\[0\]: not orthogonal"),
        (lambda: fit_arc(PATH, 0 * TURNED), r"rotation_imu_to_world\[0\]: not orthogonal"),
        (lambda: fit_arc(PATH, STRETCHED), r"rotation_imu_to_world\[7\]: not orthogonal"),
        (lambda: fit_arc(PATH, -TURNED), r"rotation_imu_to_world\[0\]: a mirror"),
        (
            lambda: CALLS["arm_noise"][0](TURNED, 1e10, 0.01, 0.001),
            r"interval_s = 1e\+10: expected .* s from sample to sample",
        ),
        (lambda: CALLS["arm_noise"][0](TURNED, 0.01, 1e10, 0.001), "acc_noise_mps2_sqrthz"),
        (lambda: CALLS["arm_noise"][0](TURNED, 0.01, 0.01, 1e10), "gyr_noise_radps_sqrthz"),
        (lambda: rotation_world_to_imu([1e300, 0, 0, 0]), "quaternion: of length inf"),
    ],
)
def test_what_is_too_large_is_named(call, words):
    with pytest.raises(InputError, match=words):
        call()
