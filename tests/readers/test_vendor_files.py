"""Files as vendors write them, under ``data/recordings/vendor``, are made again."""

import os
import re
from contextlib import chdir

import numpy as np
import vendor_files

from mobility_imu.cli.main import app
from mobility_imu.data import recordings_folder
from mobility_imu.readers import read_recording
from mobility_imu.readers.recordings import understand
from mobility_imu.simulation import bundle

RECORDINGS = recordings_folder()
VENDOR = RECORDINGS / "vendor"


def test_the_vendors_files_are_made_again():
    court = RECORDINGS / "wheelchair_court"
    for name, text in vendor_files.chair_files(court).items():
        assert (VENDOR / "wheelchair" / name).read_text() == text
    walk = read_recording(RECORDINGS / "walker_corridor" / "walk.csv.gz")
    assert (VENDOR / "walker" / "Inertial.csv").read_text() == vendor_files.ximu3(walk)
    ride = bundle.scooter_bundle(1)["ride.csv.gz"]
    found = understand(
        VENDOR / "scooter" / "ride.csv", expected=("lever", "body")
    ).recording.to_frame()
    # LpmsControl's last digit is 1e-6 g; simulations differ by rounding from machine to machine.
    assert np.allclose(found[list(ride)], ride, atol=2e-5)


NUMBER = re.compile(r"-?\d+\.\d+")


def assert_same_toml(found, kept):
    """The same lines; last digits may differ by a rounding, as simulations do between machines."""
    assert NUMBER.sub("#", found) == NUMBER.sub("#", kept)
    for one, other in zip(NUMBER.findall(found), NUMBER.findall(kept), strict=True):
        last_digit = 10.0 ** -len(one.partition(".")[2])
        assert abs(float(one) - float(other)) < 1.5 * last_digit


def test_the_mounts_and_the_geometry_are_made_again(tmp_path):
    """By the commands that ``vendor_files`` runs; what is stored is not simulated anew."""
    for name, stored in (("court", "wheelchair_court"), ("corridor", "walker_corridor")):
        os.symlink(RECORDINGS / stored, tmp_path / name)
    with chdir(tmp_path):
        for run in vendor_files.RUNS:
            if not run.startswith(("simulate wheelchair", "simulate walker")):
                app(run.split(), standalone_mode=False)
    for found, kept in (
        ("scooter.toml", "scooter/scooter.toml"),
        ("court/geometry.toml", "wheelchair/geometry.toml"),
        ("frame.toml", "walker/frame.toml"),
    ):
        assert_same_toml((tmp_path / found).read_text(), (VENDOR / kept).read_text())
