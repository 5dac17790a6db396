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
# Jupyter Book adds Thebe to each page even if it is switched off; its script asks for a server.
THEBE = re.compile(
    r"<link\b[^>]*sphinx-thebe\.css[^>]*>|<script\b[^>]*sphinx-thebe\.js[^>]*>\s*</script>"
    r"|<script>const THEBE_JS_URL\b.*?</script>"
    r'|<script type="text/x-thebe-config">.*?</script>\s*<script>kernelName\b.*?</script>',
    re.DOTALL,
)
LOADS = re.compile(r'<(?:script|img|iframe|source|video|audio)\b[^>]*\bsrc="https?://[^"]*"')


def clean(app, error):
    """Drop foreign tags; stop the build if anything else would be loaded from elsewhere."""
    if error is not None or app.builder.format != "html":
        return
    for page in Path(app.outdir).rglob("*.html"):
        text = page.read_text(encoding="utf-8")
        cleaned = THEBE.sub("", FOREIGN.sub("", text))
        if cleaned != text:
            page.write_text(cleaned, encoding="utf-8")
        left = LOADS.search(cleaned)
        if left:
            raise ExtensionError(f"{page.name} loads something from elsewhere: {left[0]}")


def setup(app):
    """Register the hook."""
    app.connect("build-finished", clean)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
