"""Pages of the API: one for each module, written where the book's sources are laid out."""

from __future__ import annotations

import importlib
import pkgutil
from functools import cache
from pathlib import Path

ROOT = "mobility_imu"
LEFT_OUT = (f"{ROOT}.cli", f"{ROOT}.plots")
"""The commands have ``--help``, the figures their pages."""
PAGE = """# {title}

```{{eval-rst}}
.. automodule:: {name}
   :members:
   :show-inheritance:
```
"""


@cache
def modules_of(name: str) -> tuple[str, ...]:
    """A package and all modules in it, without private ones, by their names."""
    module = importlib.import_module(name)
    found = [name]
    for each in pkgutil.iter_modules(getattr(module, "__path__", [])):
        inside = f"{name}.{each.name}"
        if not each.name.startswith("_") and inside not in LEFT_OUT:
            found += modules_of(inside)
    return tuple(found)


@cache
def documented() -> tuple[str, ...]:
    """Modules that have a page; packages have none, for their names stand with their modules."""
    return tuple(n for n in modules_of(ROOT) if not hasattr(importlib.import_module(n), "__path__"))


def page_of(module: str) -> str:
    """Name of a module's page below ``book``, without its ending."""
    return f"api/{module.removeprefix(f'{ROOT}.')}"


def write_pages(book: Path) -> None:
    """Write a page for each module.

    Parameters
    ----------
    book : folder ``book`` of the laid out sources
    """
    (book / "api").mkdir(parents=True, exist_ok=True)
    for name in documented():
        title = name.removeprefix(f"{ROOT}.")
        (book / f"{page_of(name)}.md").write_text(PAGE.format(title=title, name=name))
