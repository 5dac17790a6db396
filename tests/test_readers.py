"""Readers and recordings: every format gives the same samples, every fault its own message."""

import gzip

import numpy as np
import pandas as pd
import pytest

from mobility_imu.errors import InputError
from mobility_imu.readers import read_recording
from mobility_imu.readers.velocities import read_velocities
from mobility_imu.recording import Imu, Recording

SENSORS = ("frame", "left_wheel", "right_wheel")
# A number written with repr and read back is the same; through deg it is within two roundings.
TWO_ROUNDINGS = 1e-15


def made(count=12, rate=100.0, sensors=SENSORS, seed=0):
    """A recording of made-up numbers, gravity on z."""
    rng = np.random.default_rng(seed)
    return Recording(
        np.arange(count) / rate,
        {
            name: Imu(rng.normal([0, 0, 9.81], 0.1, (count, 3)), rng.normal(0.0, 1.0, (count, 3)))
            for name in sensors
        },
    )


def assert_same(one, other):
    pd.testing.assert_frame_equal(
        one.to_frame()[other.to_frame().columns], other.to_frame(), check_exact=True
    )


def write(path, content):
    if isinstance(content, pd.DataFrame):
        content = content.to_csv(index=False)
    path.write_text(content, encoding="utf-8", newline="")
    return path


@pytest.fixture
def table():
    return made().to_frame()


# The canonical CSV


@pytest.mark.parametrize("name", ["trial.csv", "trial.csv.gz"])
def test_canonical_csv_comes_back_bit_for_bit(tmp_path, name):
    recording = made()
    recording.to_frame().to_csv(tmp_path / name, index=False)
    found = read_recording(tmp_path / name)
    assert_same(found, recording)
    assert found.sampling_rate_hz == 100.0
    assert list(found.sensors) == list(SENSORS)


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text.replace("\n", "\r\n"),
        lambda text: "\ufeff" + text,
        lambda text: text.rstrip("\n"),
        lambda text: text + "\n\n",
        lambda text: text.replace(",", ", "),
    ],
    ids=["CRLF", "byte order mark", "no last newline", "blank last lines", "blanks"],
)
def test_how_editors_save_it_does_not_matter(tmp_path, table, change):
    path = write(tmp_path / "trial.csv", change(table.to_csv(index=False)))
    assert_same(read_recording(path), made())


def test_order_of_the_columns_does_not_matter_and_a_sensor_may_lack_its_gyroscope(tmp_path):
    table = made(sensors=("lever", "body")).to_frame()
    table = table[[name for name in table if not name.startswith("body_gyr")]]
    path = write(tmp_path / "ride.csv", table[table.columns[::-1]])
    found = read_recording(path)
    assert found.sensor("body").gyr_radps is None
    expected = table[[f"body_acc_{axis}_mps2" for axis in "xyz"]].to_numpy()
    assert np.array_equal(found.sensor("body").acc_mps2, expected)
    with pytest.raises(InputError, match="'body' has no gyroscope"):
        found.sensor("body", gyroscope=True)


def at(table, row, column, value):
    """The table with one cell changed."""
    table = table.astype(object)
    table.loc[row, column] = value
    return table


def scaled(quantity, factor):
    def change(table):
        table = table.copy()
        columns = [name for name in table if f"frame_{quantity}" in name]
        table[columns] = factor * table[columns]
        return table

    return change


def without_gravity(table):
    table = table.copy()
    table["frame_acc_z_mps2"] -= 9.81
    return table


