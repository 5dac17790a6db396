"""Folders and archives that hold more than one recording are refused, and never mixed."""

import shutil
import zipfile

import dialects
import pytest
from test_dialects import assert_same, made, quietly

from mobility_imu.errors import InputError
from mobility_imu.readers.recordings import understand
from mobility_imu.readers.sessions import read_session
from mobility_imu.readers.streams import Asked


def packed(folder):
    archive = folder.with_name(folder.name + ".zip")
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as out:
        for file in sorted(p for p in folder.rglob("*") if p.is_file()):
            out.write(file, file.relative_to(folder))
    return archive


def study(folder, write, names=("P1", "P2")):
    for seed, name in enumerate(names):
        (folder / name).mkdir(parents=True)
        write(made(seed=seed), folder / name)
    return folder


def one_ngimu(recording, folder):
    inner = next(dialects.ngimu(recording, folder).glob("NGIMU*"))
    for file in inner.iterdir():
        file.rename(folder / file.name)
    inner.rmdir()


def of_ios(recording, folder):
    return dialects.sensor_logger(recording, folder, platform="ios")


@pytest.mark.parametrize("zipped", [False, True], ids=["folder", "archive"])
@pytest.mark.parametrize("write", [dialects.sensor_logger, of_ios, dialects.phyphox])
def test_two_phones_in_one_folder_are_not_mixed(tmp_path, write, zipped):
    folder = study(tmp_path / "study", write)
    with pytest.raises(InputError, match=r"holds 2 recordings: P1 \(.*\), P2 \(.*one of these"):
        quietly(packed(folder) if zipped else folder)
    assert_same(quietly(folder / "P2"), made(seed=1))


@pytest.mark.parametrize("zipped", [False, True], ids=["folder", "archive"])
@pytest.mark.parametrize("write", [dialects.ximu3, one_ngimu])
def test_sensors_that_are_taken_as_one_session_are_told_with_their_folders(tmp_path, write, zipped):
    """Two recordings of one sensor each lie as two sensors of one session do."""
    folder = study(tmp_path / "day", write, names=("walk1", "walk2"))
    path = packed(folder) if zipped else folder
    (said,) = understand(path).warnings
    assert said.startswith(f"{path}: sensors in walk1, walk2 taken as one session on one clock; if")
    assert understand(folder / "walk2").warnings == ()
    _, streams = read_session(path, Asked(own_clocks=True))
    assert [stream.warnings for stream in streams] == [(), ()]


def test_two_sessions_of_x_io_are_not_mixed(tmp_path):
    folder = study(tmp_path / "study", dialects.ngimu)
    with pytest.raises(InputError, match=r"holds 2 recordings: P1 \(x-io\), P2 \(x-io\)"):
        quietly(packed(folder))


def test_folders_that_lie_too_deep_are_listed(tmp_path):
    study(tmp_path / "study", dialects.ngimu)
    with pytest.raises(InputError, match="it holds P1/, P2/"):
        quietly(tmp_path / "study")


@pytest.mark.parametrize("write", [dialects.sensor_logger, dialects.phyphox, dialects.ximu3])
def test_a_copy_within_a_recording_is_a_second_one(tmp_path, write):
    write(made(), tmp_path)
    (tmp_path / "backup").mkdir()
    for file in tmp_path.glob("*.csv"):
        shutil.copy(file, tmp_path / "backup")
    with pytest.raises(InputError, match=r"holds 2 recordings: .*backup"):
        quietly(tmp_path)


def test_a_phone_beside_a_session_is_not_passed_over(tmp_path):
    dialects.ngimu(made(("lever", "body")), tmp_path)
    (tmp_path / "phone").mkdir()
    dialects.sensor_logger(made(), tmp_path / "phone")
    with pytest.raises(InputError, match=r"\. \(x-io\), phone \(Sensor Logger\)"):
        quietly(tmp_path)


def test_what_macos_packs_beside_the_files_is_no_recording(tmp_path):
    folder = study(tmp_path / "study", dialects.sensor_logger, names=("walk",))
    archive = packed(folder)
    with zipfile.ZipFile(archive, "a") as out:
        for name in ("Gyroscope", "Metadata", "TotalAcceleration"):
            out.write(folder / "walk" / f"{name}.csv", f"__MACOSX/walk/._{name}.csv")
    assert_same(quietly(archive), made(seed=0))


def test_the_current_folder_has_a_name_and_nothing_has_none(tmp_path, monkeypatch):
    dialects.ximu3(made(), tmp_path)
    monkeypatch.chdir(tmp_path)
    assert quietly(".").source.endswith(tmp_path.name)
    for empty in ("", ["frame=a.csv", ""]):
        with pytest.raises(InputError, match="empty"):
            quietly(empty)


def flipped(content):
    at = content.index(b"Gyroscope.csv") + 200
    return content[:at] + bytes(255 - byte for byte in content[at : at + 20]) + content[at + 20 :]


def locked(content):
    """The mark of a password on each member; their content stays."""
    for mark, at in ((b"PK\x03\x04", 6), (b"PK\x01\x02", 8)):
        head, *rest = content.split(mark)
        rest = [part[: at - 4] + bytes([part[at - 4] | 1]) + part[at - 3 :] for part in rest]
        content = mark.join([head, *rest])
    return content


@pytest.mark.parametrize(
    ("spoil", "says"),
    [(flipped, r"Gyroscope\.csv: cannot be read \("), (locked, "password")],
    ids=["damaged", "password"],
)
def test_an_archive_that_cannot_be_read_is_refused(tmp_path, spoil, says):
    path = packed(dialects.sensor_logger(made(), tmp_path))
    path.write_bytes(spoil(path.read_bytes()))
    with pytest.raises(InputError, match=says):
        quietly(path)


@pytest.mark.parametrize("write", [dialects.sensor_logger, dialects.phyphox])
def test_rates_that_cannot_be_read_are_not_left_out(tmp_path, write):
    """An app writes an empty file for a sensor that a phone has not; a damaged one is a fault."""
    folder = write(made(), tmp_path)
    (folder / "Gyroscope.csv").write_bytes(b"")
    (phone,) = quietly(folder).sensors.values()
    assert phone.gyr_radps is None
    (folder / "Gyroscope.csv").write_bytes(b"\x00\xff\xfe")
    with pytest.raises(InputError, match=r"Gyroscope\.csv: not a text file"):
        quietly(folder)
