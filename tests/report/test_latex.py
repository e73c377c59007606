import re

from compared import all_fail, large, nothing

from robolaser.benchmark.standings.ranking import standings
from robolaser.report.comparison.latex import latex, latex_tables

ROWS = [("a_b", "1 %"), ("x|y", "10⁻²")]


def written(result):
    return latex_tables(result, [standings(result, family) for family in result.families])


def test_every_algorithm_has_a_row_and_every_problem_two():
    rows = re.findall(r"^(.*?) & .* \\\\$", written(large()), re.MULTILINE)
    assert {"rcga", "de", "paper", "rastrigin"} < set(rows)
    assert rows.count("paper") == 2


def test_signs_of_the_language_are_escaped():
    assert r"a\_b & 1 \% \\" in latex("100 %", ("A", "B"), ROWS)
    assert r"10\textsuperscript{-2}" in latex("", ("A", "B"), ROWS)


def test_runs_that_all_failed_have_no_numbers_and_without_runs_there_is_no_table():
    assert not re.search(r"\b(nan|inf)\b", written(all_fail()))
    assert not written(nothing())