FAULTS = {
    "a letter in a cell": (
        lambda t: at(t, 3, "frame_gyr_y_radps", "0.1x"),
        "line 5, column frame_gyr_y_radps: '0.1x' is not a number",
    ),
    "decimal commas between commas": (
        lambda t: t.to_csv(index=False).replace("0.01,", "0,01,"),
        "line 3 has 20 of 19 cells; decimal commas",
    ),
    "a cell too many": (
        lambda t: t.to_csv(index=False).replace("\n0.03,", "\n0.03,7,"),
        "line 5 has 20 of 19 cells",
    ),
    "decimal commas throughout": (
        lambda t: t.to_csv(index=False).replace(".", ","),
        r"line 2 has \d+ of 19 cells; decimal commas",
    ),
    "last line cut": (
        lambda t: t.to_csv(index=False)[:-90],
        r"line 13 has \d+ of 19 cells; was the file cut short",
    ),
    "an empty cell": (
        lambda t: at(t, 4, "left_wheel_acc_x_mps2", None),
        r"line 6, column left_wheel_acc_x_mps2: expected a number.*1 such row.*--fill-gaps-s",
    ),
    "nan": (
        lambda t: at(t, 4, "left_wheel_acc_x_mps2", "nan"),
        "line 6, column left_wheel_acc_x_mps2: expected a number",
    ),
    "infinity": (
        lambda t: at(t, 4, "frame_acc_x_mps2", "inf"),
        "line 6, column frame_acc_x_mps2: expected a number",
    ),
    "a time missing": (
        lambda t: at(t, 4, "time_s", None),
        "line 6, column time_s: expected a number",
    ),
    "no time column": (lambda t: t.drop(columns="time_s"), "unknown format.*time_s"),
    "an axis missing": (
        lambda t: t.drop(columns="frame_acc_z_mps2"),
        "no column frame_acc_z_mps2",
    ),
    "no accelerometer": (
        lambda t: t[[name for name in t if not name.startswith("frame_acc")]],
        "no column frame_acc_x_mps2, frame_acc_y_mps2, frame_acc_z_mps2",
    ),
    "a misspelt column": (
        lambda t: t.rename(columns={"frame_gyr_z_radps": "frame_gyr_z_rads"}),
        "column frame_gyr_z_rads is not known",
    ),
    "another unit": (
        lambda t: t.rename(columns={"frame_acc_x_mps2": "frame_acc_x_g"}),
        "column frame_acc_x_g is not known",
    ),
    "a column twice": (
        lambda t: pd.concat([t, t["frame_acc_x_mps2"]], axis=1),
        "column frame_acc_x_mps2 appears twice",
    ),
    "no sensor": (lambda t: t[["time_s"]], "no sensor"),
    "one row": (lambda t: t[:1], r"1 sample\(s\), expected at least 2"),
    "header only": (lambda t: t[:0], "a header, but no rows"),
    "a time twice": (
        lambda t: at(t, 4, "time_s", 0.03),
        r"time_s: 0\.03 s appears twice \(samples 3 and 4\)",
    ),
    "unsorted": (
        lambda t: pd.concat([t[6:], t[:6]]),
        r"backwards at sample 6 \(0\.11 s, then 0 s\)",
    ),
    "a gap": (
        lambda t: t.drop(index=[5, 6]),
        r"gap of 0\.03 s after 0\.04 s \(usual step 0\.01 s; 1 gap\(s\) in all\)",
    ),
    "acceleration in g": (scaled("acc", 1 / 9.81), "frame_acc has a median length.* looks like g$"),
    "acceleration in milli-g": (scaled("acc", 1000 / 9.81), "milli-g"),
    "acceleration in mm/s²": (scaled("acc", 1000), "mm/s²"),
    "gravity taken out": (without_gravity, "was gravity taken out"),
    "rates in deg/s": (scaled("gyr", 57.3), "frame_gyr reaches .*looks like deg/s"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_each_fault_is_refused_with_its_own_message_and_the_files_name(tmp_path, table, fault):
    change, message = FAULTS[fault]
    path = write(tmp_path / "trial.csv", change(table))
    with pytest.raises(InputError, match=message) as error:
        read_recording(path)
    assert str(path) in str(error.value)
    assert "\n" not in str(error.value)


def test_missing_empty_and_foreign_files(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        read_recording(tmp_path / "trial.csv")
    for content in ("", " \n\n"):
        with pytest.raises(InputError, match="the file is empty"):
            read_recording(write(tmp_path / "empty.csv", content))
    with pytest.raises(InputError, match=r"unknown format.*'a,b'"):
        read_recording(write(tmp_path / "other.csv", "a,b\n1,2\n"))
    picture = tmp_path / "picture.csv"
    for content, says in (
        (b"\x89PNG\r\n\x1a\n\xff\xd8", "is a picture"),
        (b"\x00PNG\r\n\x1a\n\xff\xd8", "not a text file"),
    ):
        picture.write_bytes(content)
        with pytest.raises(InputError, match=says):
            read_recording(picture)


def test_packed_file_that_is_cut_or_not_packed(tmp_path, table):
    packed = gzip.compress(table.to_csv(index=False).encode())
    for k, content in enumerate((packed[:-20], packed[:40], b"time_s,", b"")):
        path = tmp_path / f"{k}.csv.gz"
        path.write_bytes(content)
        with pytest.raises(InputError, match=r"is it complete|empty|no rows"):
            read_recording(path)
    broken = bytearray(packed)
    broken[len(packed) // 2] ^= 0xFF
    path = tmp_path / "broken.csv.gz"
    path.write_bytes(broken)
    with pytest.raises(InputError, match="is it complete"):
        read_recording(path)


def test_gaps_up_to_a_length_are_filled_on_the_line_between_their_ends(tmp_path):
    count = 60
    time_s = np.arange(count) / 100
    acc = np.column_stack([0.5 * time_s, -time_s, np.full(count, 9.81)])
    whole = Recording(time_s, {"frame": Imu(acc, 0.2 * acc)})
    path = write(tmp_path / "trial.csv", whole.to_frame().drop(index=[10, 30, 31, 32]))
    with pytest.warns(UserWarning, match=r"2 gap\(s\) filled in with 4 .* 0\.04 s after 0\.29 s"):
        filled = read_recording(path, fill_gaps_s=0.05)
    assert filled.time_s == pytest.approx(time_s, abs=1e-12)
    assert filled.sensor("frame").acc_mps2 == pytest.approx(acc, abs=1e-12)
    assert filled.sensor("frame").gyr_radps == pytest.approx(0.2 * acc, abs=1e-12)
    with (
        pytest.raises(InputError, match=r"gap of 0\.04 s after 0\.29 s"),
        pytest.warns(UserWarning, match=r"1 gap\(s\) filled in"),
    ):
        read_recording(path, fill_gaps_s=0.03)


# WheelMove-ID's CSV


def wheelmove(recording, separator=";", decimal="."):
    names = {"frame": "Chassis", "left_wheel": "RoueGauche", "right_wheel": "RoueDroite"}
    columns = {}
    for sensor, theirs in names.items():
        imu = recording.sensor(sensor)
        for kind, values in (("Acc", imu.acc_mps2), ("Gyr", imu.gyr_radps)):
            for axis, column in zip("XYZ", values.T, strict=True):
                columns[f"{theirs}_{kind}_{axis}"] = column
    return pd.DataFrame(columns).to_csv(index=False, sep=separator, decimal=decimal)


@pytest.mark.parametrize(("separator", "decimal"), [(";", "."), (";", ","), (",", ".")])
@pytest.mark.parametrize(
    "change",
    [lambda t: t, str.lower, lambda t: t.replace("\n", ";\n")],
    ids=["as it is", "lower case", "separator at the line's end"],
)
def test_wheelmove_csv(tmp_path, separator, decimal, change):
    text = change(wheelmove(made(), separator, decimal)).replace(";\n", f"{separator}\n")
    path = write(tmp_path / "trial.csv", text)
    with pytest.warns(UserWarning, match=r"counted at 100 Hz.*lost samples cannot be seen"):
        assert_same(read_recording(path, sampling_rate_hz=100), made())


def test_wheelmove_csv_has_no_clock_so_the_rate_is_the_readers(tmp_path):
    path = write(tmp_path / "trial.csv", wheelmove(made()))
    with pytest.warns(UserWarning, match="counted at 128 Hz"):
        assert read_recording(path, sampling_rate_hz=128).sampling_rate_hz == 128
    with pytest.raises(InputError, match=r"states no sampling rate.*give it with --sampling-rate"):
        read_recording(path)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda t: t.replace("RoueDroite_Gyr_Z", "RoueDroite_Gyr_W"), "no column RoueDroite_Gyr_Z"),
        (lambda t: t.replace("Chassis_Acc_Y", "Chassis_Acc_X"), "chassis_acc_x appears twice"),
        (lambda t: t[:-25], r"line 13 has \d+ of 18 cells; was the file cut short"),
        (lambda t: t.split("\n")[0] + "\n", "no rows"),
        (lambda t: t.replace("\n0", "\nx", 1).replace("\n-0", "\nx", 1), "is not a number"),
    ],
)
def test_bad_wheelmove_csv(tmp_path, change, message):
    path = write(tmp_path / "trial.csv", change(wheelmove(made())))
    with pytest.raises(InputError, match=message) as error:
        read_recording(path, sampling_rate_hz=100)
    assert str(path) in str(error.value)


# Xsens MT Manager's exports

XSENS_NAMES = {"frame": "Frame", "left_wheel": "LeftWheel", "right_wheel": "RightWheel"}


def xsens(recording, sensor, first, comments="// General information:\n//  Update Rate: 100.0Hz\n"):
    imu = recording.sensor(sensor)
    table = pd.DataFrame({"PacketCounter": (first + np.arange(len(recording))) % 65536})
    for kind, values in (("Acc", imu.acc_mps2), ("Gyr", imu.gyr_radps)):
        for axis, column in zip("XYZ", values.T, strict=True):
            table[f"{kind}_{axis}"] = column
    return comments, table


def write_xsens(folder, parts, prefix="Trial"):
    for sensor, (comments, table) in parts.items():
        text = comments + table.to_csv(index=False, sep="\t")
        write(folder / f"{prefix}-{XSENS_NAMES[sensor]}.txt", text)
    return folder / prefix


@pytest.mark.parametrize("first", [0, 17212, 65530], ids=["0", "middle", "wraps at 65535"])
def test_xsens_exports_join_on_the_packet_counter(tmp_path, first):
    recording = made()
    prefix = write_xsens(tmp_path, {s: xsens(recording, s, first) for s in SENSORS})
    assert_same(read_recording(prefix), recording)


def test_xsens_exports_that_start_and_end_apart_keep_what_all_have(tmp_path):
    recording = made(count=30)
    parts = {s: xsens(recording, s, 65525) for s in SENSORS}
    keep = {"frame": slice(0, 28), "left_wheel": slice(4, 30), "right_wheel": slice(2, 29)}
    parts = {s: (comments, table[keep[s]]) for s, (comments, table) in parts.items()}
    found = read_recording(write_xsens(tmp_path, parts))
    assert len(found) == 24
    assert found.time_s[0] == 0
    for sensor in SENSORS:
        expected = recording.sensor(sensor).acc_mps2[4:28]
        assert np.array_equal(found.sensor(sensor).acc_mps2, expected)


@pytest.mark.parametrize("late", SENSORS)
def test_xsens_sensor_that_starts_after_the_counter_went_over_is_still_joined(tmp_path, late):
    recording = made(count=30)
    parts = {s: xsens(recording, s, 65530) for s in SENSORS}
    comments, table = parts[late]
    parts[late] = (comments, table[10:])
    found = read_recording(write_xsens(tmp_path, parts))
    assert len(found) == 20
    for sensor in SENSORS:
        expected = recording.sensor(sensor).gyr_radps[10:]
        assert np.array_equal(found.sensor(sensor).gyr_radps, expected)


def test_xsens_packet_missing_in_one_sensor_is_a_gap_in_all(tmp_path):
    recording = made(count=30)
    parts = {s: xsens(recording, s, 100) for s in SENSORS}
    comments, table = parts["right_wheel"]
    parts["right_wheel"] = (comments, table.drop(index=12))
    prefix = write_xsens(tmp_path, parts)
    with pytest.raises(InputError, match=r"gap of 0\.02 s after 0\.11 s"):
        read_recording(prefix)
    with pytest.warns(UserWarning, match=r"1 gap\(s\) filled in with 1 interpolated"):
        filled = read_recording(prefix, fill_gaps_s=0.05)
    assert len(filled) == 30
    acc = recording.sensor("frame").acc_mps2
    between = (acc[11] + acc[13]) / 2
    assert filled.sensor("frame").acc_mps2[12] == pytest.approx(between, abs=1e-12)


def test_xsens_rate_comes_from_the_file_or_from_the_caller(tmp_path):
    recording = made()
    for comments, rate in (
        ("// Update Rate: 60.0Hz\n", 60),
        ("// Update Rate: 60,0Hz\n", 60),
        ("// Sample rate: 50.0Hz\n", 50),
    ):
        prefix = write_xsens(tmp_path, {s: xsens(recording, s, 0, comments) for s in SENSORS})
        assert read_recording(prefix).sampling_rate_hz == pytest.approx(rate)
    comments = "// General information:\n"
    prefix = write_xsens(tmp_path, {s: xsens(recording, s, 0, comments) for s in SENSORS})
    with pytest.raises(InputError, match=r"states no sampling rate.*give it with --sampling-rate"):
        read_recording(prefix)
    assert read_recording(prefix, sampling_rate_hz=100).sampling_rate_hz == pytest.approx(100)


def test_xsens_files_may_be_named_one_by_one(tmp_path):
    recording = made()
    write_xsens(tmp_path, {s: xsens(recording, s, 5) for s in SENSORS})
    named = ",".join(f"{s}={tmp_path}/Trial-{XSENS_NAMES[s]}.txt" for s in SENSORS)
    with pytest.warns(UserWarning, match="joined on the packet counter"):
        found = read_recording(named)
    assert_same(found, recording)


def shifted(parts, sensor, change):
    comments, table = parts[sensor]
    return parts | {sensor: (comments, change(table.copy()))}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            lambda p: shifted(p, "frame", lambda t: t.assign(PacketCounter=t.PacketCounter + 5000)),
            r"share no packet counters \(frame 5100-5111",
        ),
        (
            lambda p: shifted(p, "frame", lambda t: t.iloc[[0, 1, 1, 2, 3]]),
            "Trial-Frame.txt: the packet counter appears twice at row",
        ),
        (
            lambda p: shifted(p, "frame", lambda t: t.iloc[[0, 3, 2, 4, 5]]),
            "packet counter runs backwards at row",
        ),
        (
            lambda p: p | {"frame": ("// Update Rate: 60.0Hz\n", p["frame"][1])},
            r"different rates \(\[60.0, 100.0\] Hz\)",
        ),
        (
            lambda p: shifted(p, "left_wheel", lambda t: t.drop(columns="Gyr_X")),
            "Trial-LeftWheel.txt: no column Gyr_X",
        ),
        (
            lambda p: shifted(p, "left_wheel", lambda t: at(t, 2, "Acc_Y", "high")),
            "Trial-LeftWheel.txt: line 6, column Acc_Y: 'high'",
        ),
    ],
    ids=["nothing shared", "twice", "backwards", "two rates", "no column", "text"],
)
def test_bad_xsens_exports(tmp_path, change, message):
    parts = change({s: xsens(made(), s, 100) for s in SENSORS})
    with pytest.raises(InputError, match=message):
        read_recording(write_xsens(tmp_path, parts))


