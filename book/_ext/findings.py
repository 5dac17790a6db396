"""Sphinx extension: ``findings``, ``finding-list`` and ``finding-counts`` show findings.toml.

An entry shows its heading, verdict and consequence; quotation, interpretation and the numbers of
its check are folded below. The check runs while the page is built.
"""

import math
import re
from pathlib import Path

from docutils import nodes
from docutils.statemachine import StringList
from sphinx.util.docutils import SphinxDirective

import mobility_imu.reproduction.findings as source

DATA = Path(source.__file__).with_name("findings.toml")
READING = "The interpretation in which the authors are right"
READINGS = {
    "silence": "What is most natural to assume",
    **dict.fromkeys(("contradiction", "error", "our copy"), "What speaks for the authors"),
}
"""What the reading of a finding is, by its kind; READING for the others."""


def shown(value):
    """A number with four significant digits, "–" for none."""
    if math.isnan(value):
        return "–"
    return "0" if abs(value) < 1e-9 else f"{value:.4g}".replace("-", "−")


def quoted(text):
    """One passage as a block quotation; bare formulas as literals, as the text copy has them."""
    bare = "$" not in text and re.search(r"[\\^]|q\(", text)
    body = f"`{text}`" if bare else text.replace("\t\t", " | ").replace("\t", " | ")
    return f"> {body}"


class Findings(SphinxDirective):
    """All findings of one work."""

    required_arguments = 1

    def run(self):
        """Write the entries in MyST and let the page's own parser read them."""
        self.env.note_dependency(str(DATA))
        lines = []
        for finding in source.findings(self.arguments[0]):
            lines += self.entry(finding)
        return self.parsed(lines)

    def entry(self, finding):
        """Lines of one finding."""
        lines = [
            f"(finding-{finding.id.lower()})=",
            "::::::{card}",
            ":::::{card-header}",
            f"**{finding.id}. {finding.title}** · {finding.place} · *{finding.kind}*",
            ":::::",
            f"**Verdict.** {finding.verdict}",
            "",
            f"**For a user.** {finding.consequence}",
            "",
            ":::::{dropdown} Quotation, interpretation and check",
        ]
        for passage in finding.quotation:
            lines += [quoted(passage), ""]
        lines += [
            f"**{READINGS.get(finding.kind, READING)}.** {finding.reading}",
            "",
            f"**What would decide the question.** {finding.settles}",
            "",
            f"**The check**, {{py:func}}`~{finding.check}`, ran when this page was built:",
            "",
            "::::{list-table}",
            ":header-rows: 1",
            ":class: finding-check",
            "",
            "* - quantity",
            "  - first number",
            "  - second number",
            "  - right number, if known",
        ]
        for item in finding.evidence():
            if not item.holds():
                raise self.error(f"{finding.id} does not hold: {item}")
            unit = f" {item.unit}" if item.unit else ""
            lines += [
                f"* - {item.what}",
                f"  - {item.first_from}: **{shown(item.first)}**{unit}",
                f"  - {item.second_from}: **{shown(item.second)}**{unit}",
                f"  - {shown(item.truth)}{'' if math.isnan(item.truth) else unit}",
            ]
        chapters = ", ".join(f"{{doc}}`/{chapter}`" for chapter in finding.chapters)
        return [*lines, "::::", "", f"More: {chapters}.", ":::::", "::::::", ""]

    def parsed(self, lines):
        """Nodes of MyST lines."""
        box = nodes.container()
        self.state.nested_parse(StringList(lines, source=str(DATA)), 0, box)
        return box.children


class FindingList(Findings):
    """Titles of all findings of one work, each with a link to its entry."""

    def run(self):
        """Write the table in MyST."""
        self.env.note_dependency(str(DATA))
        lines = ["::::{list-table}", ":header-rows: 1", ":class: finding-check", ""]
        lines += ["* - finding", "  - place and kind"]
        for finding in source.findings(self.arguments[0]):
            link = f"{{ref}}`{finding.id} <finding-{finding.id.lower()}>`"
            lines += [f"* - {link} {finding.title}"]
            lines += [f"  - {finding.place}: *{finding.kind}*"]
        return self.parsed([*lines, "::::"])


class FindingCounts(Findings):
    """Number of findings by work and kind."""

    required_arguments = 0

    def run(self):
        """Write the table in MyST."""
        self.env.note_dependency(str(DATA))
        counted = source.counts()
        lines = ["::::{list-table}", ":header-rows: 1", ":class: finding-check", "", "* - kind"]
        lines += [f"  - {work}" for work in counted]
        for kind, meaning in source.KINDS.items():
            lines += [f"* - *{kind}*: {meaning}"]
            lines += [f"  - {counted[work][kind] or '–'}" for work in counted]
        return self.parsed([*lines, "::::"])


def setup(app):
    """Register the directives."""
    app.add_directive("findings", Findings)
    app.add_directive("finding-list", FindingList)
    app.add_directive("finding-counts", FindingCounts)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
