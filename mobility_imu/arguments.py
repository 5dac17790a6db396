"""Checks of arguments that are objects: of a class, several recordings, columns of a result."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, TypeVar

import numpy as np

from mobility_imu.errors import InputError
from mobility_imu.executors import check_executor, run_all
from mobility_imu.frames import as_flags, as_floats, shown
from mobility_imu.recording import Recording

__all__ = ["check_columns", "check_limits", "expect", "for_each", "settings_or_default"]

Found = TypeVar("Found")
Settings = TypeVar("Settings")


def expect(name: str, value: object, kind: type, *, none: bool = False) -> None:
    """Check that an argument is of the class that a function works with.

    Parameters
    ----------
    name : of the argument
    value : what was given
    kind : class that it must have
    none : whether None is allowed as well

    Raises
    ------
    InputError
        If it is something else.

    Examples
    --------
    >>> expect("geometry", 0.35, Recording)
    Traceback (most recent call last):
    mobility_imu.errors.InputError: geometry: got float, expected Recording
    """
    if isinstance(value, kind) or (none and value is None):
        return
    got, expected = type(value).__name__, kind.__name__
    if isinstance(value, type):
        got = f"the class {value.__name__} itself"
    elif got == expected:  # two devices may each have a class of this name
        got, expected = (f"{one.__module__}.{one.__qualname__}" for one in (type(value), kind))
    raise InputError(f"{name}: got {got}, expected {expected}{' or None' if none else ''}")


def settings_or_default(name: str, value: Settings | None, kind: type[Settings]) -> Settings:
    """Settings that were given, checked, or the default ones for None.

    Parameters
    ----------
    name : of the argument
    value : settings, or None
    kind : class of the settings, with a default for each field

    Returns
    -------
    settings

    Raises
    ------
    InputError
        If it is something else.
    """
    if value is None:
        return kind()
    expect(name, value, kind)
    return value


def for_each(
    estimate: Callable[..., Found], recording: Any, executor: Any = None, **given: Any
) -> Found | list[Found]:
    """Result of an estimate for one recording, or a list of them for several.

    Parameters
    ----------
    estimate : function of a recording; for another process it has to be picklable
    recording : Recording, or a list or tuple of them
    executor : anything with ``submit``, for several (:func:`~mobility_imu.executors.run_all`)
    **given : what else the function takes

    Returns
    -------
    result, or list of results in the order of the recordings

    Raises
    ------
    InputError
        If an argument is something else.
    """
    check_executor(executor)
    if isinstance(recording, Recording):
        return estimate(recording, **given)
    if not isinstance(recording, list | tuple):
        raise InputError(
            f"recording: got {type(recording).__name__}, expected Recording or a list of them"
        )
    for number, one in enumerate(recording):
        expect(f"recording {number}", one, Recording)
    return run_all(partial(estimate, **given), [(one,) for one in recording], executor)


def check_columns(result: Any, *names: str, flags: Sequence[str] = ()) -> None:
    """Check that fields of a result are series of one length, and make them arrays.

    Parameters
    ----------
    result : frozen dataclass, in its ``__post_init__``
    names : fields of numbers, (n,); NaN may stand in them. The first one tells the length
    flags : fields of truth values, (n,)

    Raises
    ------
    InputError
        If a field is no such series, or longer or shorter than the first one.
    """
    arrays = {name: as_floats(getattr(result, name), _label(result, name)) for name in names}
    shape = np.shape(arrays[names[0]])
    for name, array in arrays.items():
        if array.shape != shape or array.ndim != 1:
            like = "one series" if name == names[0] else f"shape {shape} like {names[0]}"
            raise InputError(f"{_label(result, name)}: expected {like}, got shape {array.shape}")
        object.__setattr__(result, name, array)
    for name in flags:
        given = as_flags(getattr(result, name), _label(result, name), length=shape[0])
        object.__setattr__(result, name, given)


def check_shape(result: Any, name: str, shape: tuple[int, ...]) -> None:
    """Check that a field of a result is an array of numbers of one shape, and make it one.

    Parameters
    ----------
    result : frozen dataclass, in its ``__post_init__``
    name : of the field; NaN may stand in it
    shape : that it must have

    Raises
    ------
    InputError
        If the field is something else.
    """
    array = as_floats(getattr(result, name), _label(result, name))
    if array.shape != shape:
        raise InputError(f"{_label(result, name)}: expected shape {shape}, got {array.shape}")
    object.__setattr__(result, name, array)


def check_limits(settings: Any, limits: Mapping[str, tuple[float, float]]) -> None:
    """Check that fields of settings lie between limits, beyond which nothing can be computed.

    Parameters
    ----------
    settings : dataclass, in its ``__post_init__``; the fields are numbers
    limits : name of a field to its smallest and largest value

    Raises
    ------
    InputError
        If a field lies outside; the message names class, field and limits.
    """
    for name, (low, high) in limits.items():
        value = getattr(settings, name)
        if not low <= value <= high:
            raise InputError(
                f"{_label(settings, name)} = {shown(value)}: expected between {low:g} and {high:g}"
            )


def _label(result: Any, name: str) -> str:
    return f"{type(result).__name__}.{name}"
