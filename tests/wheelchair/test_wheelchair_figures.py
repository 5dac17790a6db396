"""Wheelchair: chronogram and frames."""

import numpy as np
import pytest
from chairs import CHAIRS

from mobility_imu.errors import InputError
from mobility_imu.plots.wheelchair import chronogram, draw_frames
from mobility_imu.wheelchair import (
    SAMPLE_CHAIR,
    Task,
)


def bars(figure):
    """Start and width (s) of every coloured bar of the chronogram, by its band's centre."""
    from matplotlib.collections import PolyCollection

    found = {}
    for collection in figure.axes[-1].collections:
        assert isinstance(collection, PolyCollection)
        if len(collection.get_facecolor()):  # the hatch has none
            for path in collection.get_paths():
                box = path.get_extents()
                found.setdefault(round((box.y0 + box.y1) / 2), []).append((box.x0, box.width))
    return found


@pytest.fixture
def no_figures_left_open():
    import matplotlib.pyplot as plt

    plt.switch_backend("agg")
    yield
    plt.close("all")


@pytest.mark.usefixtures("no_figures_left_open")
def test_chronogram_has_a_bar_for_every_run_in_the_band_of_its_task():
    codes = np.repeat([1, 2, 6, 2, 4], [100, 300, 50, 50, 10])
    time_s = 5 + np.arange(510) / 100
    figure = chronogram(time_s, codes)
    assert bars(figure) == {
        1: [pytest.approx((5, 1))],
        2: [pytest.approx((6, 3)), pytest.approx((9.5, 0.5))],
        6: [pytest.approx((9, 0.5))],
        4: [pytest.approx((10, 0.1))],
    }
    names = [label.get_text() for label in figure.axes[0].get_yticklabels()]
    assert names == [task.title for task in Task]


@pytest.mark.usefixtures("no_figures_left_open")
@pytest.mark.parametrize("minutes", [0.1, 2, 30])
def test_chronogram_keeps_the_velocities_peaks_at_any_length(minutes, tmp_path):
    count = int(minutes * 6000)
    time_s = np.arange(count) / 100
    velocity = np.sin(time_s)
    velocity[count // 3] = 9.0  # one sample
    codes = np.where(velocity > 0.5, Task.FORWARD, Task.STATIC)
    figure = chronogram(time_s, codes, velocity, np.full(count, -1.0))
    upper, lower, _ = (ax for ax in figure.axes if ax.get_ylabel() != "share of time")
    curve = max((line.get_ydata() for line in upper.lines), key=len)
    assert np.max(curve) == 9.0
    assert max((line.get_ydata() for line in lower.lines), key=len)[0] == pytest.approx(-57.3, 0.01)
    figure.savefig(tmp_path / "chronogram.png")


@pytest.mark.usefixtures("no_figures_left_open")
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([0, 1], [1, 7]), "sample 1 is 7, expected 1 to 6"),
        (([0, 1], [1, 0]), "sample 1 is 0"),
        (([0, 1], [1]), "expected 2 samples"),
        (([0, 0], [1, 1]), "appears twice"),
        (([0], [1]), "expected at least 2"),
        (([0, 1], [1, 1], [1.0]), "linear_velocity_mps: expected 2"),
    ],
)
def test_impossible_chronograms_are_refused(arguments, message):
    with pytest.raises(InputError, match=message):
        chronogram(*arguments)


@pytest.mark.usefixtures("no_figures_left_open")
@pytest.mark.parametrize("chair", [None, *CHAIRS], ids=["sample", "0deg", "3deg", "19deg", "24deg"])
def test_frames_are_drawn_to_scale_for_any_chair(chair, tmp_path):
    figure = draw_frames(chair)
    chair = chair or SAMPLE_CHAIR
    rear = figure.axes[0]
    contacts = [line.get_xdata()[0] for line in rear.lines if line.get_marker() == "^"]
    assert sorted(contacts) == pytest.approx([-chair.track_m / 2, chair.track_m / 2])
    figure.savefig(tmp_path / "frames.png")
