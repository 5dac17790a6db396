"""Look at every page of the built book in Chromium, wide and narrow, light and dark.

    make look          or          python checks/look.py [--pages PART ...] [--folder _build/html]

Held for every page: no sideways scrolling, no script error, no request to the outside, nothing that
axe-core calls serious in our own content. For chapters also: no code on the first screen, at most
ten shown lines of code before the first result, no code or table that scrolls at 1280 px, no
equation wider than a page of 390 px. All measures go to ``_build/look.json``.
"""

from __future__ import annotations

import argparse
import json
import shutil
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
SIZES = ((1280, 800), (390, 844))
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
LONGEST_SCREENS, LINES_BEFORE = 15.0, 10
LONGER = ("book/glossary", "book/equations", "book/api", "book/notation")
"""Pages to look something up in, not to be read through."""

MEASURE = """async () => {
  if (window.MathJax && MathJax.startup) await MathJax.startup.promise;
  document.querySelectorAll("img[loading=lazy]").forEach(i => i.loading = "eager");
  await Promise.all([...document.images].map(i => i.complete || i.decode().catch(() => 0)));
  const main = document.querySelector("article.bd-article") || document.body;
  const seen = e => e.getClientRects().length > 0 && e.checkVisibility({
    contentVisibilityAuto: true, visibilityProperty: true});
  const top = e => e.getBoundingClientRect().top + scrollY;
  const wider = e => e.scrollWidth > e.clientWidth + 1;
  const inputs = [...main.querySelectorAll("div.cell_input pre")].filter(seen);
  const results = [...main.querySelectorAll("div.cell_output, figure")].filter(seen);
  const lines = e => e.textContent.trimEnd().split("\\n").length;
  const first = results.length ? top(results[0]) : Infinity;
  const maths = [...main.querySelectorAll("div.math, mjx-container[display=true]")].filter(seen);
  const scrolls = e => ["auto", "scroll"].includes(getComputedStyle(e).overflowX) && wider(e);
  const inTable = [...main.querySelectorAll("table")].filter(seen).filter(t => {
    for (let e = t; e && e !== main; e = e.parentElement) if (scrolls(e)) return true;
    return t.getBoundingClientRect().right > innerWidth + 1;
  });
  return {
    screens: main.getBoundingClientRect().height / innerHeight,
    sideways: document.documentElement.scrollWidth > innerWidth + 1,
    code: [...main.querySelectorAll("div.highlight pre")].filter(seen).filter(wider).length,
    tables: inTable.length,
    maths: maths.filter(e => wider(e) || e.scrollWidth > innerWidth).length,
    first_code: inputs.length ? top(inputs[0]) : null,
    before: inputs.filter(e => top(e) < first).reduce((n, e) => n + lines(e), 0),
    terms: main.querySelectorAll("a.reference.internal[href*='#term-']").length,
  };
}"""
# The list of references is laid out by Sphinx: its roles are not ours.
AXE = """async () => (await axe.run({
  include: ["article.bd-article"], exclude: [".citation-list"]}, {
  resultTypes: ["violations"],
  runOnly: ["wcag2a", "wcag2aa"],
})).violations.filter(v => ["serious", "critical"].includes(v.impact)).map(
  v => `${v.id}: ${v.nodes.length} times, first ${v.nodes[0].target.join(" ")}`)"""


def browser() -> str | None:
    """Where Chromium is, None if it is not installed."""
    return next((found for name in BROWSERS if (found := shutil.which(name))), None)