def test_xsens_names_that_do_not_say_which_sensor(tmp_path):
    recording = made()
    prefix = write_xsens(tmp_path, {s: xsens(recording, s, 0) for s in SENSORS})
    alone = read_recording(tmp_path / "Trial-Frame.txt")
    assert list(alone.sensors) == ["frame"]
    assert np.array_equal(alone.sensor("frame").acc_mps2, recording.sensor("frame").acc_mps2)
    (tmp_path / "Trial-LeftWheel2.txt").write_text("//\n")
    with pytest.raises(InputError, match="two files for the left_wheel sensor"):
        read_recording(prefix)
    with pytest.raises(InputError, match="no Xsens exports whose names begin like this"):
        read_recording(tmp_path / "Other")


# Recordings


def test_recording_cannot_be_changed_and_knows_its_sensors():
    recording = made()
    assert len(recording) == 12
    with pytest.raises(TypeError):
        recording.sensors["frame"] = recording.sensor("left_wheel")
    with pytest.raises(InputError, match=r"no sensor 'lever' .*frame, left_wheel, right_wheel"):
        recording.sensor("lever")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((np.arange(3.0), {}), "no sensor"),
        ((np.arange(1.0), {"frame": Imu(np.full((1, 3), 6.0))}), "expected at least 2"),
        ((np.arange(3.0), {"frame": Imu(np.ones((4, 3)))}), r"expected shape \(3, 3\)"),
        ((np.zeros((3, 1)), {"frame": Imu(np.ones((3, 3)))}), "one time series"),
        ((["a", "b"], {"frame": Imu(np.ones((2, 3)))}), "real numbers"),
    ],
)
def test_impossible_recordings_are_refused(arguments, message):
    with pytest.raises(InputError, match=message):
        Recording(*arguments)


