"""Names: exports by the beginning of theirs, lists with blanks and commas, folders of exports."""

import shutil
import unicodedata

import dialects
import pytest
from test_dialects import assert_same, made, quietly

from mobility_imu.errors import InputError
from mobility_imu.readers.recordings import recording_files, understand

CHAIR = ("frame", "left_wheel", "right_wheel")


def exports(folder, names, seed=3):
    folder.mkdir(exist_ok=True)
    made_in = folder / "made"
    made_in.mkdir()
    dialects.xsens_mt(made(CHAIR, seed=seed), made_in)
    for source, name in zip(("Frame", "LeftWheel", "RightWheel"), names, strict=True):
        if name:
            shutil.move(made_in / f"MT-{source}.txt", folder / f"{name}.txt")
    shutil.rmtree(made_in)
    return folder


@pytest.mark.parametrize("form", ["NFC", "NFD"])
def test_words_with_accents_tell_sensors(tmp_path, form):
    names = ("Essai-Châssis", "Essai-RoueGauche", "Essai-RoueDroite")
    exports(tmp_path, [unicodedata.normalize(form, name) for name in names])
    assert set(quietly(tmp_path / "Essai").sensors) == set(CHAIR)


def test_exports_may_end_in_capitals(tmp_path):
    exports(tmp_path / "t", ("Trial-Frame", "Trial-LeftWheel", "Trial-RightWheel"))
    wanted = quietly(tmp_path / "t" / "Trial")
    for path in list((tmp_path / "t").iterdir()):
        path.rename(path.with_suffix(".TXT"))
    assert_same(quietly(tmp_path / "t" / "Trial"), wanted)
    with pytest.raises(InputError, match=r"are given by the beginning of their names, as .*Trial"):
        quietly(tmp_path / "t")


def test_an_export_without_a_sensors_word_is_told(tmp_path):
    exports(tmp_path, ("Trial-Frame", "Trial-LeftWheel", "Trial-Head"))
    (tmp_path / "Trial-notes.txt").write_text("a windy day\n")
    found = understand(tmp_path / "Trial")
    assert set(found.recording.sensors) == {"frame", "left_wheel"}
    (said,) = [w for w in found.warnings if "not used" in w]
    assert said.endswith("no word for a sensor is in the name: Trial-Head.txt")


def test_trials_are_not_mixed(tmp_path):
    exports(tmp_path, ("Trial-Frame", "Trial1-LeftWheel", "Trial10-RightWheel"))
    exports(tmp_path, ("Trial1-Frame", "", ""), seed=4)
    assert set(quietly(tmp_path / "Trial").sensors) == {"frame"}
    assert set(quietly(tmp_path / "Trial1").sensors) == {"frame", "left_wheel"}
    with pytest.raises(InputError, match=r"several trials begin like this .*name one of them"):
        quietly(tmp_path / "T")
    (tmp_path / "Trial-Frame.txt").unlink()
    with pytest.raises(InputError, match="several trials begin like this"):
        quietly(tmp_path / "Trial")


def test_serial_numbers_are_no_trials(tmp_path):
    exports(tmp_path, ("Walk_00B42D4B_Frame", "Walk_00B421E6_LeftWheel", "Walk_00B421AF_Right"))
    assert set(quietly(tmp_path / "Walk").sensors) == set(CHAIR)


def test_a_folder_of_exports_says_how_they_are_named(tmp_path):
    folder = exports(tmp_path / "day", ("Trial-Frame", "Trial-LeftWheel", "Trial-RightWheel"))
    exports(folder, ("Static_Frame", "Static_LeftWheel", "Static_RightWheel"))
    with pytest.raises(InputError, match=r"of their names, as .*day/Static \(also Trial\)"):
        quietly(folder)


def test_a_folder_beside_exports_does_not_hide_them(tmp_path):
    exports(tmp_path, ("Trial-Frame", "Trial-LeftWheel", "Trial-RightWheel"))
    (tmp_path / "Trial").mkdir()
    (tmp_path / "Trial" / "notes.md").write_text("dry floor\n")
    assert set(quietly(tmp_path / "Trial").sensors) == set(CHAIR)
    assert tmp_path / "Trial-Frame.txt" in recording_files(tmp_path / "Trial")
    for file in tmp_path.glob("Trial-*.txt"):
        file.write_text("no export\n")
    with pytest.raises(InputError):
        quietly(tmp_path / "Trial")


@pytest.mark.parametrize(
    "written",
    [
        "lever={a}, body={b},clock=same",
        "lever={a},body={b}, clock=same",
        "lever = {a},body= {b},clock=same,",
        ["lever={a},", "body={b},", "clock=same"],
        ["lever={a}, body={b}", "clock=same"],
        [" lever={a}", "body={b}", "clock=same"],
    ],
)
def test_blanks_and_commas_in_lists(tmp_path, written):
    recording = made(("lever", "body"))
    table = recording.to_frame()
    files = {}
    for key, sensor in (("a", "lever"), ("b", "body")):
        files[key] = tmp_path / f"{key}.csv"
        own = table.filter(regex=f"^time_s|^{sensor}_")
        own.to_csv(files[key], index=False)
    parts = [written] if isinstance(written, str) else written
    given = [part.format(**files) for part in parts]
    assert_same(quietly(given[0] if isinstance(written, str) else given), recording)


def test_a_file_whose_name_has_a_comma_is_one_file(tmp_path):
    recording = made()
    path = tmp_path / "a, b=c.csv"
    recording.to_frame().to_csv(path, index=False)
    for name in (path, [path], [f"frame={path}"]):
        assert_same(quietly(name), recording)


@pytest.mark.parametrize("typed", [".", "..", "inner/.."])
def test_the_current_folder_is_named_as_typed(tmp_path, monkeypatch, typed):
    """Not by the whole path; a recording and its sensor are called by the folder's own name."""
    place = tmp_path / "left"
    (place / "inner").mkdir(parents=True)
    monkeypatch.chdir(place / "inner" if typed == ".." else place)
    with pytest.raises(InputError, match=f"^{typed}: is a folder or archive without") as error:
        quietly(typed)
    assert str(tmp_path) not in str(error.value)
    folder = dialects.ngimu(made(("left_wheel",)), tmp_path)
    (sensors,) = folder.rglob("sensors.csv")
    shutil.move(sensors, place)
    found = understand(typed, expected=("frame", "left_wheel"))
    assert set(found.recording.sensors) == {"left_wheel"}
    assert found.recording.source == "left"
    text = (place / "sensors.csv").read_text().split("\n")
    (place / "sensors.csv").write_text("\n".join([*text[:50], "1,2", *text[50:]]))
    with pytest.raises(InputError, match=f"^{typed}/sensors.csv: line 51"):
        quietly(typed)
