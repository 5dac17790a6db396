"""Settings of all tests."""

import os

# The compiled loops from the first call on: otherwise a fresh environment's first tests run the
# readable forms, whose last digits differ, and the comparison of processes byte by byte fails.
os.environ.setdefault("MOBILITY_IMU_COMPILE", "always")
