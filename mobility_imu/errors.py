"""Errors that a user can mend: one family, so that one ``except`` catches them all."""


class MobilityImuError(Exception):
    """Root of the errors that this package raises on purpose."""


class InputError(MobilityImuError, ValueError):
    """A file, array or setting is not what was expected; the message says what, where and why."""
