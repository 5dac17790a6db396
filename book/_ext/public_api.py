"""Sphinx extension: what a package offers, as tables that lead to the pages of its modules.

``public-api`` lists the names in a package's ``__all__``, each with the first line of its
docstring and a link to where it is defined; of a module without ``__all__`` it lists what that
defines. ``module-list`` lists the pages of all modules (``book/modules.py``).
"""

import ast
import importlib
import inspect
import re
import sys
from functools import cache
from itertools import pairwise
from pathlib import Path

from docutils import nodes
from docutils.statemachine import StringList
from sphinx.util.docutils import SphinxDirective

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from modules import ROOT, documented, modules_of, page_of


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


@cache
def described(name):
    """Data of a module that have a docstring, and so a place on its page."""
    body = ast.parse(Path(importlib.import_module(name).__file__).read_text()).body
    found = set()
    for node, after in pairwise(body):
        text = isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant)
        if text and isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            found |= {target.id for target in targets if isinstance(target, ast.Name)}
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
    module = importlib.import_module(package)
    if not hasattr(module, "__all__"):
        return [
            (name, package) for name in sorted(assigned(package)) if is_documented(module, name)
        ]
    found = []
    for name in module.__all__:
        value = getattr(module, name)
        found.append((name, None if inspect.ismodule(value) else home(package, name)))
    return found


def is_documented(module, name):
    """Whether a module's own page shows a name: a class or function with a docstring."""
    value = getattr(module, name)
    kind = inspect.isclass(value) or inspect.isroutine(value)
    return not name.startswith("_") and kind and bool(inspect.getdoc(value))


def first_line(package, name, module):
    """What a name is, in a line; data have their line on their page only."""
    value = getattr(importlib.import_module(package), name)
    if module is not None and not (inspect.isclass(value) or inspect.isroutine(value)):
        return "(data)"
    line = (inspect.getdoc(value) or "").partition("\n")[0]
    return re.sub(r":[\w:]+:`~?(?:\w+\.)*(\w+)`", r"``\1``", line)  # it stands in another module


def public_lines(package):
    """Table of what a package or a module offers."""
    lines = [".. list-table::", "   :widths: 35 65", ""]
    for name, module in offered(package):
        target = f"{package}.{name}" if module is None else f"{module}.{name}"
        role = "py:mod" if module is None else "py:obj"
        value = getattr(importlib.import_module(package), name)
        shown = inspect.isclass(value) or inspect.isroutine(value) or module is None
        linked = shown or name in described(module)
        lines += [f"   * - :{role}:`{name} <{target}>`" if linked else f"   * - ``{name}``"]
        lines += [f"     - {first_line(package, name, module)}"]
    return lines


def module_lines(_):
    """Table of all modules."""
    lines = [".. list-table::", "   :widths: 35 65", ""]
    for name in documented():
        line = (inspect.getdoc(importlib.import_module(name)) or "").partition("\n")[0]
        title = name.removeprefix(f"{ROOT}.")
        lines += [f"   * - :doc:`{title} </book/{page_of(name)}>`", f"     - {line}"]
    return lines


class PublicApi(SphinxDirective):
    """Names in a package's ``__all__``."""

    required_arguments = 1
    lines_of = staticmethod(public_lines)

    def run(self):
        """Write reStructuredText and let the page's own parser read it."""
        argument = self.arguments[0] if self.arguments else ""
        lines = ["```{eval-rst}", *self.lines_of(argument), "```"]
        box = nodes.container()
        self.state.nested_parse(StringList(lines, source=__file__), 0, box)
        return box.children


class ModuleList(PublicApi):
    """Pages of all modules."""

    required_arguments = 0
    lines_of = staticmethod(module_lines)


def no_type(app, what, name, obj, options, lines):
    """Docstrings of data have no type before a colon, as napoleon takes it: write another mark."""
    if what in ("attribute", "data", "property") and lines:
        lines[0] = lines[0].replace(": ", "; ")


def setup(app):
    """Register the directives."""
    app.connect("autodoc-process-docstring", no_type, priority=400)  # before napoleon
    app.add_directive("public-api", PublicApi)
    app.add_directive("module-list", ModuleList)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
