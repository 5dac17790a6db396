"""The catalogue of data sets, and where they are found."""

import re
from dataclasses import replace
from pathlib import Path

import pytest

from mobility_imu import data
from mobility_imu.datasets import catalogue, dataset_folder, list_datasets
from mobility_imu.datasets.folders import NOTE, cache_folder
from mobility_imu.datasets.obtain import _recipe
from mobility_imu.errors import InputError

NAMES = [dataset.name for dataset in list_datasets()]


@pytest.fixture(autouse=True)
def nothing_named(monkeypatch, tmp_path):
    """A machine on which no variable names a folder, and nothing was fetched."""
    for name in ("MOBILITY_IMU_RECORDINGS", "MOBILITY_IMU_DATA", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("MOBILITY_IMU_CACHE", str(tmp_path / "cache"))


@pytest.mark.parametrize("dataset", list_datasets(), ids=NAMES)
def test_every_entry_is_complete(dataset):
    assert re.fullmatch(r"[0-9a-f]{40}", dataset.commit)
    assert dataset.origin.startswith("https://")
    assert dataset.licence and dataset.about and dataset.good_for
    assert dataset.download_mb > 0 and dataset.size_mb > 0
    assert dataset.sha256 is None or re.fullmatch(r"[0-9a-f]{64}", dataset.sha256)
    recipe = _recipe(dataset)
    assert not recipe.wanted("README.md") and callable(recipe.convert)


def test_the_sample_is_that_of_the_pages():
    sample = list_datasets()[0]
    assert sample.sha256 == data.SAMPLE_ARCHIVE_SHA256
    assert sample.commit == data.SAMPLE_COMMIT and sample.origin.endswith(data.SAMPLE_ARCHIVE)


def test_unknown_name_lists_the_names():
    with pytest.raises(InputError, match=r"expected 'wheelmove-id-sample', .* or 'foot-walks'"):
        dataset_folder("terrain_chair")


def test_what_is_not_here_says_how_to_get_it(tmp_path):
    with pytest.raises(InputError, match="mobility-imu fetch terrain-chair"):
        dataset_folder("terrain-chair")
    assert list(tmp_path.iterdir()) == []  # looking makes no folder


class TestRecordingsVariable:
    def test_a_subfolder_of_the_name_comes_first(self, monkeypatch, tmp_path):
        for folder in ("r/terrain-chair", "r/drives"):
            (tmp_path / folder).mkdir(parents=True)
        monkeypatch.setenv("MOBILITY_IMU_RECORDINGS", str(tmp_path / "r"))
        assert dataset_folder("terrain-chair") == tmp_path / "r" / "terrain-chair"

    @pytest.mark.parametrize(
        ("name", "folder"),
        [
            ("terrain-chair", "drives"),
            ("labelled-walks", "walks"),
            ("mocap-chair", "truth/chair_mocap"),
            ("car-wheels", "truth/car_gnss"),
            ("two-hinges", "truth/two_hinges"),
            ("one-hinge", "truth/one_hinge"),
            ("foot-walks", "truth/foot_vicon"),
        ],
    )
    def test_other_names_of_the_folder(self, monkeypatch, tmp_path, name, folder):
        (tmp_path / folder).mkdir(parents=True)
        monkeypatch.setenv("MOBILITY_IMU_RECORDINGS", str(tmp_path))
        assert dataset_folder(name) == tmp_path / folder

    def test_it_comes_before_the_cache_which_has_the_rest(self, monkeypatch, tmp_path):
        for name in ("two-hinges", "one-hinge"):
            cached(tmp_path / "cache" / name, name)
        (tmp_path / "r" / "two-hinges").mkdir(parents=True)
        monkeypatch.setenv("MOBILITY_IMU_RECORDINGS", str(tmp_path / "r"))
        assert dataset_folder("two-hinges") == tmp_path / "r" / "two-hinges"
        assert dataset_folder("one-hinge") == tmp_path / "cache" / "one-hinge"

    def test_a_folder_that_does_not_exist(self, monkeypatch, tmp_path):
        monkeypatch.setenv("MOBILITY_IMU_RECORDINGS", str(tmp_path / "gone"))
        with pytest.raises(InputError, match=r"MOBILITY_IMU_RECORDINGS = .*gone: no such folder"):
            dataset_folder("one-hinge")

    def test_the_sample_has_a_variable_of_its_own(self, monkeypatch, tmp_path):
        (tmp_path / "r" / "wheelmove-id-sample").mkdir(parents=True)
        monkeypatch.setenv("MOBILITY_IMU_RECORDINGS", str(tmp_path / "r"))
        assert dataset_folder("wheelmove-id-sample").name == "wheelmove-id-sample"
        monkeypatch.setenv("MOBILITY_IMU_DATA", str(tmp_path))
        assert dataset_folder("wheelmove-id-sample") == tmp_path


class TestCache:
    def test_only_what_was_fetched_whole_counts(self, tmp_path):
        folder = tmp_path / "cache" / "one-hinge"
        folder.mkdir(parents=True)
        with pytest.raises(InputError):
            dataset_folder("one-hinge")
        cached(folder, "one-hinge")
        assert dataset_folder("one-hinge") == folder

    def test_another_commit_or_recipe_is_another_data_set(self, tmp_path, monkeypatch):
        folder = tmp_path / "cache" / "one-hinge"
        cached(folder, "two-hinges")
        with pytest.raises(InputError):
            dataset_folder("one-hinge")
        cached(folder, "one-hinge")
        later = replace(catalogue.DATASETS["one-hinge"], recipe=12)
        monkeypatch.setitem(catalogue.DATASETS, "one-hinge", later)
        with pytest.raises(InputError):
            dataset_folder("one-hinge")

    def test_platform_folder(self, monkeypatch, tmp_path):
        monkeypatch.delenv("MOBILITY_IMU_CACHE")
        monkeypatch.setattr("sys.platform", "linux")
        monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
        assert cache_folder() == tmp_path / "mobility-imu"
        monkeypatch.setenv("XDG_CACHE_HOME", "relative")
        monkeypatch.setenv("HOME", str(tmp_path / "home"))
        assert cache_folder() == tmp_path / "home" / ".cache" / "mobility-imu"
        monkeypatch.setattr("sys.platform", "darwin")
        assert cache_folder() == tmp_path / "home" / "Library" / "Caches" / "mobility-imu"
        monkeypatch.setattr("sys.platform", "win32")
        monkeypatch.setenv("LOCALAPPDATA", str(tmp_path / "local"))
        assert cache_folder() == tmp_path / "local" / "mobility-imu"

    def test_the_cache_may_be_named_from_the_home_folder(self, monkeypatch, tmp_path):
        """Files of settings name it so, and no shell reads them."""
        monkeypatch.setenv("HOME", str(tmp_path))
        monkeypatch.setenv("MOBILITY_IMU_CACHE", "~/imu")
        assert cache_folder() == tmp_path / "imu"

    def test_without_a_home(self, monkeypatch):
        monkeypatch.delenv("MOBILITY_IMU_CACHE")

        def no_home():
            raise RuntimeError("Could not determine home directory.")

        monkeypatch.setattr(Path, "home", no_home)
        with pytest.raises(InputError, match="name one in the variable MOBILITY_IMU_CACHE"):
            cache_folder()


def cached(folder, name):
    """A folder as ``fetch`` leaves it."""
    stamp = next(d.stamp for d in list_datasets() if d.name == name)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / NOTE).write_text(f"{name}\n{stamp}\n")
