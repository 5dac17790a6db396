"""``python -m mobility_imu`` is the command line."""

# What this needs is imported where an interrupt is caught: Ctrl-C may come at once.
from __future__ import annotations

import sys

INTERRUPTED = 130
ENDINGS = ("SIGTERM", "SIGHUP")
"""Signals of a scheduler that ends a process, and of a terminal that is closed."""
TWICE_S = 1.0
"""``timeout`` sends a signal to the process and to its group, which are one more."""
_ended_by: list[tuple[int, float]] = []
"""Signals that ended the process, with their times."""


def main() -> None:
    """Run the command line as a process of its own.

    An interrupt ends it with exit code 130 and one line, also while libraries are still being
    loaded. A signal that ends processes leaves nothing behind either; whoever sent it sees that the
    process ended by it. Once the command has ended, an interrupt changes nothing any more.
    """
    code: object = 0
    try:
        sys.unraisablehook = _deliver_interrupts
        _hear_endings()
        from mobility_imu.cli.main import main as run

        run()
    except KeyboardInterrupt:
        if sys.stderr is not None:
            print("mobility-imu: interrupted", file=sys.stderr)
        code = INTERRUPTED
    except SystemExit as left:
        code = left.code
    _leave(code)


def _hear_endings() -> None:
    """Let signals that end the process be interrupts, unless they are ignored, as by ``nohup``."""
    import signal
    from contextlib import suppress

    for number in (getattr(signal, name, None) for name in ENDINGS):
        if number is not None and signal.getsignal(number) == signal.SIG_DFL:
            with suppress(ValueError):  # signals can be set in the main thread only
                signal.signal(number, _interrupt)


def _interrupt(number: int, frame: object) -> None:
    import time

    now_s = time.monotonic()
    if _ended_by and now_s - _ended_by[-1][1] < TWICE_S:
        return  # it must not stop the tidying up
    _ended_by.append((number, now_s))
    raise KeyboardInterrupt


def _leave(code: object) -> None:
    """End the process with an exit code."""
    import os
    import signal
    from contextlib import suppress

    with suppress(ValueError):  # signals can be set in the main thread only
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        for number in (getattr(signal, name, None) for name in ENDINGS):
            if number is not None and signal.getsignal(number) is _interrupt:
                signal.signal(number, signal.SIG_IGN)
    if code == INTERRUPTED:
        # The interpreter would end itself with a signal, if a library saw the interrupt too.
        with suppress(OSError, AttributeError):
            sys.stderr.flush()
        if _ended_by:
            signal.signal(_ended_by[0][0], signal.SIG_DFL)
            os.kill(os.getpid(), _ended_by[0][0])
        os._exit(INTERRUPTED)
    sys.exit(code)  # type: ignore[arg-type]


def _deliver_interrupts(unraisable: sys.UnraisableHookArgs) -> None:
    """Let an interrupt that came where Python drops exceptions come again a moment later."""
    if unraisable.exc_type is KeyboardInterrupt:
        import os
        import signal
        import threading

        again = _ended_by.pop()[0] if _ended_by else signal.SIGINT
        # From another thread: here it would be dropped again.
        threading.Timer(0.02, os.kill, (os.getpid(), again)).start()
    else:
        sys.__unraisablehook__(unraisable)


if __name__ == "__main__":
    main()
