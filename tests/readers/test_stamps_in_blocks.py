"""Rows that share stamps in blocks, and files whose rows are counted: what is lost is told."""

import dialects
import numpy as np
import pandas as pd
import pytest
from test_dialects import COUNT, made, without_rate
from test_siblings_b import actigraph, xsens

from mobility_imu.errors import InputError
from mobility_imu.frames import STANDARD_GRAVITY_MPS2 as G
from mobility_imu.readers.recordings import understand

IN_BLOCK, RATE_HZ = 10, 100.0
UNSEEN = r"its rows are counted at {} Hz, without a clock or packet counter: lost samples cannot"
SHARED = "10 rows in succession share each time stamp, and differ in their readings"
AXES = "xyz"
MAP = """
[clock]
column = "t"
unit = "s"
[sensors.frame]
acc = ["gFx", "gFy", "gFz"]
acc_unit = "g"
gyr = ["wx", "wy", "wz"]
gyr_unit = "rad/s"
"""


def stamps(count=COUNT, rows=IN_BLOCK):
    """One stamp for so many rows."""
    return np.arange(count) // rows * rows / RATE_HZ


def readings(count=COUNT):
    draw = np.random.default_rng(1)
    return draw.normal([0.2, 0.1, G], 0.1, (count, 3)), draw.normal(0.0, 0.3, (count, 3))


def columns(time, time_s):
    acc, gyr = readings(len(time_s))
    table = {time: time_s}
    table |= {f"gF{a}": v / G for a, v in zip(AXES, acc.T, strict=True)}
    table |= {f"w{a}": v for a, v in zip(AXES, gyr.T, strict=True)}
    return pd.DataFrame(table)


def mapped(folder, time_s, keep=slice(None)):
    """A table and its map."""
    columns("t", time_s)[keep].to_csv(folder / "t.csv", index=False)
    (folder / "map.toml").write_text(MAP)
    return {"path": folder / "t.csv", "map_path": folder / "map.toml"}


def canonical(folder, time_s):
    path = dialects.canonical(made(), folder)
    table = pd.read_csv(path)
    table["time_s"] = time_s
    table.to_csv(path, index=False)
    return {"path": path}


def physics(folder, time_s):
    columns("time", time_s).to_csv(folder / "p.csv", index=False)
    return {"path": folder / "p.csv"}


def half(folder, name, time_s, values, unit):
    table = {"Time (s)": time_s}
    title = "Acceleration" if name == "Accelerometer" else "Gyroscope"
    table |= {f"{title} {a} ({unit})": v for a, v in zip(AXES, values.T, strict=True)}
    pd.DataFrame(table).to_csv(folder / f"{name}.csv", index=False)


def phone(folder, time_s, gyr_time_s=None):
    acc, gyr = readings(len(time_s))
    half(folder, "Accelerometer", time_s, acc, "m/s^2")
    half(folder, "Gyroscope", time_s if gyr_time_s is None else gyr_time_s, gyr, "rad/s")
    return {"path": folder}


@pytest.mark.parametrize("write", [mapped, canonical, physics, phone])
class TestBlocks:
    def test_the_rate_is_asked_for(self, tmp_path, write):
        with pytest.raises(InputError, match=f"{SHARED}; give their rate with --sampling-rate-hz"):
            understand(**write(tmp_path, stamps()))

    def test_with_the_rate_no_row_is_lost(self, tmp_path, write):
        found = understand(**write(tmp_path, stamps()), sampling_rate_hz=RATE_HZ)
        assert any(f"{SHARED}; they are counted at 100 Hz" in said for said in found.warnings)
        assert not any("left out" in said for said in found.warnings)
        assert len(found.recording) == COUNT and found.rate_from == "given"
        assert found.recording.sampling_rate_hz == pytest.approx(RATE_HZ)

    def test_another_rate_than_the_stamps_is_refused(self, tmp_path, write):
        with pytest.raises(InputError, match=r"50 Hz are given, but by the stamps .* 100 Hz; give"):
            understand(**write(tmp_path, stamps()), sampling_rate_hz=50)

    @pytest.mark.parametrize("times", [0, 2])
    def test_blocks_that_are_cut_or_a_row_off(self, tmp_path, write, times):
        """The first and the last block are cut; one has 9 rows, or 11."""
        whole = stamps(COUNT + 2 * IN_BLOCK)
        repeats = np.ones(len(whole), int)
        repeats[204] = times
        time_s = np.repeat(whole, repeats)[4 : COUNT + 4]
        with pytest.raises(InputError, match=SHARED):
            understand(**write(tmp_path, time_s))


def test_a_map_may_state_the_rate_instead(tmp_path):
    given = mapped(tmp_path, stamps())
    with pytest.raises(InputError, match="or by rate_hz in place of column in the map"):
        understand(**given)
    given["map_path"].write_text(MAP.replace('column = "t"\nunit = "s"', "rate_hz = 100"))
    found = understand(**given)
    assert len(found.recording) == COUNT
    assert any(said.startswith(f"{given['path']}: its rows are") for said in found.warnings)


