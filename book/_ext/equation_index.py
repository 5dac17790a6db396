"""Sphinx extension: the directive ``equation-index`` makes the table of book/equations.yml.

Functions and chapters become cross-references, so that a strict build finds dead ones.
"""

from pathlib import Path

import yaml
from docutils.statemachine import StringList
from sphinx.util.docutils import SphinxDirective

INDEX = Path(__file__).resolve().parents[1] / "equations.yml"
VERDICT = {
    "right": "right",
    "error": "**not right**",
    "contradiction": "**contradicts** another place",
    "ambiguous": "*ambiguous*",
    "silent": "*silent*",
    "copy": "*our copy*",
}


class EquationIndex(SphinxDirective):
    """Table of the numbered equations of one work."""

    required_arguments = 1

    def run(self):
        """Write the table in MyST and let the page's own parser read it."""
        entries = yaml.safe_load(INDEX.read_text())
        self.env.note_dependency(str(INDEX))
        chosen = [entry for entry in entries if entry["work"] == self.arguments[0]]
        lines = [
            ":::::{list-table}",
            ":header-rows: 1",
            ":widths: 8 34 30 28",
            ":class: equation-index",
            "",
            "* - Equation",
            "  - What it says",
            "  - As printed",
            "  - Function, chapter, test",
        ]
        for entry in chosen:
            printed = VERDICT[entry["printed"]]
            if entry.get("correction"):
                printed += f": {entry['correction']}"
            lines += [
                f"* - ({entry['number']})",
                f"  - {entry['says']}",
                f"  - {' '.join(printed.split())}",
                f"  - {self.where(entry)}",
            ]
        lines.append(":::::")
        return self.parse_text_to_nodes_at(lines)

    def where(self, entry):
        """Links to the code, the chapter and the test."""
        if entry["status"] == "open":
            return "*open*"
        chapter = entry["notebook"].removesuffix(".ipynb")
        return (
            f"{{py:func}}`~{entry['function']}` · {{doc}}`/{chapter}` · "
            f"`{entry['test'].split('::')[-1]}`"
        )

    def parse_text_to_nodes_at(self, lines):
        """Parse MyST lines into nodes."""
        from docutils import nodes

        box = nodes.container()
        self.state.nested_parse(StringList(lines, source=str(INDEX)), 0, box)
        return box.children


def setup(app):
    """Register the directive."""
    app.add_directive("equation-index", EquationIndex)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