def test_a_late_sample_is_no_gap_and_hardly_moves_the_rate():
    time_s = np.arange(200) / 100
    time_s[50] += 0.004
    acc = np.tile([0, 0, 9.81], (200, 1))
    assert Recording(time_s, {"frame": Imu(acc)}).sampling_rate_hz == 100.0


def test_a_wheel_at_speed_is_not_mistaken_for_another_unit():
    # 0.1 m from the axle at 12 rad/s: 14.4 m/s^2 outward, gravity turning round
    angle = 12 * np.arange(300) / 100
    acc = np.column_stack([14.4 + 9.8 * np.cos(angle), 9.8 * np.sin(angle), 0 * angle])
    gyr = np.tile([0, 0, 12.0], (300, 1))
    Recording(np.arange(300) / 100, {"left_wheel": Imu(acc, gyr)})


def test_trim_keeps_the_clock_and_the_samples_in_between():
    recording = made(count=100)
    part = recording.trim(0.2, 0.5)
    assert part.time_s[[0, -1]].tolist() == [0.2, 0.49]
    expected = recording.sensor("frame").acc_mps2[20:50]
    assert np.array_equal(part.sensor("frame").acc_mps2, expected)
    with pytest.raises(InputError, match=r"nothing between 2 and 3 s.*from 0 to 0\.99 s"):
        recording.trim(2, 3)


