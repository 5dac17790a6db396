"""Source of the package as a chapter shows it."""

import ast
import inspect

import pytest

from mobility_imu.plots.source import WIDEST, show_source, source_of
from mobility_imu.walker import eskf

SHOWN = (
    eskf.predict,
    eskf.process_noise,
    eskf.update,
    eskf.zero_updates,
    eskf.smooth,
    eskf.back_over_update,
    eskf.back_over_step,
)


@pytest.mark.parametrize("function", SHOWN, ids=lambda f: f.__name__)
def test_the_same_code_is_shown_without_docstring_and_in_lines_that_fit(function):
    text = source_of(function)
    assert max(map(len, text.splitlines())) <= WIDEST
    whole = ast.parse(inspect.getsource(function)).body[0]
    del whole.body[0]
    assert ast.dump(ast.parse(text).body[0]) == ast.dump(whole)


def test_several_functions_stand_in_one_block():
    pytest.importorskip("IPython")
    block = show_source(eskf.update, eskf.smooth).data
    assert block.startswith("```python\ndef update(") and "\n\n\ndef smooth(" in block
    assert block.endswith("\n```")
