"""Clocks that a file states twice: by its head, its stamps or ticks, and its packet counter."""

import json
import re

import dialects
import numpy as np
import pandas as pd
import pytest
from test_dialects import assert_same, made, quietly

from mobility_imu.errors import InputError
from mobility_imu.readers.recordings import understand

NO_HEAD = ""


def xsens(folder, head=NO_HEAD, *, count=1000, without=(), ticks=None, change=None):
    """Export of one sensor with SampleTimeFine, and its recording."""
    recording = made(count=count)
    path = dialects.xsens_mt(recording, folder, head=head, fine=True).with_name("MT-Frame.txt")
    lines = path.read_text().splitlines()
    top = next(k for k, line in enumerate(lines) if line.startswith("PacketCounter"))
    rows = [line.split("\t") for line in lines[top + 1 :]]
    table = pd.DataFrame(rows, columns=lines[top].split("\t"))
    if ticks is not None:
        table["SampleTimeFine"] = [f"{tick:.0f}" for tick in ticks(np.arange(count))]
    if change is not None:
        table = change(table)
    table = table.drop(columns=list(without))
    text = table.to_csv(index=False, sep="\t")
    path.write_text("\n".join([*lines[:top], text]))
    return path, recording


def lost(first, last):
    return lambda table: table.drop(index=range(first, last))


class TestXsens:
    HEAD = "// Update Rate: 100.0Hz\n"

    @pytest.mark.parametrize("without", [(), ("PacketCounter",)])
    def test_a_head_that_the_ticks_contradict_is_refused(self, tmp_path, without):
        path, _ = xsens(tmp_path, self.HEAD, ticks=lambda k: 200 * k, without=without)
        both = "head states 100 Hz, but its SampleTimeFine has 50 Hz; give .*--sampling-rate-hz"
        for given in ({}, {"sampling_rate_hz": 70}):
            with pytest.raises(InputError, match=both):
                quietly(path, **given)
        for rate in (50, 100):
            found = understand(path, sampling_rate_hz=rate)
            assert found.recording.sampling_rate_hz == pytest.approx(rate)
            assert not any("not used" in said for said in found.warnings)

    def test_the_head_of_one_of_several_files(self, tmp_path):
        prefix = dialects.xsens_mt(
            made(("frame", "left_wheel")), tmp_path, head="// Update Rate: 60.0Hz\n", fine=True
        )
        with pytest.raises(InputError, match="head states 60 Hz, but its SampleTimeFine has 100"):
            quietly(prefix)

    def test_a_head_that_is_rounded_is_believed(self, tmp_path):
        """Ticks of a tenth of a millisecond, and a crystal of the receiver."""
        path, _ = xsens(tmp_path, "// Update Rate: 120.0Hz\n", ticks=lambda k: k * 1e4 / 120.06)
        assert understand(path).recording.sampling_rate_hz == pytest.approx(120)

    @pytest.mark.parametrize("head", [NO_HEAD, HEAD])
    def test_ticks_show_what_was_lost_where_nothing_counts(self, tmp_path, head):
        path, recording = xsens(
            tmp_path, head, without=["PacketCounter"], change=lost(400, 699),
            ticks=lambda k: (2**32 - 20_000 + 100 * k) % 2**32,
        )  # fmt: skip
        with pytest.raises(InputError, match=r"gap of 3 s after 3\.99 s .*--fill-gaps-s"):
            quietly(path)
        found = quietly(path, fill_gaps_s=3)
        assert found.sampling_rate_hz == pytest.approx(100)
        assert len(found) == len(recording)

    @pytest.mark.parametrize("rate", [60, 120, 400])
    def test_ticks_are_rounded(self, tmp_path, rate):
        path, _ = xsens(
            tmp_path, without=["PacketCounter"], ticks=lambda k: np.rint(k * 1e4 / rate)
        )
        found = understand(path)
        assert found.rate_from == "SampleTimeFine"
        assert found.recording.sampling_rate_hz == pytest.approx(rate, rel=1e-4)
        assert np.ptp(np.diff(found.recording.time_s)) < 1e-9

    def test_ticks_that_are_not_even_are_the_times(self, tmp_path):
        steps = np.random.default_rng(2).integers(60, 140, 1000)
        path, _ = xsens(tmp_path, without=["PacketCounter"], ticks=lambda k: np.cumsum(steps))
        found = understand(path)
        assert any("its stamps are not even" in said for said in found.warnings)
        assert found.recording.time_s[-1] == pytest.approx(steps[1:].sum() * 1e-4, abs=0.02)

    @pytest.mark.parametrize(
        ("ticks", "says"),
        [
            (lambda k: 100 * (k % 500), r"line 503: SampleTimeFine runs back \(49900, then 0\)"),
            (lambda k: 100 * (k - (k > 700)), "line 704: SampleTimeFine repeats"),
        ],
    )
    @pytest.mark.parametrize("without", [(), ("PacketCounter",)])
    def test_ticks_that_run_back_are_refused_with_the_line(self, tmp_path, ticks, says, without):
        path, _ = xsens(tmp_path, ticks=ticks, without=without)
        with pytest.raises(InputError, match=says):
            quietly(path)

    @pytest.mark.parametrize("head", [NO_HEAD, HEAD])
    def test_a_counter_that_misses_what_the_ticks_show(self, tmp_path, head):
        path, _ = xsens(tmp_path, head, ticks=lambda k: 100 * k + 30_000 * (k >= 500))
        line = 502 + head.count("\n") + 1
        with pytest.raises(InputError, match=rf"line {line}: the packet counter goes on by 1, but "
                                             r"SampleTimeFine by 3\.01 s"):  # fmt: skip
            quietly(path)

    def test_a_gap_of_both_is_a_gap(self, tmp_path):
        path, _ = xsens(tmp_path, change=lost(400, 500))
        with pytest.raises(InputError, match=r"gap of 1\.01 s"):
            quietly(path)

    def test_rows_without_readings_are_placed_by_their_ticks(self, tmp_path):
        def emptied(table):
            table.loc[300:309, [c for c in table if c[3] == "_"]] = ""
            return table

        path, _ = xsens(tmp_path, without=["PacketCounter"], change=emptied)
        with pytest.raises(InputError, match=r"gap of 0\.11 s after 2\.99 s"):
            quietly(path)

    def test_a_tick_that_is_missing(self, tmp_path):
        def emptied(table):
            table.loc[300, "SampleTimeFine"] = ""
            return table

        path, _ = xsens(tmp_path, self.HEAD, without=["PacketCounter"], change=emptied)
        with pytest.raises(InputError, match="line 304: SampleTimeFine is nan"):
            quietly(path)
        path, recording = xsens(tmp_path, self.HEAD, change=emptied)
        assert_same(quietly(path, expected=("frame",)), recording)


