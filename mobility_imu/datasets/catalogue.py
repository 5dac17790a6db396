"""The data sets: origin, commit, licence, size, and what each is good for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

from mobility_imu import data
from mobility_imu.arguments import expect
from mobility_imu.fields import check_fields
from mobility_imu.frames import one_of

Name = Literal[
    "wheelmove-id-sample",
    "worklab-ngimu",
    "terrain-chair",
    "labelled-walks",
    "mocap-chair",
    "car-wheels",
    "two-hinges",
    "one-hinge",
    "foot-walks",
]
NO_LICENCE = "none stated"
"""Then nobody may pass the files on; they may be read where their owner published them."""


@dataclass(frozen=True)
class Dataset:
    """A public set of recordings.

    Parameters
    ----------
    name : by which it is fetched
    about : what was recorded, and with which reference
    good_for : what it can test
    origin : address of the git repository; for a single file, address of the file
    commit : of the repository, all 40 digits
    licence : as the origin states it, or "none stated"
    download_mb : about so much is transferred, MB
    size_mb : so much the converted files take, MB
    subfolders : names, besides its own, of its folder below MOBILITY_IMU_RECORDINGS
    sha256 : checksum of a single file; None for a repository, whose commit is its checksum
    recipe : number of the conversion; a change of what is written raises it
    """

    name: str
    about: str
    good_for: str
    origin: str
    commit: str
    licence: str
    download_mb: float
    size_mb: float
    subfolders: tuple[str, ...] = ()
    sha256: str | None = None
    recipe: int = 1

    def __post_init__(self) -> None:
        """Check every field."""
        texts = ("name", "about", "good_for", "origin", "commit", "licence")
        numbers = {"download_mb": float, "size_mb": float, "recipe": int}
        check_fields(self, **dict.fromkeys(texts, str), **numbers, subfolders=[str])
        expect("Dataset.sha256", self.sha256, str, none=True)

    @property
    def stamp(self) -> str:
        """Line of the note that tells this conversion of this commit from any other."""
        return f"Commit: {self.commit}, recipe {self.recipe}"


def list_datasets() -> list[Dataset]:
    """Every data set that can be fetched.

    Returns
    -------
    list of Dataset

    Examples
    --------
    >>> [dataset.name for dataset in list_datasets()][:3]
    ['wheelmove-id-sample', 'worklab-ngimu', 'terrain-chair']
    """
    return [DATASETS[name] for name in get_args(Name)]


def find_dataset(name: str) -> Dataset:
    """Data set of a name.

    Parameters
    ----------
    name : as in ``list_datasets``

    Returns
    -------
    Dataset

    Raises
    ------
    InputError
        If there is no such data set.
    """
    return DATASETS[one_of("data set", name, get_args(Name))]


DATASETS = {
    dataset.name: dataset
    for dataset in (
        Dataset(
            name="wheelmove-id-sample",
            about="WheelMove-ID's own sample: one court drive, a static and a straight trial; "
            "Xsens sensors on frame and both wheels of a wheelchair, 100 Hz",
            good_for="comparing speeds and tasks with the published tool; no reference",
            origin=data.SAMPLE_REPOSITORY.replace("github.com", "raw.githubusercontent.com")
            + f"/{data.SAMPLE_COMMIT}/{data.SAMPLE_ARCHIVE}",
            commit=data.SAMPLE_COMMIT,
            licence=NO_LICENCE,
            download_mb=2.5,
            size_mb=6,
            sha256=data.SAMPLE_ARCHIVE_SHA256,
        ),
        Dataset(
            name="worklab-ngimu",
            about="one coast-down and turn of a sports chair, 35 s; NGIMUs on frame and both "
            "wheels, 400 Hz",
            good_for="reading NGIMU sessions, joining clocks, coasting; no reference",
            origin="https://github.com/sophiedkk/worklab",
            commit="257d9bcff724d5b86ff6eae9a90815243b1cfd60",
            licence="GPL-3.0",
            download_mb=1.3,
            size_mb=2,
        ),
        Dataset(
            name="terrain-chair",
            about="14 drives of a chair on seven kinds of ground, straight and in circles; IMUs on "
            "frame and both wheels, 200 Hz",
            good_for="gyroscope offsets at rest, track from turning, vibration; the frame's "
            "gyroscope is the only reference",
            origin="https://github.com/KeenanMcConkey/Wheelchair-Terrain-Classification",
            commit="ec403a0479c533761b45187f6a9b08a0e4d8a76b",
            licence=NO_LICENCE,
            download_mb=27,
            size_mb=4,
            subfolders=("drives",),
        ),
        Dataset(
            name="labelled-walks",
            about="25 walks with a walking frame, one IMU, 80 Hz, 505 steps labelled by the "
            "authors",
            good_for="finding steps; mount, course and person are not known",
            origin="https://github.com/AntonyGarcia/rollator_paper",
            commit="d9fea04be7dc3f90ed4e1235e0e6653aae8a19a3",
            licence=NO_LICENCE,
            download_mb=7,
            size_mb=3,
            subfolders=("walks",),
        ),
        Dataset(
            name="mocap-chair",
            about="sports chairs, 15 people, figure 8, slalom, straight pushes, turns, sprints; "
            "x-IMU3 on frame and right wheel, 50 Hz; motion capture, 120 Hz",
            good_for="speed and yaw rate against motion capture",
            origin="https://github.com/aagdebruijn1/Python_cleaned",
            commit="5fd1199b0584d5dcdd96c5419e063ee33326750f",
            licence=NO_LICENCE,
            download_mb=200,
            size_mb=8,
            subfolders=("truth/chair_mocap",),
        ),
        Dataset(
            name="car-wheels",
            about="6 drives of a car, Xsens DOT on the body and on both wheels of one axle, "
            "120 Hz; satellite positions (RTK), centimetres",
            good_for="speed and path against satellite positions; clocks that differ",
            origin="https://github.com/ansfl/WID",
            commit="9f15b32a26393c5870e83fc31948280eb41e5710",
            licence=NO_LICENCE,
            download_mb=24,
            size_mb=7,
            subfolders=("truth/car_gnss",),
        ),
        Dataset(
            name="two-hinges",
            about="2 runs of a hand-held chain with two hinges, IMUs rigid and on foam, 40 Hz; "
            "motion capture, 30 Hz",
            good_for="both angles at once on a moving base",
            origin="https://github.com/anonymous-sup-material/ring_supplementary_material",
            commit="c4a84c247d76482c7a12c3a0ea42888805be9efa",
            licence=NO_LICENCE,
            download_mb=6,
            size_mb=0.7,
            subfolders=("truth/two_hinges",),
        ),
        Dataset(
            name="one-hinge",
            about="5 runs of a motorised hinge on a fixed base, two MPU-6050, 100 Hz; encoder, "
            "0.08 deg",
            good_for="one angle over a whole sweep; coarse sensors",
            origin="https://github.com/ssong47/compute_relative_angle_between_two_IMUs",
            commit="f1c3019717fa6bcef439df5862d20bf6d3e6a07e",
            licence="MIT",
            download_mb=15,
            size_mb=5,
            subfolders=("truth/one_hinge",),
        ),
        Dataset(
            name="foot-walks",
            about="56 walks with a sensor on the foot, 200 Hz, running, stairs and crawling among "
            "them; motion capture at every sample",
            good_for="filter and smoother on a foot, rests given",
            origin="https://github.com/mtahakoroglu/LLIO-aided-iPyShoe",
            commit="a87e82775fae483851de09bf3cc0c14b0b48aacd",
            licence="MIT",
            download_mb=27,
            size_mb=16,
            subfolders=("truth/foot_vicon",),
        ),
    )
}