def faults(page: str, width: int, seen: dict[str, Any]) -> list[str]:
    """What one view of a page has that it must not have."""
    chapter = page.startswith("notebooks/")
    found = [f"script: {each}" for each in seen["errors"]]
    found += [f"asks for {each}" for each in seen["outside"]]
    found += [f"axe: {each}" for each in seen["axe"]]
    if seen["sideways"]:
        found.append("scrolls sideways")
    if width == SIZES[0][0]:
        if seen["code"]:
            found.append(f"{seen['code']} boxes of code scroll")
        if seen["tables"]:
            found.append(f"{seen['tables']} tables scroll")
        if seen["first_code"] is not None and seen["first_code"] < SIZES[0][1]:
            found.append("code on the first screen")
        if seen["before"] > LINES_BEFORE:
            found.append(f"{seen['before']} lines of code before the first result")
        if seen["screens"] > LONGEST_SCREENS and not page.startswith(LONGER):
            found.append(f"{seen['screens']:.1f} screens long")
    elif chapter and seen["maths"]:
        found.append(f"{seen['maths']} equations are wider than the page")
    return found


def look(folder: Path, parts: list[str]) -> tuple[dict[str, Any], list[str]]:
    """Measures of every page and view, and what is at fault."""
    from axe_core_python.sync_playwright import Axe
    from playwright.sync_api import sync_playwright

    script = Axe().axe_script
    found = [*folder.glob("book/**/*.html"), *folder.glob("notebooks/**/*.html")]
    names = sorted(path.relative_to(folder).as_posix() for path in found)
    pages = [name for name in names if not parts or any(part in name for part in parts)]
    measured: dict[str, Any] = {}
    at_fault: list[str] = []
    with sync_playwright() as play:
        chromium = play.chromium.launch(executable_path=browser(), args=["--no-sandbox"])
        for width, height in SIZES:
            for scheme in ("light", "dark"):
                context = chromium.new_context(
                    viewport={"width": width, "height": height}, color_scheme=scheme
                )
                for page in pages:
                    if scheme == "dark" and page.startswith("book/api/"):
                        continue
                    seen = view(context, folder / page, script if width == SIZES[0][0] else "")
                    measured.setdefault(page, {})[f"{width} {scheme}"] = seen
                    for fault in faults(page, width, seen):
                        at_fault.append(f"{page}, {width} px, {scheme}: {fault}")
                        print(at_fault[-1], flush=True)
                context.close()
        chromium.close()
    return measured, at_fault


def view(context: Any, path: Path, axe: str) -> dict[str, Any]:
    """One page in one window, measured; axe is the text of axe-core, empty to leave it out."""
    page = context.new_page()
    errors: list[str] = []
    outside: list[str] = []

    def told(line: Any) -> None:
        if line.type == "error":
            errors.append(line.text)

    def asked(request: Any) -> None:
        if not request.url.startswith(("file:", "data:", "blob:")):
            outside.append(request.url)

    page.on("pageerror", lambda error: errors.append(str(error).splitlines()[0]))
    page.on("console", told)
    page.on("request", asked)
    page.goto(path.as_uri())
    seen: dict[str, Any] = page.evaluate(MEASURE)
    seen["axe"] = []
    if axe:
        page.evaluate(axe)
        seen["axe"] = page.evaluate(AXE)
    seen |= {"errors": errors, "outside": outside}
    page.close()
    return seen


def main() -> int:
    """Look, print what is at fault, keep the measures."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--pages", nargs="*", default=[], help="only pages with this in their name")
    parser.add_argument("--folder", type=Path, default=ROOT / "_build/html")
    options = parser.parse_args()
    if browser() is None or find_spec("playwright") is None:
        print("no Chromium, or not in the environment that make look sets up", file=sys.stderr)
        return 2
    if not options.folder.is_dir():
        print(f"{options.folder}: no built book; run make book first", file=sys.stderr)
        return 2
    measured, at_fault = look(options.folder.resolve(), options.pages)
    if not measured:
        print(f"{options.folder}: no page with such a name", file=sys.stderr)
        return 2
    kept = ROOT / "_build/look.json"
    kept.parent.mkdir(exist_ok=True)
    kept.write_text(json.dumps(measured, indent=1) + "\n")
    print(f"{len(measured)} pages looked at, {len(at_fault)} faults; measures in {kept}")
    return int(bool(at_fault))


if __name__ == "__main__":
    raise SystemExit(main())
