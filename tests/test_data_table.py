"""The table of ``data/README.md``: every file with its checksum."""

import importlib.util
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="module")
def table():
    spec = importlib.util.spec_from_file_location("data_table", ROOT / "checks" / "data_table.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_every_file_is_listed_with_its_checksum(table):
    page = (ROOT / "data" / "README.md").read_text()
    assert len(table.rows(page)) > 50
    assert table.faults(page, ROOT / "data") == []


def test_what_is_wrong_is_told_and_set_right(table, tmp_path):
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "a.csv").write_text("1\n")
    (tmp_path / "README.md").write_text("")
    good = table.files(tmp_path)["sub/a.csv"]
    page = f"| `sub/a.csv` | ours | CC BY 4.0 | none | `{'0' * 64}` |\n"
    assert table.faults(page, tmp_path) == [
        "sub/a.csv: another checksum (python checks/data_table.py --write)"
    ]
    assert table.faults(table.renewed(page, tmp_path), tmp_path) == []
    assert good in table.renewed(page, tmp_path)
    (tmp_path / "b.csv").write_text("2\n")
    assert table.faults(page.replace("a.csv", "c.csv"), tmp_path) == [
        "b.csv: not in the table",
        "sub/a.csv: not in the table",
        "sub/c.csv: no such file",
    ]
    right = table.renewed(page, tmp_path)
    assert "sub/a.csv: listed twice" in table.faults(right + right, tmp_path)
