"""The three studies of injected faults in one table, and its drawing."""

import pytest

from mobility_imu.errors import InputError
from mobility_imu.plots.faults import draw_percentages
from mobility_imu.reproduction import faults


@pytest.fixture
def recorded(monkeypatch):
    """Two kinds: ten of a lag, of which one is refused; five harmless ones."""
    lag = {
        "kind": "lag", "cases": 10, "refused": 1, "matter": 7, "told": 5, "right": 4, "priced": 3,
        "within_two": 2, "unpriced": 2, "largest_missed": 3.0,
    }  # fmt: skip
    none = dict.fromkeys(lag, 0) | {"kind": "offset", "cases": 5}
    records = {
        "faults_scooter": {"summary": [lag, none]},
        "faults_wheelchair": {"kinds": [lag, none]},
        "faults_walker": {"kinds": [lag, none]},
    }
    monkeypatch.setattr(faults, "numbers", records.__getitem__)


@pytest.mark.usefixtures("recorded")
@pytest.mark.parametrize("device", faults.DEVICES)
def test_what_is_refused_matters_and_is_told_rightly(device):
    counts = faults.fault_counts(device)
    assert counts.loc["lag"].to_dict() == {
        "cases": 10, "matter": 8, "told": 6, "right": 5, "priced": 3, "within_two": 2,
        "unpriced": 2,
    }  # fmt: skip
    assert faults.percentages(counts).to_dict() == pytest.approx(
        {"told": 75.0, "right": 62.5, "within_two": 200 / 3}
    )
    with pytest.raises(InputError, match="device"):
        faults.fault_counts("bicycle")


@pytest.mark.usefixtures("recorded")
def test_kinds_that_never_matter_are_not_drawn():
    figure = draw_percentages({"scooter": faults.fault_counts("scooter")})
    (axes,) = figure.axes
    assert [text.get_text() for text in axes.get_yticklabels()] == ["lag (8)"]
    assert axes.patches[-1].get_width() == pytest.approx(75.0)