def actigraph(folder, form, order="M/d/yyyy", *, count=1000, keep=None, hz=100):
    """ActiGraph's export with times in a form of strftime, where %f gives milliseconds."""
    recording = made(count=count)
    path = dialects.actigraph(recording, folder)
    head, rows = path.read_text().split("Timestamp,")
    head = head.replace("date format M/d/yyyy at 100", f"date format {order} at {hz}")
    times = pd.Timestamp("2020-01-31T23:59:58") + pd.to_timedelta(recording.time_s, unit="s")
    names, *rows = rows.rstrip().split("\n")
    stamps = [t.strftime(form.replace("%f", f"{t.microsecond // 1000:03d}")) for t in times]
    rows = [f"{s},{row.partition(',')[2]}" for s, row in zip(stamps, rows, strict=True)]
    kept = rows if keep is None else [row for k, row in enumerate(rows) if keep(k)]
    path.write_text(head + "\n".join([f"Timestamp,{names}", *kept, ""]))
    return path, recording


FORMS = [
    ("%m/%d/%Y %H:%M:%S.%f", "M/d/yyyy"),
    ("%d/%m/%Y %H:%M:%S.%f", "d/M/yyyy"),
    ("%d.%m.%Y %H:%M:%S.%f", "dd.MM.yyyy"),
    ("%Y-%m-%d %H:%M:%S.%f", "yyyy-MM-dd"),
    ("%Y-%m-%d %H:%M:%S.%f", "M/d/yyyy"),
    ("%m/%d/%y %I:%M:%S.%f %p", "M/d/yy"),
]


