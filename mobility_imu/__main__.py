"""``python -m mobility_imu`` is the command line."""

# What this needs is imported where an interrupt is caught: Ctrl-C may come at once.
from __future__ import annotations

import sys

INTERRUPTED = 130


def main() -> None:
    """Run the command line as a process of its own.

    An interrupt ends it with exit code 130 and one line, also while libraries are still being
    loaded. Once the command has ended, an interrupt changes nothing any more.
    """
    code: object = 0
    try:
        sys.unraisablehook = _deliver_interrupts
        from mobility_imu.cli.main import main as run

        run()
    except KeyboardInterrupt:
        if sys.stderr is not None:
            print("mobility-imu: interrupted", file=sys.stderr)
        code = INTERRUPTED
    except SystemExit as left:
        code = left.code
    _leave(code)


def _leave(code: object) -> None:
    """End the process with an exit code."""
    import os
    import signal
    from contextlib import suppress

    with suppress(ValueError):  # signals can be set in the main thread only
        signal.signal(signal.SIGINT, signal.SIG_IGN)
    if code == INTERRUPTED:
        # The interpreter would end itself with a signal, if a library saw the interrupt too.
        with suppress(OSError, AttributeError):
            sys.stderr.flush()
        os._exit(INTERRUPTED)
    sys.exit(code)  # type: ignore[arg-type]


def _deliver_interrupts(unraisable: sys.UnraisableHookArgs) -> None:
    """Let an interrupt that came where Python drops exceptions come again a moment later."""
    if unraisable.exc_type is KeyboardInterrupt:
        import os
        import signal
        import threading

        # From another thread: here it would be dropped again.
        threading.Timer(0.02, os.kill, (os.getpid(), signal.SIGINT)).start()
    else:
        sys.__unraisablehook__(unraisable)


if __name__ == "__main__":
    main()
