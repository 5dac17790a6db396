"""Settings of all tests."""

import gc
import os
import signal
import tomllib
from collections import defaultdict
from pathlib import Path

import pytest
from hypothesis import settings

# No test is about time: a busy machine, or one without numba, is slow.
settings.register_profile("any speed", deadline=None)
settings.load_profile("any speed")
# The compiled loops from the first call on: otherwise a fresh environment's first tests run the
# readable forms, whose last digits differ, and the comparison of processes byte by byte fails.
os.environ.setdefault("MOBILITY_IMU_COMPILE", "always")


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the option that runs all variants."""
    parser.addoption(
        "--every-variant", action="store_true", help="also run what rare.toml leaves out"
    )


def pytest_configure(config: pytest.Config) -> None:
    """Name the marker of tests that `make check` runs."""
    config.addinivalue_line(
        "markers", "slow: run by `make check STEP=slow` or -m slow; a faster test stands beside it"
    )


RARE = Path(__file__).with_name("rare.toml")
"""How many variants of some tests run with each change."""


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave slow tests out, unless the markers that are asked for name them."""
    alone = config.option.keyword or any("::" in named for named in config.args)
    if not (alone or config.getoption("every_variant")):
        for item in rare_items(items):
            item.add_marker(pytest.mark.slow)
    if "slow" in config.option.markexpr:
        return
    slow = [item for item in items if item.get_closest_marker("slow")]
    if slow:
        config.hook.pytest_deselected(items=slow)
        items[:] = [item for item in items if item not in set(slow)]


def rare_items(items: list[pytest.Item]) -> list[pytest.Item]:
    """Variants that ``rare.toml`` leaves to ``make check STEP=slow``."""
    groups: dict[tuple[str, str], list[pytest.Item]] = defaultdict(list)
    for item in items:
        parts = item.nodeid.split("[")[0].removeprefix("tests/").split("::")
        place = ".".join([parts[0].removesuffix(".py").replace("/", "."), *parts[1:-1]])
        if not item.get_closest_marker("slow"):
            groups[place, parts[-1]].append(item)
    rare = []
    for place, tests in tomllib.loads(RARE.read_text()).items():
        for name, often in tests.items():
            variants = groups[place, name]
            kept = {int(k * len(variants) / often) for k in range(often)}
            rare += [item for k, item in enumerate(variants) if k not in kept]
    return rare


def pytest_collection_finish(session: pytest.Session) -> None:
    """Leave what was collected out of the search for garbage, a sixth of the suite's time."""
    gc.collect()
    gc.freeze()


@pytest.fixture
def no_collection():
    """No search for garbage: at the end of the stack hypothesis, which counts its time, has no room
    left to be called, and Python says so on standard error."""
    gc.disable()
    yield
    gc.enable()


@pytest.fixture
def hears_interrupts():
    """A suite in the background of a shell ignores interrupts, and so would what it starts."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)