def test_resampling_interpolates_and_the_own_rate_changes_nothing():
    time_s = np.arange(101) / 100
    acc = np.column_stack([time_s, -2 * time_s, 9.81 + time_s])  # linear: no error at all
    recording = Recording(time_s, {"frame": Imu(acc, acc), "lever": Imu(acc)})
    for rate in (100, 128, 50, 33):
        other = recording.resample(rate)
        assert other.sampling_rate_hz == pytest.approx(rate)
        assert other.time_s[-1] <= time_s[-1] + 1e-9
        assert time_s[-1] - other.time_s[-1] < 1 / rate
        t = other.time_s
        expected = np.column_stack([t, -2 * t, 9.81 + t])
        assert other.sensor("frame").acc_mps2 == pytest.approx(expected, abs=1e-12)
        assert other.sensor("frame").gyr_radps == pytest.approx(expected, abs=1e-12)
        assert other.sensor("lever").gyr_radps is None
    same = recording.resample(100)
    assert same.sensor("frame").acc_mps2 == pytest.approx(acc, abs=1e-12)
    with pytest.raises(InputError, match="sampling_rate_hz = 0"):
        recording.resample(0)


# Velocity series


def velocity_csv(header, decimal=".", separator=";", count=30, step=0.01):
    time_s = np.arange(count) * step
    lines = [separator.join(header)]
    for t in time_s:
        row = (t, 1 + t, -20 - 3 * t)
        lines.append(separator.join(f"{x:.6f}".replace(".", decimal) for x in row))
    return "\n".join(lines) + "\n"


