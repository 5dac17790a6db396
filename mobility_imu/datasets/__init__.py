"""Public recordings by name: where they are, how they are fetched, what was done to them.

None of them comes with this package: most have no licence for passing them on. ``mobility-imu
fetch NAME`` brings one from its origin at a fixed commit, checks it, turns it into the canonical
CSV and writes beside it what was done. The environment variable MOBILITY_IMU_RECORDINGS may name a
folder that holds such data sets already.
"""

from mobility_imu.datasets.catalogue import Dataset, list_datasets
from mobility_imu.datasets.folders import CACHE_VARIABLE, RECORDINGS_VARIABLE, dataset_folder
from mobility_imu.datasets.obtain import fetch_dataset

__all__ = [
    "CACHE_VARIABLE",
    "RECORDINGS_VARIABLE",
    "Dataset",
    "dataset_folder",
    "fetch_dataset",
    "list_datasets",
]
