"""Clocks that stop early, jump back or lose samples: refused, or told with place and length."""

import re

import dialects
import numpy as np
import pytest
from test_dialects import RATE_HZ, made, quietly

from mobility_imu.errors import InputError
from mobility_imu.readers.clocks import (
    check_fill,
    check_forward,
    ends_left_out,
    longest_silent_gap,
    losses,
    one_clock,
)
from mobility_imu.readers.recordings import understand
from mobility_imu.readers.streams import Stream
from mobility_imu.recording import Recording

G = 9.81


def stream(time_s, **given):
    acc = np.tile([0.0, 0.0, G], (len(time_s), 1))
    return Stream(time_s, acc, 0 * acc, **given)


def cut(file, first, last):
    head, *rows = file.read_text().rstrip().split("\n")
    file.write_text("\n".join([head, *rows[first:last], ""]))


# Ends


def test_a_sensor_that_stops_early_is_named_with_what_is_lost(tmp_path):
    dialects.ngimu(made(("frame", "left_wheel", "right_wheel"), count=2000), tmp_path)
    (right,) = tmp_path.glob("*right*/sensors.csv")
    cut(right, 0, 800)
    found = understand(tmp_path)
    assert found.recording.time_s[-1] == pytest.approx(7.98, abs=0.02)
    (said,) = [w for w in found.warnings if "left out" in w]
    assert "the last 12.00 s (right only until 7.99 s) of 19.99 s left out" in said.replace(
        "right_wheel", "right"
    )


def test_a_sensor_that_starts_late_is_named(tmp_path):
    path = dialects.lpms(made(("lever", "body"), count=1000), tmp_path)
    head, *rows = path.read_text().rstrip().split("\n")
    path.write_text("\n".join([head, *(r for r in rows if r[0] == "1"),
                               *[r for r in rows if r[0] == "2"][300:], ""]))  # fmt: skip
    (said,) = [w for w in understand(path).warnings if "left out" in w]
    assert "the first 3.00 s (2 only from 3.00 s) of 9.99 s left out" in said


def test_files_with_one_start_and_different_ends_are_told(tmp_path):
    recording = made(("lever", "body"), count=1000)
    parts = []
    for sensor, count in (("lever", 1000), ("body", 600)):
        one = Recording(
            recording.time_s, {sensor: recording.sensor(sensor)}, source=sensor
        ).to_frame()
        one.iloc[:count].to_csv(tmp_path / f"{sensor}.csv", index=False)
        parts.append(f"{sensor}={tmp_path}/{sensor}.csv")
    found = understand([*parts, "clock=same"])
    assert any("body only until 5.99 s" in w for w in found.warnings)


def test_ends_within_a_second_are_as_sensors_are():
    clocks = {"frame": np.array([0.0, 10.0]), "left_wheel": np.array([0.9, 9.2])}
    assert ends_left_out(clocks, "a") == []
    clocks["right_wheel"] = np.array([1.5, 7.0])
    (said,) = ends_left_out(clocks, "a")
    assert said == (
        "a: the first 1.50 s (right_wheel only from 1.50 s) and the last 3.00 s (right_wheel only "
        "until 7.00 s) of 10.00 s left out: not all have it"
    )


# Back


@pytest.mark.parametrize("back_s", [0.5, 60.0, 3600.0])
def test_a_clock_that_jumps_back_is_refused_with_the_place(tmp_path, back_s):
    path = dialects.ximu3(made(count=1000), tmp_path)
    head, *rows = path.read_text().rstrip().split("\n")
    cells = [row.split(",") for row in rows]
    for row in cells[700:]:
        row[0] = str(float(row[0]) - 1e6 * back_s)
    path.write_text("\n".join([head, *map(",".join, cells), ""]))
    with pytest.raises(InputError, match=r"frame: the clock jumps back by .* at sample 701"):
        quietly(path, expected=("frame",))


