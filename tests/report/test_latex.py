import re

from compared import all_fail, large

from robolaser.benchmark.standings.ranking import standings
from robolaser.report.comparison.page import document
from robolaser.report.document import Column, Table
from robolaser.report.latex import latex, latex_tables


def written(result):
    return latex_tables(document(result, [standings(result, family) for family in result.families]))


def test_every_algorithm_has_a_row_on_every_problem_and_in_its_ranking():
    result = large()
    rows = re.findall(r"^(.*?) & .* \\\\$", written(result), re.MULTILINE)
    assert {"rcga", "de", "paper", "rastrigin"} < set(rows)
    assert rows.count("rcga") == len(result.families) + len(result.problems)


def test_signs_of_the_language_are_escaped():
    table = latex("100 %", Table([Column("A"), Column("B")], [("a_b", "1 %"), ("x|y", "10⁻²")]))
    assert r"\caption{100 \%.}" in table
    assert r"a\_b & 1 \% \\" in table
    assert r"10\textsuperscript{-2}" in table


def test_runs_that_all_failed_have_no_numbers():
    assert not re.search(r"\b(nan|inf)\b", written(all_fail()))
