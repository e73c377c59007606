import re

import pytest
from compared import LONG, all_fail, large, nothing

from robolaser.benchmark.standings import standings
from robolaser.commands.compare import labels_of
from robolaser.errors import UsageError
from robolaser.report.comparison.paper_tables import latex, markdown, paper_tables

ROWS = [("a_b", "1 %"), ("x|y", "10⁻²")]


def written(result, form):
    return paper_tables(result, [standings(result, family) for family in result.families], form)


def test_both_languages_have_the_same_rows():
    result = large()
    rows = [row for row in written(result, "markdown").splitlines() if row.startswith("|") and "---" not in row]
    assert len(re.findall(r" \\\\$", written(result, "latex"), re.MULTILINE)) == len(rows)


def test_signs_of_the_language_are_escaped():
    assert r"a\_b & 1 \% \\" in latex("100 %", ("A", "B"), ROWS)
    assert r"10\textsuperscript{-2}" in latex("", ("A", "B"), ROWS)
    assert r"| x\|y | 10⁻² |" in markdown("", ("A", "B"), ROWS)


def test_a_label_stands_wherever_a_name_stood():
    result = large()
    labels = labels_of(["rcga=Ours", f"{LONG}=GA = both"], list(result.solvers))
    text = written(result.labelled(labels), "markdown")
    assert "Ours" in text
    assert "GA = both" in text
    assert "rcga" not in text
    assert LONG not in text


@pytest.mark.parametrize("typed", [["nobody=x"], ["rcga="], ["rcga=ga"], ["rcga"]])
def test_a_label_that_names_nobody_or_two_is_refused(typed):
    with pytest.raises(UsageError, match="--label"):
        labels_of(typed, ["rcga", "ga"])


def test_runs_that_all_failed_have_no_numbers_and_without_runs_there_is_no_table():
    assert not re.search(r"\b(nan|inf)\b", written(all_fail(), "latex"))
    assert not written(nothing(), "markdown")
