"""Files as vendors write them, under ``data/recordings/vendor``, are made again."""

import numpy as np
import vendor_files

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
