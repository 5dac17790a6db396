"""Angles, tasks and paths of mobility aids from inertial sensors.

Three devices share one plan (read, calibrate, estimate, summarise, show):
``mobility_imu.scooter``, ``mobility_imu.wheelchair`` and ``mobility_imu.walker``; readers,
simulators and the comparison with the published numbers stand beside them. Importing this package
loads none of them: each is loaded when it is first used.
"""

from __future__ import annotations

TYPE_CHECKING = False  # as in typing, which would have to be loaded
if TYPE_CHECKING:
    from types import ModuleType

__version__ = "0.1.0"


def __getattr__(name: str) -> ModuleType:
    """Load a module of this package when it is first used."""
    import importlib.util

    if (
        not name.isidentifier()
        or name.startswith("_")
        or importlib.util.find_spec(f"{__name__}.{name}") is None
    ):
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return importlib.import_module(f"{__name__}.{name}")


def __dir__() -> list[str]:
    """Names in this package, its modules among them."""
    import pkgutil

    modules = (found.name for found in pkgutil.iter_modules(__path__))
    return sorted({*globals(), *(name for name in modules if not name.startswith("_"))})
