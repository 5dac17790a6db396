"""What pyproject.toml cannot say: the tables of ``data/`` that a wheel carries in the package."""

import re
from pathlib import Path

from setuptools import find_packages, setup

CARRIED = {"published": "*.csv", "recorded": "*.json", "reference": "*"}
"""Folders of ``data/``, and which of their files."""

# A picture by a relative path would be broken where only this text is shown.
readme = re.sub(
    r"^!\[.*\]\((?!https?:).*\)\n+", "", Path("README.md").read_text("utf-8"), flags=re.M
)

inside = {name: f"mobility_imu._data.{name}" for name in CARRIED}
setup(
    packages=[*find_packages(include=["mobility_imu", "mobility_imu.*"]), *inside.values()],
    package_dir={package: f"data/{name}" for name, package in inside.items()},
    package_data={
        "mobility_imu": ["py.typed"],
        "mobility_imu.reproduction": ["*.toml"],
        **{inside[name]: [files] for name, files in CARRIED.items()},
    },
    long_description=readme,
    long_description_content_type="text/markdown",
)
