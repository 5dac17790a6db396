"""What some code depends on: its imports wherever they stand, and modules named as text."""

import ast

import pytest

from mobility_imu.reproduction.imports import PACKAGE, imported, named

PLACES = """
try:
    import mobility_imu.a
except OSError:
    import mobility_imu.b
else:
    import mobility_imu.c
finally:
    import mobility_imu.d
with open("x") as f:
    for k in f:
        while k:
            if k:
                pass
            elif f:
                import mobility_imu.e
            else:
                from mobility_imu.f import g
match k:
    case 1:
        import mobility_imu.h
class One:
    async def two(self):
        async with self:
            import mobility_imu.i, numpy
"""


def test_imports_are_found_wherever_they_stand():
    names = {"f.g", *"abcdefhi"}
    assert imported(PLACES) == {f"mobility_imu.{name}" for name in names}


@pytest.mark.parametrize("quote", "\"'")
def test_modules_named_as_text_are_found(quote):
    assert named(f"x = {quote}mobility_imu.walker.steps{quote}") == {"mobility_imu.walker.steps"}
    assert not named(f"x = {quote}mobility_imu walker{quote}  # mobility_imu.walker.steps")


def test_the_package_gives_what_a_walk_over_every_node_gives():
    for path in sorted(PACKAGE.rglob("*.py"))[::8]:
        nodes = list(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))
        whole = {a.name for n in nodes if isinstance(n, ast.Import) for a in n.names}
        for n in nodes:
            if isinstance(n, ast.ImportFrom) and n.module:
                whole |= {n.module, *(f"{n.module}.{a.name}" for a in n.names)}
        assert imported(path.read_text(encoding="utf-8")) == {
            n for n in whole if n.split(".")[0] == PACKAGE.name
        }