def test_blocks_of_a_log_that_go_back_are_refused(tmp_path):
    path = dialects.movesense(made(), tmp_path)
    path.write_text(path.read_text().replace('"Timestamp": 1600', '"Timestamp": 900'))
    with pytest.raises(InputError, match="the clock jumps back by"):
        quietly(path)


def test_single_rows_that_repeat_or_are_swapped_stay(tmp_path):
    path = dialects.ximu3(made(), tmp_path)
    head, *rows = path.read_text().rstrip().split("\n")
    rows[100:102] = rows[101], rows[100]
    rows.insert(200, rows[200])
    path.write_text("\n".join([head, *rows, ""]))
    found = understand(path)
    assert any("2 sample(s) left out whose stamps repeat or run backwards" in w
               for w in found.warnings)  # fmt: skip
    assert len(found.recording) == pytest.approx(400, abs=2)


def test_a_jump_back_comes_before_a_search_by_movement():
    time_s = np.arange(3000) / RATE_HZ
    streams = {
        "lever": stream(np.r_[time_s[:2000], time_s[2000:] - 15], clock="a"),
        "body": stream(time_s, clock="b"),
    }
    with pytest.raises(InputError, match=r"made, lever: the clock jumps back by 14.99 s"):
        one_clock(streams, "made")
    check_forward(time_s, "made")
    check_forward(time_s[:1], "made")


def test_a_long_search_by_movement_is_announced(caplog):
    time_s = np.arange(0, 700, 0.1)
    streams = {name: stream(time_s, clock=name) for name in ("lever", "body")}
    with caplog.at_level("INFO", logger="mobility_imu"):
        with pytest.raises(InputError, match="does not show clearly"):
            one_clock(streams, "made")
    assert "made: joining the clocks by their movement, 12 min long" in caplog.text


# Gaps


def gap_of(lost, rate_hz=100.0, count=1000):
    time_s = np.arange(count) / rate_hz
    return np.delete(time_s, np.arange(400, 400 + lost)) + 5.0


@pytest.mark.parametrize(("lost", "told"), [(0, 0), (1, 1), (8, 1)])
def test_short_gaps_are_told_though_stamps_are_not_counted(lost, told):
    time_s = gap_of(lost)
    rng = np.random.default_rng(1)
    time_s += rng.uniform(-0.001, 0.001, len(time_s))
    _, said, _ = one_clock({"frame": stream(time_s)}, "made")
    assert sum("gap(s) bridged" in sentence for sentence in said) == told
    assert losses(time_s).sum() == told


def test_a_late_stamp_is_no_loss():
    time_s = np.arange(1000) / 100
    time_s[500] += 0.007
    assert not losses(time_s).any()
    assert losses(time_s, counted=True).sum() == 1
    assert not losses(time_s[:2]).any()


def test_a_logger_without_a_usual_step_is_told_for_long_gaps_only():
    rng = np.random.default_rng(2)
    time_s = np.cumsum(rng.choice([0.005, 0.02, 0.04], 500))
    assert not losses(time_s).any()
    time_s[250:] += 0.2
    assert losses(time_s).sum() == 1


@pytest.mark.parametrize("rate_hz", [5.0, 8.0, 10.0, 50.0])
def test_slow_sensors_are_joined_and_their_gaps_refused(rate_hz):
    time_s = np.arange(200) / rate_hz
    late = time_s + 0.3 / rate_hz
    recording, _, _ = one_clock({"lever": stream(time_s), "body": stream(late)}, "made")
    assert recording.sampling_rate_hz == pytest.approx(rate_hz, rel=1e-3)
    lost = np.delete(late, np.arange(100, 106))
    with pytest.raises(InputError, match=r"made, body: gap of .* --fill-gaps-s"):
        one_clock({"lever": stream(time_s), "body": stream(lost)}, "made")


def test_a_gap_that_is_refused_is_longer_than_what_is_said():
    assert longest_silent_gap(0.01) == pytest.approx(0.1, abs=1e-5)
    assert longest_silent_gap(0.2) == pytest.approx(0.3, abs=1e-5)
    assert longest_silent_gap(1e7) < 2  # no sensor is that slow
    one_clock({"frame": stream(np.r_[0:1:0.01, 1.09:2:0.01] + 0.3)}, "made")


