"""What commands say on stderr: messages of one line, warnings of results, and summaries."""

from __future__ import annotations

import re
import sys
import warnings
from collections.abc import Iterable
from contextlib import suppress

LONGEST_MESSAGE = 1000
"""Most characters of a message; of a longer message the middle is left out."""
MOST_LINES = 5
"""Most lines of a summary."""


def say(message: str, *, name: str = "mobility-imu: ") -> None:
    """Print a message on stderr: one line, escaped, and shortened if it is long.

    Parameters
    ----------
    message : text, of one line or more
    name : text before the message
    """
    text = re.sub(r"\s*\n\s*", " ", message.strip())
    if not text.isprintable():
        # Only here: it loads numpy, which an interrupt may have left loaded by half.
        from mobility_imu.readers.wording import escaped

        text = escaped(text)
    if len(text) > LONGEST_MESSAGE:
        text = f"{text[: LONGEST_MESSAGE // 2]} ... {text[-LONGEST_MESSAGE // 2 :]}"
    if sys.stderr is not None:  # print would take standard output instead
        with suppress(OSError):
            print(f"{name}{text}", file=sys.stderr, flush=True)


def warn(sentences: Iterable[str]) -> None:
    """Collect the warnings of a result; they are shown when the command ends without an error.

    Parameters
    ----------
    sentences : ``warnings`` of a result
    """
    for sentence in sentences:
        warnings.warn(sentence, stacklevel=2)


def summarize(lines: Iterable[str], quiet: bool) -> None:
    """Print what a command read, found and wrote, on stderr.

    Parameters
    ----------
    lines : at most :data:`MOST_LINES`
    quiet : whether to print nothing
    """
    if quiet:
        return
    for line in list(lines)[:MOST_LINES]:
        say(line, name="")
