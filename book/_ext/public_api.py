"""Sphinx extension: directives that document a package from what it says of itself.

``public-api`` documents the names in a package's ``__all__``, each with where it is defined, so
that every reference finds it; a module without ``__all__`` is documented whole. ``inside``
documents the rest of a package: what its modules define and no ``__all__`` lists.
"""

import ast
import importlib
import inspect
import pkgutil
import re
from functools import cache
from pathlib import Path

from docutils import nodes
from docutils.statemachine import StringList
from sphinx.util.docutils import SphinxDirective

ROOT = "mobility_imu"
PAGE = Path(__file__).resolve().parents[1] / "api.md"


@cache
def modules_of(name):
    """A package and all modules in it, without private ones, by their names."""
    module = importlib.import_module(name)
    found = [name]
    for each in pkgutil.iter_modules(getattr(module, "__path__", [])):
        if not each.name.startswith("_"):
            found += modules_of(f"{name}.{each.name}")
    return tuple(found)


@cache
def assigned(name):
    """Names that a module assigns or defines at its top level."""
    found = set()
    for node in ast.parse(Path(importlib.import_module(name).__file__).read_text()).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            found.add(node.name)
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            parts = [part for target in targets for part in ast.walk(target)]
            found |= {part.id for part in parts if isinstance(part, ast.Name)}
    return frozenset(found)


def home(package, name):
    """Module of a package, or beside it, that defines a name which the package offers."""
    value = getattr(importlib.import_module(package), name)
    told = getattr(value, "__module__", "")
    if told.startswith(f"{ROOT}.") and name in assigned(told):
        return told
    for module in (*modules_of(package), *modules_of(ROOT)):
        if name in assigned(module) and vars(importlib.import_module(module))[name] is value:
            return module
    raise LookupError(f"{package}.__all__: nothing defines {name}")


def offered(package):
    """Names that a package offers, with the modules that define them; a module by None."""
    found = []
    for name in getattr(importlib.import_module(package), "__all__", ()):
        value = getattr(importlib.import_module(package), name)
        found.append((name, None if inspect.ismodule(value) else home(package, name)))
    return found


@cache
def public():
    """Modules and names that the page with ``public-api`` documents."""
    found = set(re.findall(r"^```{public-api} (\S+)$", PAGE.read_text(), flags=re.MULTILINE))
    for package in modules_of(ROOT):
        if hasattr(importlib.import_module(package), "__path__"):
            found |= {
                f"{package}.{name}" if module is None else f"{module}.{name}"
                for name, module in offered(package)
            }
    return frozenset(found)


def public_lines(package):
    """Lines that document what a package or a module offers."""
    if not hasattr(importlib.import_module(package), "__all__"):
        return [f".. automodule:: {package}", "   :members:", "   :show-inheritance:"]
    lines = [f".. automodule:: {package}", ""]
    for name, module in offered(package):
        if module is None:
            lines += [f".. automodule:: {package}.{name}", "   :members:", ""]
            continue
        value = getattr(importlib.import_module(package), name)
        kind = "class" if inspect.isclass(value) else "function" if callable(value) else "data"
        if kind == "function" and not inspect.isroutine(value):
            kind = "data"
        lines += [f".. auto{kind}:: {module}.{name}"]
        lines += ["   :members:", ""] if kind == "class" else [""]
    return lines


def inside_lines(package):
    """Lines that document the rest of a package."""
    lines = []
    for module in modules_of(package):
        if hasattr(importlib.import_module(module), "__path__") or module in public():
            continue
        shown = [name for name in assigned(module) if f"{module}.{name}" in public()]
        lines += [f".. automodule:: {module}", "   :members:"]
        lines += [f"   :exclude-members: {', '.join(sorted(shown))}", ""] if shown else [""]
    return lines


class PublicApi(SphinxDirective):
    """Names in a package's ``__all__``."""

    required_arguments = 1
    lines_of = staticmethod(public_lines)

    def run(self):
        """Write reStructuredText and let the page's own parser read it."""
        lines = ["```{eval-rst}", *self.lines_of(self.arguments[0]), "```"]
        box = nodes.container()
        self.state.nested_parse(StringList(lines, source=__file__), 0, box)
        return box.children


class Inside(PublicApi):
    """What the modules of a package define and no ``__all__`` lists."""

    lines_of = staticmethod(inside_lines)


def setup(app):
    """Register the directives."""
    app.add_directive("public-api", PublicApi)
    app.add_directive("inside", Inside)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
