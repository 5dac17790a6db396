"""Source of the package as a chapter shows it: without docstrings, in lines that fit the page."""

from __future__ import annotations

import ast
import inspect
import re
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from IPython.display import Markdown

WIDEST = 78
"""Characters of a line of an output that fit a page of the book."""


def source_of(*functions: Callable[..., Any]) -> str:
    """Source of functions without their docstrings, no line longer than a page of the book.

    Parameters
    ----------
    functions : functions written in Python

    Returns
    -------
    str : the functions, two empty lines between them

    Examples
    --------
    >>> from mobility_imu.walker.eskf import motion_fraction
    >>> print(source_of(motion_fraction))
    def motion_fraction(noise: Noise) -> float:
        return noise.rate / (noise.rate + noise.gyr)
    """
    parts = []
    for function in functions:
        lines = inspect.getsource(function).splitlines()
        definition = ast.parse("\n".join(lines)).body[0]
        assert isinstance(definition, ast.FunctionDef)
        if ast.get_docstring(definition) is not None:
            first = definition.body[0]
            del lines[first.lineno - 1 : first.end_lineno]
        depth, folded = 0, []
        for line in lines:
            folded += _folded(line, inside=depth > 0)
            depth += sum((c in "([{") - (c in ")]}") for c in line)
        parts.append("\n".join(folded))
    return "\n\n\n".join(parts)


def show_source(*functions: Callable[..., Any]) -> Markdown:
    """Source of functions as a notebook shows it.

    Parameters
    ----------
    functions : as in :func:`source_of`

    Returns
    -------
    IPython.display.Markdown
    """
    from IPython.display import Markdown

    return Markdown(f"```python\n{source_of(*functions)}\n```")  # type: ignore[no-untyped-call]


def _folded(line: str, inside: bool = False) -> list[str]:
    """The same line of code in pieces that fit; a comment that does not fit comes first."""
    if len(line) <= WIDEST:
        return [line]
    indent = " " * (len(line) - len(line.lstrip()))
    code, mark, comment = line.partition("  # ")
    if mark:
        return [f"{indent}# {comment}", *_folded(code, inside)]
    breaks = _breaks(line, inside)
    whole = re.match(r"\s*(?:return|[^(=]+ =) ", line)
    if whole and (not breaks or len(indent) + 4 + len(line) - whole.end() <= WIDEST):
        right = f"{indent}    {line[whole.end() :]}"
        return [f"{whole[0]}(", *_folded(right, inside=True), f"{indent})"]
    if not breaks:
        return [line]
    at, further = max(breaks), indent if inside else f"{indent}    "
    return [line[:at], *_folded(f"{further}{line[at:].lstrip()}", inside=True)]


def _breaks(line: str, inside: bool) -> list[int]:
    """Where a line may end: within brackets, after a comma, before an operator."""
    depth, found = int(inside), []
    for k, character in enumerate(line[:WIDEST]):
        depth += (character in "([{") - (character in ")]}")
        if depth and line.startswith(", ", k):
            found.append(k + 1)
        elif depth and line.startswith((" + ", " else "), k):
            found.append(k)
    return found