class TestActiGraph:
    @pytest.mark.parametrize(("form", "order"), FORMS)
    def test_stamps_in_the_heads_date_format(self, tmp_path, form, order):
        """Over midnight, and over the end of a month."""
        path, recording = actigraph(tmp_path, form, order)
        found = understand(path, expected=("frame",))
        assert found.warnings == ()
        assert_same(found.recording, recording)
        path, _ = actigraph(tmp_path, form, order, keep=lambda k: not 400 <= k < 700)
        with pytest.raises(InputError, match=r"gap of 3\.01 s after 3\.99 s"):
            quietly(path)
        assert len(quietly(path, fill_gaps_s=4)) == len(recording)

    @pytest.mark.parametrize("form", ["%M:%S.%f", "%d/%m/%Y %H:%M:%S.%f", "%m/%d/%Y %H:%M"])
    def test_stamps_that_are_not_understood_are_told(self, tmp_path, form):
        path, recording = actigraph(tmp_path, form)
        found = understand(path, expected=("frame",))
        assert any("column Timestamp are not in the head's date format, so that lost rows cannot "
                   "be seen" in said for said in found.warnings)  # fmt: skip
        assert_same(found.recording, recording)

    def test_whole_seconds_show_a_loss_without_its_place(self, tmp_path):
        path, recording = actigraph(tmp_path, "%m/%d/%Y %H:%M:%S")
        found = understand(path, expected=("frame",))
        assert any("in steps of 1 s, so that shorter losses cannot" in w for w in found.warnings)
        assert_same(found.recording, recording)
        path, _ = actigraph(tmp_path, "%m/%d/%Y %H:%M:%S", keep=lambda k: not 400 <= k < 700)
        with pytest.raises(InputError, match=r"row 4.. of the data: its Timestamp is .* rows were"):
            quietly(path)

    def test_a_later_stamp_that_is_none(self, tmp_path):
        path, _ = actigraph(tmp_path, "%m/%d/%Y %H:%M:%S.%f")
        path.write_text(path.read_text().replace("02/01/2020 00:00:00.000", "30/01/2020 00:00:00"))
        with pytest.raises(InputError, match="line 212, column Timestamp: '30/01/2020 00:00:00'"):
            quietly(path)

    def test_a_head_with_another_rate_than_the_stamps(self, tmp_path):
        path, recording = actigraph(tmp_path, "%Y-%m-%dT%H:%M:%S.%f", hz=30)
        found = understand(path, expected=("frame",))
        assert found.rate_from == "its clock"
        assert any("the 30 Hz of its head are not used: its column Timestamp has 100 Hz" in said
                   for said in found.warnings)  # fmt: skip
        assert_same(found.recording, recording)

    @pytest.mark.parametrize("part", ["Start Date 2/14/2019", "Start Time 08:58:00"])
    def test_a_start_of_thousands_of_digits(self, tmp_path, part):
        path = dialects.actigraph(made(), tmp_path)
        path.write_text(path.read_text().replace(part, part + "2" * 5000))
        with pytest.raises(InputError, match="of the head are no date and time; correct") as told:
            quietly(path)
        assert len(str(told.value)) < 400


class TestApdm:
    def test_a_head_with_another_rate_than_the_clock(self, tmp_path):
        path = dialects.apdm(made(), tmp_path)
        assert understand(path, expected=("frame",)).warnings == ()
        path.write_text(path.read_text().replace("Rate:,100,Hz", "Rate:,128,Hz"))
        found = understand(path)
        assert found.rate_from == "its clock"
        (said,) = [w for w in found.warnings if "128 Hz" in w]
        assert "the 128 Hz of its head are not used: its column Time has 100 Hz" in said

    def test_the_unit_of_the_clock_is_read(self, tmp_path):
        recording = made()
        path = dialects.apdm(recording, tmp_path)
        text = path.read_text()
        path.write_text(text.replace("s,m/s^2", "week,m/s^2", 1))
        with pytest.raises(InputError, match="time in 'week' is not known; expected s, ms"):
            quietly(path)
        head, rows = text.replace("s,m/s^2", "ms,m/s^2", 1).split("rad/s\n")
        rows = re.sub(r"^[\d.]+", lambda t: f"{1e3 * float(t[0]):.6g}", rows, flags=re.MULTILINE)
        path.write_text(f"{head}rad/s\n{rows}")
        assert_same(quietly(path, expected=("frame",)), recording)


class TestMovesense:
    @pytest.mark.parametrize("stamp", [float("nan"), float("inf"), -5, 1e300])
    def test_a_stamp_that_is_none(self, tmp_path, stamp):
        path = dialects.movesense(made(), tmp_path)
        log = json.loads(path.read_text())
        log["Meas"]["IMU9"][5]["Timestamp"] = stamp
        path.write_text(json.dumps(log))
        with pytest.raises(InputError, match=r"block 5: Timestamp is .*, expected ms; correct it"):
            quietly(path)

    def test_a_block_without_a_stamp(self, tmp_path):
        path = dialects.movesense(made(), tmp_path)
        log = json.loads(path.read_text())
        del log["Meas"]["IMU9"][7]["Timestamp"]
        path.write_text(json.dumps(log))
        with pytest.raises(InputError, match="block 7 without Timestamp in ms; correct it"):
            quietly(path)

    @pytest.mark.parametrize("name", ["ArrayAcc", "ArrayGyro"])
    def test_a_reading_that_is_none(self, tmp_path, name):
        path = dialects.movesense(made(), tmp_path)
        log = json.loads(path.read_text())
        log["Meas"]["IMU9"][4][name][3]["y"] = float("nan")
        path.write_text(json.dumps(log))
        with pytest.raises(InputError, match=f"block 4: a value of {name} is no finite number"):
            quietly(path)
