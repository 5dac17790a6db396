"""Errors that a user can mend: one family, so that one ``except`` catches them all."""

from __future__ import annotations

from types import ModuleType

EXTRAS = {
    "numba": "fast",
    "matplotlib": "plot",
    "emcee": "book",
    "sympy": "book",
    "dask": "cluster",
    "distributed": "cluster",
    "pooch": "fetch",
}
"""Libraries that are not part of the core, and the extra that brings each."""


class MobilityImuError(Exception):
    """Root of the errors that this package raises on purpose."""


class InputError(MobilityImuError, ValueError):
    """A file, array or setting is not what was expected; the message says what, where and why."""


class MissingExtraError(MobilityImuError, ImportError):
    """A library is missing that an extra of this package brings; the message names the extra."""


def needs(module: str) -> ModuleType:
    """Module of a library that is not part of the core.

    Parameters
    ----------
    module : name of the module; its library is one of :data:`EXTRAS`

    Returns
    -------
    module

    Raises
    ------
    MissingExtraError
        If the library is not installed.
    """
    import importlib

    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        raise missing_extra(error) or error from None


def missing_extra(error: ModuleNotFoundError) -> MissingExtraError | None:
    """Error that names the extra for a library that was not found.

    Parameters
    ----------
    error : what the import raised

    Returns
    -------
    MissingExtraError, or None if no extra brings the library

    Examples
    --------
    >>> missing_extra(ModuleNotFoundError(name="matplotlib.pyplot"))
    MissingExtraError("needs matplotlib: pip install 'mobility-imu[plot]'")
    """
    library = (error.name or "").partition(".")[0]
    if library not in EXTRAS:
        return None
    return MissingExtraError(f"needs {library}: pip install 'mobility-imu[{EXTRAS[library]}]'")