@pytest.mark.parametrize("write", [dialects.canonical, dialects.lpms])
@pytest.mark.parametrize(("begin", "lost"), [(137, 1), (138, 1), (501, 28)])
def test_a_gap_is_bridged_with_the_length_that_its_message_says(tmp_path, write, begin, lost):
    """Neither rounding of the message nor of the clock brings the same refusal again."""
    path = write(made(count=1000), tmp_path)
    head, *rows = path.read_text().rstrip().split("\n")
    late = 13 if write is dialects.lpms else 0
    path.write_text("\n".join([head, *rows[:begin], *rows[begin + lost + late :], ""]))
    with pytest.raises(InputError, match="to bridge it") as error:
        quietly(path)
    said = re.search(r"gap of (\S+) s", str(error.value))[1]
    found = quietly(path, fill_gaps_s=float(said))
    assert len(found) == pytest.approx(1000, abs=1)


@pytest.mark.filterwarnings("ignore:made")
@pytest.mark.parametrize("counted", [True, False])
@pytest.mark.parametrize("gap_s", [59.0, 60.04, 60.2, 600.0])
def test_a_gap_that_cannot_be_bridged_is_to_be_cut(counted, gap_s):
    """The advice is one that works: 60 s are filled at most."""
    time_s = np.arange(9000) / 100
    time_s[6000:] += gap_s - 0.01
    streams = {"frame": stream(time_s if counted else time_s + 1e-3 * (time_s % 0.02 > 0.01))}
    if counted:
        streams["frame"] = stream(time_s, counted=True)
    with pytest.raises(InputError, match=r"gap of .*cut the recording there$") as error:
        one_clock(streams, "made")
    told = "--fill-gaps-s" in str(error.value)
    assert told == (gap_s < 60.1)
    said = float(re.search(r"gap of (\S+) s", str(error.value))[1])
    if told:
        one_clock(streams, "made", fill_gaps_s=said)
    else:
        with pytest.raises(InputError, match="expected between 0 and 60 s"):
            check_fill(said)


@pytest.mark.filterwarnings("ignore:made")
def test_gaps_that_add_too_many_samples_are_to_be_cut():
    """Neither one gap of several that is too long, nor too many samples in all, can be filled."""
    for gaps_s in ([1.0, 600.0], [50.0, 50.0, 50.0]):
        time_s = np.arange(4000) / 100
        for k, gap_s in enumerate(gaps_s):
            time_s[1000 * (k + 1) :] += gap_s
        streams = {"frame": stream(time_s, counted=True)}
        for fill_gaps_s in (0.0, 2.0):
            with pytest.raises(InputError, match=r"gap of .*; cut the recording at its gaps$"):
                one_clock(streams, "made", fill_gaps_s=fill_gaps_s)


@pytest.mark.parametrize(
    ("spoil", "says"),
    [
        (lambda rows: [*rows[:500], *rows[600:]], r"gap of 1\.01 s after 4\.99 s"),
        (lambda rows: [*rows[:500], *rows[499:]], "appears twice"),
        (lambda rows: [*rows[:500], *rows[300:]], "runs backwards"),
        (lambda rows: [*rows[:500], rows[500].replace("T", " "), *rows[501:]], "line 512, .*time"),
        (lambda rows: [*rows[:500], rows[500].replace("-14T", "-34T"), *rows[501:]], "Timestamp: "),
    ],
    ids=["lost", "twice", "again", "no time", "no date"],
)
def test_stamps_of_rows_that_are_counted_show_what_was_changed(tmp_path, spoil, says):
    """ActiGraph's rows are counted at the rate of its head; a table can be cut or joined."""
    path = dialects.actigraph(made(count=1000), tmp_path)
    lines = path.read_text().rstrip().split("\n")
    path.write_text("\n".join([*lines[:11], *spoil(lines[11:]), ""]))
    with pytest.raises(InputError, match=says):
        quietly(path)
