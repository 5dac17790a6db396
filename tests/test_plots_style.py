"""The look of figures and of tables."""

import numpy as np
import pandas as pd
import pytest

from mobility_imu.plots.style import show_table, use_style


def test_tables_of_chapters():
    """Numbers of one length, NaN told, and the same page from the same table each time."""
    table = pd.DataFrame({"of": ["walk"], "sd": [1 / 3], "gap": [np.nan]}, index=["row"])
    html = show_table(table, "walker-sd", 2).to_html()
    assert html == show_table(table, "walker-sd", 2).to_html()
    assert (
        ">0.33<" in html
        and ">–<" in html
        and "T_walker-sd" in html
        and "row" not in html.split(">")
    )
    with_all = show_table(table, "a", index=True, caption="Errors", missing="none").to_html()
    assert all(f">{part}<" in with_all for part in ("row", "Errors", "none", "0.333"))


def test_the_style_as_a_cells_last_line_shows_nothing(capsys):
    DisplayFormatter = pytest.importorskip("IPython.core.formatters").DisplayFormatter

    with use_style() as style:
        assert DisplayFormatter().format(style) == ({}, {})
    assert capsys.readouterr().out == ""
