"""Mutations: each module of the estimators has tests that judge them."""

import importlib.util
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


def loaded():
    spec = importlib.util.spec_from_file_location("mutations", ROOT / "checks" / "mutations.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


mutations = loaded()


@pytest.mark.parametrize("module", mutations.modules(), ids=str)
def test_each_module_has_tests(module):
    own, *files = mutations.tests_of(module)
    assert own == str(module) and files
    assert all((ROOT / file).is_file() for file in files)


def test_each_name_beside_is_a_module_and_a_file_of_tests():
    known = {f"{path.parent.name}/{path.stem}" for path in mutations.modules()}
    assert set(mutations.BESIDE) <= known
    for module, names in mutations.BESIDE.items():
        folder = module.split("/")[0]
        for name in names:
            places = [ROOT / "tests" / f"{name}.py", ROOT / "tests" / folder / f"{name}.py"]
            assert any(place.is_file() for place in places), (module, name)