HEADERS = {
    "French": ("Temps (s)", "Vitesse lineaire (m/s)", "Vitesse angulaire (deg/s)"),
    "French with accents": ("Temps (s)", "Vitesse linéaire (m/s)", "Vitesse angulaire (°/s)"),
    "English": ("Time (s)", "Linear velocity (m/s)", "Angular velocity (deg/s)"),
    "Spanish": ("Tiempo (s)", "Velocidad lineal (m/s)", "Velocidad angular (deg/s)"),
    "ours": ("time_s", "linear_velocity_mps", "yaw_rate_degps"),
}


SEPARATORS = [(";", "."), (";", ","), (",", "."), ("\t", ",")]


@pytest.mark.parametrize("language", HEADERS)
@pytest.mark.parametrize(
    ("separator", "decimal"), [(";", "."), (";", ","), (",", "."), ("\t", ",")]
)
def test_velocity_csv_in_three_languages(tmp_path, language, separator, decimal):
    text = velocity_csv(HEADERS[language], decimal, separator)
    found = read_velocities(write(tmp_path / "velocity.csv", text))
    t = np.arange(30) / 100
    assert found.sampling_rate_hz == 100
    assert found.time_s == pytest.approx(t, abs=1e-12)
    assert found.linear_velocity_mps == pytest.approx(1 + t, abs=1e-12)
    assert found.yaw_rate_radps == pytest.approx(np.deg2rad(-20 - 3 * t), abs=TWO_ROUNDINGS * 10)


