"""Drawings of the scooter's protocol: scales true to the angles, intervals with their ends."""

import numpy as np
import pytest

from mobility_imu.plots.scooter_protocol import draw_scales, plot_pose_check
from mobility_imu.scooter import SUZUKI_ET4D, check_poses
from mobility_imu.simulation.scooter import simulate_parked

plt = pytest.importorskip("matplotlib.pyplot")
POSES = np.deg2rad([[-30.0, 0.0], [0.0, 20.0], [30.0, 40.0]])


@pytest.fixture(autouse=True)
def closed():
    yield
    plt.close("all")


@pytest.mark.parametrize("steering_deg", [-40.0, 30.0])
def test_the_pointer_stands_at_the_angle(steering_deg):
    """Positive to the left of straight ahead, which is up."""
    figure = draw_scales(SUZUKI_ET4D, steering_rad=np.deg2rad(steering_deg), throttle_rad=0.3)
    shaft = figure.axes[0]
    (pointer,) = (line for line in shaft.lines if line.get_gid() == "pointer")
    x, y = np.diff(pointer.get_xydata(), axis=0)[0]
    assert np.rad2deg(np.arctan2(-x, y)) == pytest.approx(steering_deg, abs=0.1)


def test_every_judged_pose_is_plotted_with_its_interval():
    parked = simulate_parked(POSES.tolist(), pitch_rad=0.0, bank_rad=0.0, seed=1)
    check = check_poses(parked, POSES.tolist(), SUZUKI_ET4D)
    figure = plot_pose_check(check)
    for control, ax in enumerate(figure.axes):
        counts = [int(text.get_text().split("(")[1][:-1]) for text in ax.get_legend().get_texts()]
        assert sum(counts) == len(POSES)
        found = np.sort(
            np.concatenate([line.get_ydata() for line in ax.lines if line.get_marker() in "oX"])
        )
        assert np.allclose(found, np.sort(np.rad2deg(check.difference_rad[:, control])))
