"""Tables of the chapters, and figures that are tables of numbers."""

import re

import numpy as np
import pandas as pd

from mobility_imu.plots.scooter_driving import plot_effects
from mobility_imu.plots.scorecard import (
    plot_real_errors,
    plot_totals,
    show_levels,
    show_real_rows,
    show_rows,
)
from mobility_imu.plots.tables import show_statements, show_static_table
from mobility_imu.reproduction.claims import check
from mobility_imu.reproduction.real_level_claims import level_table
from mobility_imu.reproduction.scooter.static_table import CELL_TOLERANCE_DEG, compare_static_table
from mobility_imu.reproduction.scooter.table_claims import table_claims
from mobility_imu.reproduction.scorecard import scorecard, to_records, totals


def cells(html):
    return re.findall(r'<td[^>]*class="data[^"]*"[^>]*>([^<]*)</td>', html)


def test_statements_show_published_and_ours_with_a_verdict_in_words():
    claims = [c for c in table_claims()[100:] if c.unit in ("%", "1")]
    shown = cells(show_statements([check(c) for c in claims], "text").to_html())
    assert len(shown) == 7 * len(claims)
    assert shown.count("agrees") + shown.count("differs") == len(claims)
    row = next(k for k, text in enumerate(shown) if "exactly 40 deg" in text)
    assert shown[row].endswith("(%)")
    assert shown[row + 1 : row + 7] == ["section 3.2", "11.3", "", "12.5", "0.05", "differs"]


def test_table_1_is_laid_out_as_in_the_paper():
    comparison = compare_static_table()
    single = show_static_table(
        comparison, "single", "s", caption="deg", tolerance_deg=CELL_TOLERANCE_DEG
    )
    shown = cells(single.to_html())
    assert len(shown) == 10 * 7
    assert shown[14:17] == ["upward", "published", "9.80 ± 9.30"]
    assert shown[21:24] == ["", "geometry", "9.92 ± 8.37"]
    assert sum("≠" in text for text in shown) == 25 - 18
    dual = cells(show_static_table(comparison, "dual", "d", caption="deg").to_html())
    assert len(dual) == 5 * 6 and not any("≠" in text for text in dual)


def test_errors_by_condition_are_written_into_their_grid():
    import matplotlib.pyplot as plt

    grid = {
        "everything": {"steering": {"straight": 8.25, "curves": 11.0}},
        "nothing": {"steering": {"straight": 0.02, "curves": 0.0}},
    }
    both = {row: of | {"throttle": of["steering"]} for row, of in grid.items()}
    figure = plot_effects(both)
    written = [text.get_text() for text in figure.axes[0].texts]
    assert written == ["8.2", "11.0", "0.0", "0.0"]
    assert [t.get_text() for t in figure.axes[0].get_yticklabels()] == list(grid)
    plt.close(figure)


def test_rows_of_the_scorecard_keep_published_and_reference_apart():
    claims = [c for c in table_claims() if c.where in ("section 3.2", "section 3.1")]
    rows = pd.DataFrame(to_records([check(c) for c in claims]))
    shown = np.reshape(cells(show_rows(rows, "rows", last="verdict").to_html()), (-1, 6))
    assert len(shown) == len(claims)
    for line, claim in zip(shown, claims, strict=True):
        assert line[0].startswith(f"{claim.where}: {claim.what}")
        assert (line[1] != "–") == bool(claim.published) and (line[2] == "–") == (line[1] != "–")
        assert line[5] in ("agrees", "differs")


def test_totals_and_real_errors_are_drawn_row_by_row():
    import matplotlib.pyplot as plt

    outcomes = scorecard()
    counted = totals(outcomes)
    figure = plot_totals(counted)
    written = sum(int(text.get_text()) for ax in figure.axes for text in ax.texts)
    assert written == len(outcomes)
    plt.close(figure)

    table = pd.DataFrame(to_records(outcomes))
    real = table[table["basis"] == "tried on independent real recordings"]
    figure = plot_real_errors(real)
    dots = [line for line in figure.axes[0].lines if line.get_marker() == "o"]
    filled = sum(line.get_markerfacecolor() != "white" for line in dots)
    beyond = [float(line.get_xdata()[0]) > 2 for line in dots]
    assert len(dots) > 5 and filled == beyond.count(False)
    assert len(cells(show_real_rows(real, "real").to_html())) == 8 * len(real)
    assert len(cells(show_levels(level_table(), "levels").to_html())) == 5 * len(level_table())
    plt.close(figure)
