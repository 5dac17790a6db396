"""Checksums in the table of ``data/README.md``: compared, or written anew.

    python checks/data_table.py [--write]

Each file under ``data/`` has one row; a row without a file, a file without a row, two rows of one
file or another checksum ends with exit code 1. With ``--write`` the checksums are set to those of
the files.
"""

from __future__ import annotations

import argparse
import hashlib
import re
import sys
from collections import Counter
from pathlib import Path

DATA = Path(__file__).resolve().parents[1] / "data"
ROW = re.compile(r"^\| `([^`]+)` \|(.*)\| `([0-9a-f]{64}|)` \|$", re.MULTILINE)


def files(folder: Path) -> dict[str, str]:
    """Files of a folder, but for its READMEs, with their SHA-256."""
    found = sorted(path for path in folder.rglob("*") if path.is_file())
    return {
        path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in found
        if path.name != "README.md"
    }


def rows(page: str) -> dict[str, str]:
    """Files that a page lists, with the checksums that it states."""
    return {name: checksum for name, _, checksum in ROW.findall(page)}


def faults(page: str, folder: Path) -> list[str]:
    """What is wrong with a page's table."""
    listed, there = rows(page), files(folder)
    count = Counter(name for name, _, _ in ROW.findall(page))
    return [
        *(f"{name}: listed twice" for name, times in count.items() if times > 1),
        *(f"{name}: not in the table" for name in there if name not in listed),
        *(f"{name}: no such file" for name in listed if name not in there),
        *(
            f"{name}: another checksum (python checks/data_table.py --write)"
            for name, checksum in listed.items()
            if there.get(name, checksum) != checksum
        ),
    ]


def renewed(page: str, folder: Path) -> str:
    """The page with the files' checksums."""
    there = files(folder)
    return ROW.sub(
        lambda row: f"| `{row[1]}` |{row[2]}| `{there.get(row[1], row[3])}` |",
        page,
    )


def main() -> int:
    """Command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--write", action="store_true", help="set the checksums")
    readme = DATA / "README.md"
    page = readme.read_text(encoding="utf-8")
    if parser.parse_args().write:
        page = renewed(page, DATA)
        readme.write_text(page, encoding="utf-8")
    found = faults(page, DATA)
    print("\n".join(found) or f"{len(rows(page))} files, all checksums right")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
