"""Sphinx extension: keep the finished pages free of anything that is loaded from elsewhere."""

import re
from pathlib import Path

from sphinx.errors import ExtensionError

# Tags that notebook outputs bring along (animations: an icon font; plotly: a second MathJax).
FOREIGN = re.compile(
    r'<link\b[^>]*\brel="?stylesheet"?[^>]*\bhref="https?://[^>]*>'
    r'|<link\b[^>]*\bhref="https?://[^>]*\brel="?stylesheet"?[^>]*>'
    r'|<script\b[^>]*\bsrc="https?://[^>]*>\s*</script>'
)
LOADS = re.compile(r'<(?:script|img|iframe|source|video|audio)\b[^>]*\bsrc="https?://[^"]*"')


def clean(app, error):
    """Drop foreign tags; stop the build if anything else would be loaded from elsewhere."""
    if error is not None or app.builder.format != "html":
        return
    for page in Path(app.outdir).rglob("*.html"):
        text = page.read_text(encoding="utf-8")
        cleaned = FOREIGN.sub("", text)
        if cleaned != text:
            page.write_text(cleaned, encoding="utf-8")
        left = LOADS.search(cleaned)
        if left:
            raise ExtensionError(f"{page.name} loads something from elsewhere: {left[0]}")


def setup(app):
    """Register the hook."""
    app.connect("build-finished", clean)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