def test_velocity_csv_in_rad_per_second_and_without_clock(tmp_path):
    text = "yaw_rate_radps,linear_velocity_mps\n1.5,0.5\n2.5,0.7\n"
    path = write(tmp_path / "velocity.csv", text)
    with pytest.warns(UserWarning, match=r"counted at 50 Hz.*lost samples cannot be seen"):
        found = read_velocities(path, sampling_rate_hz=50)
    assert found.yaw_rate_radps.tolist() == [1.5, 2.5]
    assert found.linear_velocity_mps.tolist() == [0.5, 0.7]
    assert found.time_s.tolist() == [0, 0.02]
    with pytest.raises(InputError, match="no time column"):
        read_velocities(path)


ENGLISH = HEADERS["English"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (velocity_csv(("Time (s)", "Linear velocity (kt)", "Angular velocity")), "no unit that"),
        (velocity_csv(("Time (s)", "Speed (m/s)", "Angular velocity")), "no column for the linear"),
        (velocity_csv(("Time (s)", "Linear velocity", "Turning")), "no column for the angular"),
        (velocity_csv(("Angle (deg)", "Linear v", "Angular v")), "2 columns for the angular"),
        (velocity_csv(ENGLISH).replace("\n0.050000;", "\n0.080000;"), "even steps of 0.01 s"),
        (
            velocity_csv(ENGLISH).replace("\n0.050000;", "\n0.040000;"),
            r"from 0\.04 to 0\.04 s",
        ),
        (velocity_csv(ENGLISH).replace("1.050000", ""), "line 7, column Linear velocity"),
        (velocity_csv(ENGLISH).replace("1.050000", "nan"), "line 7, column Linear velocity"),
        (velocity_csv(ENGLISH).replace("1.050000", "fast"), "line 7.*'fast' is not a number"),
        (velocity_csv(ENGLISH, count=1), "only one row"),
        (velocity_csv(ENGLISH, count=0), "no rows"),
        ("", "empty"),
    ],
)
def test_bad_velocity_csv(tmp_path, text, message):
    path = write(tmp_path / "velocity.csv", text)
    with pytest.raises(InputError, match=message) as error:
        read_velocities(path)
    assert str(path) in str(error.value)


def test_times_that_are_rounded_in_print_are_still_even(tmp_path):
    # 128 Hz printed to the millisecond: steps of 7 and 8 ms
    text = velocity_csv(ENGLISH, count=1281, step=1 / 128)
    lines = text.splitlines()
    rounded = [lines[0]] + [
        ";".join([f"{float(line.split(';')[0]):.3f}", *line.split(";")[1:]]) for line in lines[1:]
    ]
    path = write(tmp_path / "velocity.csv", "\n".join(rounded))
    assert read_velocities(path).sampling_rate_hz == pytest.approx(128, abs=0.02)
