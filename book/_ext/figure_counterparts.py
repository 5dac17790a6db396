"""Sphinx extension: the directive ``figure-counterparts`` makes the table of figures.toml.

Pages and figures become cross-references, so that a strict build finds dead ones.
"""

import tomllib
from pathlib import Path

from docutils import nodes
from docutils.statemachine import StringList
from sphinx.util.docutils import SphinxDirective

import mobility_imu.reproduction as package

DATA = Path(str(package.__file__)).with_name("figures.toml")


class FigureCounterparts(SphinxDirective):
    """Table of the figures and tables of one work and of ours in their place."""

    required_arguments = 1

    def run(self):
        """Write the table in MyST and let the page's own parser read it."""
        content = tomllib.loads(DATA.read_text(encoding="utf-8"))
        self.env.note_dependency(str(DATA))
        lines = [
            ":::::{list-table}",
            ":header-rows: 1",
            ":widths: 15 23 30 32",
            ":class: equation-index",
            "",
            "* - In the work",
            "  - What it shows",
            "  - Here",
            "  - Basis",
        ]
        for entry in content["figure"]:
            if entry["work"] == self.arguments[0]:
                basis = content["bases"][entry["basis"]]
                lines += [
                    f"* - {entry['printed']}",
                    f"  - {entry['shows']}",
                    f"  - {self.where(entry)}",
                    f"  - *{basis}*. {entry['note']}",
                ]
        lines.append(":::::")
        box = nodes.container()
        self.state.nested_parse(StringList(lines, source=str(DATA)), 0, box)
        return box.children

    def where(self, entry):
        """Links to our figures and to the page that they stand on."""
        links = [
            f"{{numref}}`{label}`" if label.startswith("fig-") else f"{{ref}}`{label}`"
            for label in entry["labels"]
        ]
        if entry["page"]:
            links.append(f"{{doc}}`/{entry['page']}`")
        return ", ".join(links) or "–"


def setup(app):
    """Register the directive."""
    app.add_directive("figure-counterparts", FigureCounterparts)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
