"""What a page asks of its reader: cells, lines of code, sentences, terms. Used by the tests and by

    python book/reading.py [NOTEBOOK ...]

which prints each place that is over a limit.
"""

from __future__ import annotations

import json
import re
import sys
from functools import cache
from pathlib import Path
from statistics import median
from typing import Any, NamedTuple

ROOT = Path(__file__).resolve().parents[1]
LONGEST_CELL, LONGEST_LINE = 25, 84
MEDIAN_CELL, NINE_OF_TEN = 6, 20
WORDS_A_LINE = 12
LONGEST_SENTENCE, MEDIAN_SENTENCE = 35, 18
ORDINARY = {
    "range",
    "gain",
    "track",
    "slip",
    "creep",
    "resolution",
    "drift",
    "prior",
    "consistency",
}
"""Terms that are everyday words too: not each of their uses means the term."""
DROPPED = (
    r"\bis said\b", r"\bare said\b", r"\bwas said\b", r"\bby accident\b",
    r"\bstretch(es)?\b", r"\bdoubts?\b", r"\bknows? better\b", r"\bwitness\b",
    r"\bcourage\b", r"\bcaution\b", r"\bnobody knows\b", r"\bhangs? on\b", r"\btaken for granted\b",
    r"\bnowhere else\b", r"\bthe issue\b", r"\bsubtle\b",
)  # fmt: skip
"""Words and phrases that were read twice, or say less than a plain one."""
ABBREVIATED = re.compile(
    r"\b(e\.g|i\.e|cf|vs|et al|eq|eqs|fig|figs|no|p|pp|sec|ch|approx|dr)\.", re.I
)


class Cell(NamedTuple):
    """A cell of a notebook: its number, kind, text, tags and caption."""

    number: int
    kind: str
    text: str
    tags: tuple[str, ...]
    caption: str
    in_solution: bool

    @property
    def is_shown_code(self) -> bool:
        folded = self.in_solution or any(t.startswith(("hide", "remove")) for t in self.tags)
        return self.kind == "code" and not folded and bool(self.text.strip())


@cache
def cells(path: Path) -> tuple[Cell, ...]:
    """All cells of a notebook."""
    found: list[Cell] = []
    inside = False  # a solution opens with a click
    for k, cell in enumerate(json.loads(path.read_text())["cells"]):
        meta: dict[str, Any] = cell["metadata"]
        caption = meta.get("mystnb", {}).get("figure", {}).get("caption", "")
        tags = tuple(meta.get("tags", ()))
        text = "".join(cell["source"])
        found.append(Cell(k, cell["cell_type"], text, tags, caption, inside))
        for start, _ in re.findall(r"\{solution-(?:(start)|(end))\}", text):
            inside = bool(start)
    return tuple(found)


def plain(text: str) -> str:
    """Prose without mark-up: a formula is one word, code and tables are left out."""
    text = re.sub(r"^(```+|~~~+)[^\n]*\n.*?^\1\s*$", "", text, flags=re.S | re.M)
    text = re.sub(r"\$\$.*?\$\$(\s*\([\w-]+\))?", " ", text, flags=re.S)
    text = re.sub(r"\\begin\{(\w+\*?)\}.*?\\end\{\1\}", " ", text, flags=re.S)
    text = re.sub(r"\$[^$]+\$", "x", text)
    text = re.sub(
        r"`[^`\n]*<([^`\n]*)>`", "name", re.sub(r"\{term\}`([^`<]*?)\s*(<[^>`]*>)?`", r"\1", text)
    )
    text = re.sub(r"(\{[\w:]+\})?`[^`]*`", "name", text)
    text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", text)
    kept = [
        line
        for line in text.splitlines()
        if not re.match(r"\s*(#|\||:::|:\w[\w-]*:|\([\w-]+\)=|<!--|<)", line)
    ]
    return re.sub(r"[*_]{1,2}(?=\S)(.+?)(?<=\S)[*_]{1,2}", r"\1", "\n".join(kept), flags=re.S)


def sentences(text: str) -> list[str]:
    """The sentences of a text, each item of a list by itself."""
    found: list[str] = []
    for block in re.split(r"\n\s*\n|\n(?=\s*(?:[-*+]|\d+\.)\s)", plain(text)):
        block = re.sub(r"^\s*(?:[-*+]|\d+\.)\s+", "", " ".join(block.split()))
        block = ABBREVIATED.sub(lambda m: m[0][:-1], block)
        for part in re.split(r"(?<=[.!?])[\"”')]*\s+(?=[\"“'(]*[A-Z0-9x−]|\(\w\))", block):
            if re.search(r"\w", part):
                found.append(part.strip())
    return found


def words(sentence: str) -> int:
    """How many words a sentence has; a number with its unit is one."""
    joined = re.sub(
        r"(?<=\d) (?=(m|s|cm|mm|Hz|deg|rad|min|ms|kg|g|mg|%|km|m/s|deg/s)\b)", "", sentence
    )
    return len([w for w in joined.split() if re.search(r"\w", w)])


