"""Each record is of the code that stands here: what quotes a number of it is not out of date."""

import ast

import pytest

from mobility_imu.reproduction import recorded


@pytest.mark.parametrize("name", recorded.STUDIES)
def test_a_record_is_of_this_code(name):
    assert not recorded.is_stale(name), f"python -m mobility_imu.reproduction.recorded {name}"


COMPUTES = """
def speed(radius, rates):
    total = 0.0
    for rate in rates:
        total += radius * rate
    return total
"""


def digest(code):
    return sorted(recorded._dumped(ast.parse(code), refuses=False))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("total = 0.0", '"""Speed, m/s."""\n    total = 0.0'),
        ("total = 0.0", "from math import pi\n    total = 0.0"),
        ("total = 0.0", "if radius < 0:\n        raise InputError('radius')\n    total = 0.0"),
        (
            "total = 0.0",
            "_check_positive(radius)\n    expect('rates', rates, list)\n    total = 0.0",
        ),
        (
            "total = 0.0",
            "for one in rates:\n        if one < 0:\n            raise InputError\n    total = 0.0",
        ),
        (
            "    return total",
            "    if total > 9:\n        raise InputError(f'{total}')\n    return total",
        ),
        (
            "    return total",
            "    try:\n        return total\n    except ValueError:\n        raise InputError",
        ),
    ],
)
def test_another_check_or_text_makes_no_record_stale(old, new):
    assert digest(COMPUTES.replace(old, new)) == digest(COMPUTES)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("total = 0.0", "total = 1.0"),
        ("radius * rate", "radius + rate"),
        ("total = 0.0", "if radius < 0:\n        return 0.0\n    total = 0.0"),
        ("total = 0.0", "if radius < 0:\n        radius = 0.0\n    total = 0.0"),
        ("total = 0.0", "radius = check(radius)\n    total = 0.0"),
        ("total = 0.0", "check_fields(rates)\n    total = 0.0"),
        (
            "total = 0.0",
            "if (radius := radius / 2) < 0:\n        raise InputError\n    total = 0.0",
        ),
        ("for rate in rates", "for rate in rates[1:]"),
        (
            "    return total",
            "    try:\n        return total\n    except ValueError:\n        return 0.0",
        ),
        (
            "    return total",
            "    try:\n        pass\n    except ValueError:\n        raise InputError\n"
            "    finally:\n        total = 0.0\n    return total",
        ),
    ],
)
def test_whatever_computes_otherwise_makes_a_record_stale(old, new):
    assert digest(COMPUTES.replace(old, new)) != digest(COMPUTES)


def test_a_mistake_that_passes_is_not_one_that_is_refused():
    """An error that is caught and raised anew ends a study; one that is passed over does not."""
    caught = (
        "def f(x):\n    try:\n        x = g(x)\n    except ValueError:\n        {}\n    return x"
    )
    assert digest(caught.format("raise InputError")) != digest(caught.format("pass"))


def test_checks_count_where_a_refusal_may_be_a_result():
    checked = COMPUTES.replace(
        "total = 0.0", "if radius < 0:\n        raise InputError\n    total = 0.0"
    )
    one, other = (recorded._dumped(ast.parse(code), refuses=True) for code in (COMPUTES, checked))
    assert list(one) != list(other)


CAUGHT = ("InputError", "ValueError", "Exception")
GOES_ON = {
    ("_compiled.py", "return False"): "whether machine code is there already",
    ("files.py", "return None"): "where a file may be written; a study writes none",
    ("frames.py", "return 'a value too long to show'"): "the words of a message",
    ("filters.py", "window = 0"): "refused three lines below",
}
"""Handlers of errors that do not raise, by file and last line; why no refusal is a result there."""


def handlers(path):
    """Last line of each handler that a refusal may end in, unless it raises."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ExceptHandler):
            caught = ast.unparse(node.type) if node.type else "Exception"
            if any(kind in caught for kind in CAUGHT) and not isinstance(node.body[-1], ast.Raise):
                yield path.name, ast.unparse(node.body[-1])


@pytest.mark.parametrize(
    "name", [name for name, one in recorded.STUDIES.items() if not one.refuses]
)
def test_no_refusal_is_a_result_where_checks_do_not_count(name):
    files = recorded._files(recorded.STUDIES[name])
    assert {found for path in files for found in handlers(path)} <= GOES_ON.keys()