def test_a_block_that_is_lost_is_a_gap(tmp_path):
    lost = stamps() != 2.0
    given = mapped(tmp_path, stamps(), lost)
    with pytest.raises(InputError, match=r"gap of 0\.11 s after 1\.99 s"):
        understand(**given, sampling_rate_hz=RATE_HZ)
    with pytest.warns(UserWarning, match="filled in with 10 interpolated samples"):
        found = understand(**given, sampling_rate_hz=RATE_HZ, fill_gaps_s=0.2)
    assert len(found.recording) == COUNT


def test_a_clock_that_is_set_back_is_not_mended(tmp_path):
    time_s = stamps() - np.where(np.arange(COUNT) < 200, 0.0, 1.0)
    with pytest.raises(InputError, match=r"clock jumps back by 0\.9 s"):
        understand(**mapped(tmp_path, time_s), sampling_rate_hz=RATE_HZ)


def test_blocks_in_the_rates_alone(tmp_path):
    """They are interpolated to the accelerations' stamps, so that no rate of rows helps."""
    given = phone(tmp_path, np.arange(COUNT) / RATE_HZ, stamps())
    for rate in (None, RATE_HZ):
        with pytest.raises(InputError, match=rf"Gyroscope\.csv: {SHARED}; export the recording"):
            understand(**given, sampling_rate_hz=rate)


def test_doubled_packets_and_single_repeats_are_no_blocks(tmp_path):
    time_s = np.arange(COUNT) / RATE_HZ
    table = columns("t", time_s)
    given = mapped(tmp_path, time_s)
    table.iloc[np.repeat(np.arange(COUNT), 2)].to_csv(given["path"], index=False)
    found = understand(**given)
    assert any(f"{COUNT} sample(s) left out whose stamps repeat" in w for w in found.warnings)
    assert found.recording.sampling_rate_hz == pytest.approx(RATE_HZ)
    # Stamps of whole hundredths of a sensor at 128 Hz: one row in four shares its stamp.
    columns("t", (np.arange(COUNT) / 128).round(2)).to_csv(given["path"], index=False)
    assert understand(**given).rate_from == "its clock"


def test_bursts_of_any_length_are_no_blocks(tmp_path):
    """A logger that writes when it can: no rate of the rows is right."""
    lengths = np.random.default_rng(2).choice([1, 2, 8, 20], 80)
    time_s = np.repeat(np.arange(80) / 10, lengths)[:COUNT]
    found = understand(**mapped(tmp_path, time_s))
    assert any("left out whose stamps repeat" in said for said in found.warnings)


def test_each_sensor_of_a_table_has_the_times_of_its_rows(tmp_path):
    path = dialects.canonical(made(("lever", "body")), tmp_path)
    table = pd.read_csv(path)
    table["time_s"] = stamps() + 5
    table.to_csv(path, index=False)
    found = understand(path, sampling_rate_hz=RATE_HZ)
    assert sum(SHARED in said for said in found.warnings) == 1
    assert found.recording.time_s[0] == 5 and len(found.recording) == COUNT


# Rows that are counted


def test_rows_without_clock_and_counter_are_told(tmp_path):
    for path in without_rate(tmp_path):
        if path.name == "MT-Frame.txt":
            continue
        said = understand(path, sampling_rate_hz=50).warnings
        assert [w for w in said if UNSEEN.format(50) in w and w.startswith(str(path))], path


@pytest.mark.parametrize("head", ["// Update Rate: 100.0Hz\n", ""])
def test_an_export_of_mt_manager_without_clock_and_counter(tmp_path, head):
    path, _ = xsens(tmp_path, head, without=["PacketCounter", "SampleTimeFine"])
    found = understand(path, sampling_rate_hz=100)
    assert [w for w in found.warnings if UNSEEN.format(100) in w]


@pytest.mark.parametrize("without", ["PacketCounter", "SampleTimeFine"])
def test_one_of_both_is_enough(tmp_path, without):
    path, _ = xsens(tmp_path, "// Update Rate: 100.0Hz\n", without=[without])
    assert not [w for w in understand(path).warnings if "cannot be seen" in w]


def test_actigraph_without_stamps(tmp_path):
    path, _ = actigraph(tmp_path, "%m/%d/%Y %H:%M:%S.%f")
    assert not [w for w in understand(path).warnings if "cannot be seen" in w]
    head, rows = path.read_text().split("Timestamp,")
    names, *rows = rows.rstrip().split("\n")
    path.write_text(head + "\n".join([names, *(row.partition(",")[2] for row in rows), ""]))
    assert [w for w in understand(path).warnings if UNSEEN.format(100) in w]