@cache
def terms() -> tuple[str, ...]:
    """The words that the glossary explains, longest first."""
    text = (ROOT / "book/glossary.md").read_text().split(":::{glossary}")[1].split("\n:::")[0]
    found = [line for line in text.splitlines() if line and not line.startswith(" ")]
    return tuple(sorted(found, key=len, reverse=True))


def used(term: str, text: str) -> bool:
    """Whether a text uses a term, in singular or plural."""
    return bool(re.search(rf"(?<![\w-]){re.escape(term)}(s|es)?(?![\w-])", text, re.I))


def linked(term: str, text: str) -> bool:
    """Whether a text links a term to the glossary."""
    name = re.escape(term)
    return bool(re.search(rf"\{{term\}}`(?:{name}|[^`<]*<{name}>)`", text, re.I))


def too_long(path: Path) -> list[str]:
    """Sentences of a notebook that are over the limit, and their median if it is."""
    found, sizes = [], []
    for cell in cells(path):
        text = cell.text if cell.kind == "markdown" else cell.caption
        for sentence in sentences(text):
            sizes.append(words(sentence))
            if sizes[-1] > LONGEST_SENTENCE:
                found.append(f"cell {cell.number}: {sizes[-1]} words: {sentence}")
    if sizes and median(sizes) > MEDIAN_SENTENCE:
        found.append(f"the median sentence has {median(sizes)} words")
    return found


def dropped(text: str) -> list[str]:
    """Phrases of a text that the house does not use."""
    prose = plain(text)
    return [
        " ".join(prose[max(0, m.start() - 30) : m.end() + 30].split())
        for pattern in DROPPED
        for m in re.finditer(pattern, prose, re.I)
    ]


def unlinked(path: Path) -> list[str]:
    """Terms that a chapter uses without a link at the first use."""
    # A whole chapter is long: what counts is the first cell of prose that uses the word.
    found = []
    # The text of a link says where it leads: to a page that explains the word.
    prose = [
        (cell, plain(re.sub(r"\[[^\]]*\]\([^)]*\)", "", cell.text)))
        for cell in cells(path)
        if cell.kind == "markdown"
    ]
    for term in terms():
        longer = [t for t in terms() if term in t and t != term]
        for cell, text in prose:
            if linked(term, cell.text):
                break
            for other in longer:
                text = re.sub(re.escape(other), "", text, flags=re.I)
            if used(term, text):
                if term not in ORDINARY:
                    found.append(f"cell {cell.number}: {term}")
                break
    return found


def heavy(path: Path) -> list[str]:
    """What a page's shown code asks too much: cells, lines, imports, asserts, words beside it."""
    found, lines = [], []
    shown = [c for c in cells(path) if c.is_shown_code]
    for cell in shown:
        code = cell.text.splitlines()
        lines.append(len(code))
        if len(code) > LONGEST_CELL:
            found.append(f"cell {cell.number}: {len(code)} lines of code")
        widest = max(map(len, code))
        if widest > LONGEST_LINE:
            found.append(f"cell {cell.number}: a line of {widest} characters")
        if any(re.match(r"\s*assert\b|np\.testing\.", line) for line in code):
            found.append(f"cell {cell.number}: a check among the method")
        if sum(bool(re.match(r"(import|from) ", line)) for line in code) > 0:
            found.append(f"cell {cell.number}: imports")
    for cell in cells(path):
        if cell.kind == "code" and not cell.is_shown_code:
            widest = max(map(len, cell.text.splitlines()), default=0)
            if widest > 100:
                found.append(f"cell {cell.number}: a folded line of {widest} characters")
    if lines:
        prose = sum(
            words(s) for c in cells(path) if c.kind == "markdown" for s in sentences(c.text)
        )
        ordered = sorted(lines)
        if median(lines) > MEDIAN_CELL:
            found.append(f"the median cell has {median(lines)} lines")
        if ordered[int(0.9 * (len(ordered) - 1))] > NINE_OF_TEN:
            found.append(f"nine of ten cells: up to {ordered[int(0.9 * (len(ordered) - 1))]} lines")
        if prose < WORDS_A_LINE * sum(lines):
            found.append(f"{prose / sum(lines):.1f} words of prose for a line of code")
    return found


def main() -> int:
    named = [Path(a).resolve() for a in sys.argv[1:]]
    pages = named or sorted((ROOT / "notebooks").rglob("*.ipynb"))
    total = 0
    for path in pages:
        spoken = "\n\n".join(c.text for c in cells(path) if c.kind == "markdown")
        findings = {
            "code": heavy(path),
            "sentences": too_long(path),
            "words": dropped(spoken),
            "terms": unlinked(path),
        }
        for kind, found in findings.items():
            total += len(found)
            for each in found:
                print(f"{path.relative_to(ROOT)}: {kind}: {each}")
    return bool(total)


if __name__ == "__main__":
    raise SystemExit(main())
