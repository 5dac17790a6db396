"""Settings of all tests."""

import gc
import os
import signal

import pytest

# The compiled loops from the first call on: otherwise a fresh environment's first tests run the
# readable forms, whose last digits differ, and the comparison of processes byte by byte fails.
os.environ.setdefault("MOBILITY_IMU_COMPILE", "always")


def pytest_configure(config: pytest.Config) -> None:
    """Name the marker of tests that `make check` runs."""
    config.addinivalue_line(
        "markers", "slow: run by `make check STEP=slow` or -m slow; a faster test stands beside it"
    )


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave slow tests out, unless the markers that are asked for name them."""
    if "slow" in config.option.markexpr:
        return
    slow = [item for item in items if item.get_closest_marker("slow")]
    if slow:
        config.hook.pytest_deselected(items=slow)
        items[:] = [item for item in items if item not in set(slow)]


def pytest_collection_finish(session: pytest.Session) -> None:
    """Leave what was collected out of the search for garbage, a sixth of the suite's time."""
    gc.collect()
    gc.freeze()


@pytest.fixture
def hears_interrupts():
    """A suite in the background of a shell ignores interrupts, and so would what it starts."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)
