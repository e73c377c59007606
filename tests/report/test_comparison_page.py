"""The page of a comparison says what was found, and needs nothing from elsewhere."""

import re

import numpy as np
import pytest
from compared import MADE, all_fail, judged
from page_claims import is_logarithmic, is_whole, rows, said, sound_charts, titled

import robolaser
from robolaser.report.comparison.page import document
from robolaser.report.comparison.tables import by_reason, standing_table
from robolaser.report.console import printed
from robolaser.report.page import render

COMMAND = "robolaser compare paper ur5 pymoo:rastrigin --output result"


@pytest.fixture(scope="module")
def comparisons():
    return {name: make() for name, make in MADE.items()}


@pytest.fixture(scope="module")
def standings(comparisons):
    return {name: judged(one) for name, one in comparisons.items()}


@pytest.fixture(scope="module")
def pages(comparisons, standings):
    return {name: render(document(one, standings[name]), COMMAND) for name, one in comparisons.items()}


@pytest.fixture(params=MADE)
def name(request):
    return request.param


@pytest.fixture
def text(name, pages):
    return pages[name]


@pytest.fixture
def comparison(name, comparisons):
    return comparisons[name]


def test_the_page_is_whole(text):
    is_whole(text)


def test_every_chart_is_sound_and_says_what_it_shows(text, comparison):
    assert bool(sound_charts(text)) == any(len(run.trace.costs) for run in comparison.runs)


def test_every_algorithm_has_a_line_on_a_logarithmic_axis(pages, standings):
    shown = titled(pages["complete"])
    (family,) = standings["complete"]
    chart = shown["Targets reached by evaluations: calibration problems"]
    assert {row["series"] for row in rows(chart)} == {place.algorithm for place in family.order.places}
    assert is_logarithmic(chart, "x")


def test_what_half_of_the_runs_attain_of_two_objectives_is_drawn():
    result = robolaser.compare(["pymoo:zdt1-5"], ["NSGA2", "random"], seeds=3, budget=400)
    page = render(document(result, judged(result)))
    assert sound_charts(page)
    found = rows(titled(page)["Half of the runs attain this on pymoo:zdt1-5"])
    assert {row["series"] for row in found} == {"NSGA2", "random"}
    first, second = np.array([(row["first"], row["second"]) for row in found if row["series"] == "NSGA2"]).T
    assert (np.diff(first) > 0).all()
    assert (np.diff(second) < 0).all()


def test_the_answer_comes_first_then_standings_then_problems_then_how(pages, standings):
    lead = " ".join(standings["large"][0].order.answer.partition(". ")[0].split())
    assert lead in said(pages["large"].partition("<main>")[0])
    headings = re.findall(r"<h2>(.*?)</h2>", pages["large"])
    parts = ("Calibration problems", "paper", "Problems", "Runs that failed", "What could not be run",
             "How it was measured", "To repeat this")  # fmt: skip
    assert [heading for heading in headings if heading in parts] == list(parts)


def test_every_algorithm_and_problem_is_named(name, text, comparison):
    words = said(text)
    for one in (*comparison.solvers, *(problem.name for problem in comparison.problems)):
        assert one in words or not comparison.runs


def test_the_target_is_stated_with_the_cost_that_it_is(pages):
    assert "J of at most 6.565 × 10⁻⁶ m², an RMS within 0.5 % of the lowest known" in said(pages["large"])
    assert "a cost of at most 0.01, 0.01 above the lowest known, 0 by theory" in said(pages["large"])


def test_who_never_reached_the_target_has_no_ratio_and_nobody_has_one_to_it():
    comparison = all_fail()
    (family,) = judged(comparison)
    table = standing_table(comparison, family, {}, 4)
    at = [column.title for column in table.columns].index("Evaluations to the target (ERT)")
    assert {row[at].text for row in table.rows} == {"never"}


def test_failures_and_refusals_are_named_with_their_reasons(pages, comparisons):
    words = said(pages["large"])
    assert "not done within 20 s" in words
    assert "the cost is not a sum of squares" in words
    failures = [(run.algorithm, run.reason, run.problem) for run in comparisons["large"].failures]
    counted = sum(count for _, _, count, _ in by_reason(failures))
    assert counted == len(comparisons["large"].failures)


def test_the_terminal_says_the_answer_and_the_target(name, comparison, standings):
    text = " ".join(printed(document(comparison, standings[name], brief=True)).split())
    if comparison.runs:
        assert "J of at most" in text or "not known yet" in text
    if name == "large":
        assert "knows its budget" in text
