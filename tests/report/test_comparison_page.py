"""What the page of a comparison promises to whoever opens it, and what is printed."""

import io
import re
from dataclasses import replace

import numpy as np
import pytest
from compared import LONG, MADE, PROBLEMS, judged, made
from page_claims import (
    HOSTILE,
    Reader,
    hovered,
    is_closed_and_its_ids_are_its_own,
    is_logarithmic,
    is_small,
    needs_nothing_from_elsewhere,
    rows,
    runs_only_our_own_scripts,
    series,
    sound_charts,
    titled,
)
from rich.console import Console

from robolaser.report.comparison import page, print_comparison
from robolaser.report.comparison.excess import rms_excess, rms_target
from robolaser.report.comparison.grouped import all_results, group_table
from robolaser.report.comparison.page import unbroken
from robolaser.report.comparison.pairwise import pairwise_matrix
from robolaser.report.comparison.plot_context import PlotContext
from robolaser.report.comparison.probable import probable_table
from robolaser.report.comparison.ranking import result_table, standing_table
from robolaser.report.comparison.rows import failure_rows, spans
from robolaser.report.digits import count, duration, manifold

COMMAND = "robolaser compare paper ur5 pymoo:rastrigin --output result"


@pytest.fixture(scope="module")
def comparisons():
    return {name: make() for name, make in MADE.items()}


@pytest.fixture(scope="module")
def standings(comparisons):
    return {name: judged(one) for name, one in comparisons.items()}


@pytest.fixture(scope="module")
def pages(comparisons, standings):
    return {name: page(one, standings[name], command=COMMAND) for name, one in comparisons.items()}


@pytest.fixture(params=MADE)
def name(request):
    return request.param


@pytest.fixture
def text(name, pages):
    return pages[name]


@pytest.fixture
def comparison(name, comparisons):
    return comparisons[name]


def said(text):
    return " ".join("".join(Reader(text).texts).split())


def by_column(table):
    return [dict(zip((column.title for column in table.columns), row, strict=True)) for row in table.rows]


def printed(comparison, standings, folder=None):
    file = io.StringIO()
    print_comparison(comparison, standings, folder, console=Console(file=file))
    return file.getvalue()


def test_the_page_needs_nothing_from_elsewhere(text):
    needs_nothing_from_elsewhere(text)
    runs_only_our_own_scripts(text)
    is_small(text)


def test_every_element_is_closed_and_every_id_its_own(text):
    is_closed_and_its_ids_are_its_own(text)


def test_every_chart_is_sound_and_says_what_it_shows(text, comparison):
    assert bool(sound_charts(text)) == any(len(run.trace.costs) for run in comparison.runs)


def test_every_algorithm_has_a_line_of_its_own_on_logarithmic_axes(pages, standings):
    shown = titled(pages["complete"])
    (family,) = standings["complete"]
    algorithms = {place.algorithm for place in family.evaluations.places}
    for title in ("Targets reached by evaluations", "Targets reached by wall time"):
        assert set(series(shown[title])) == {row["series"] for row in rows(shown[title])} == algorithms
        assert is_logarithmic(shown[title], "x")
    per_target = shown["Evaluations needed per target on paper (problem 1)"]
    assert set(series(per_target)) == algorithms
    assert is_logarithmic(per_target, "x")
    assert is_logarithmic(per_target, "y")
    assert {"series", "target", "ert"} <= hovered(per_target)


def test_algorithms_share_a_letter_where_no_test_of_the_pair_tells_them_apart(pages, standings):
    order = standings["complete"][0].evaluations
    rows = titled(pages["complete"])["Mean ranks by evaluations"]["layer"][0]["data"]["values"]
    assert [row["name"] for row in rows] == [place.algorithm for place in order.ranked]
    letters = {row["name"]: set(row["letters"]) for row in rows}
    assert any(pair.significant for pair in order.pairs)
    for pair in order.pairs:
        assert pair.significant == letters[pair.one].isdisjoint(letters[pair.other])


def test_the_answer_comes_first_then_standings_then_problems_then_how(pages, standings):
    lead = " ".join(standings["large"][0].evaluations.answer.partition(". ")[0].split())
    assert lead in said(pages["large"].partition("<main>")[0])
    headings = re.findall(r"<h2>(.*?)</h2>", pages["large"])
    parts = ("Calibration problems", "1. paper", "Problems", "Runs that failed", "What could not be run",
             "How it was measured", "To repeat this")  # fmt: skip
    assert [heading for heading in headings if heading in parts] == list(parts)


def test_many_problems_are_told_by_their_names_without_settings():
    names = [f"bbob:{function}-10:instance={i}" for function in range(1, 8) for i in range(1, 6)]
    problems = [replace(PROBLEMS[2], name=name) for name in names]
    found = made(names=("rcga", "ga"), problems=problems, seeds=2, failing="", unfinished="")
    text, ranked = page(found, judged(found)), judged(found)[0]
    context = PlotContext(found, ranked)
    assert "35 problems" in re.findall(r"<h2>(.*?)</h2>", text)
    assert len(re.findall(r"<h2>", text)) < 12
    groups = by_column(group_table(context))
    assert [row["Problems"].text for row in groups] == [f"bbob:{function}-10" for function in range(1, 8)]
    assert sum(row[name].order for row in groups for name in ("rcga", "ga")) >= len(names)
    assert len(all_results(context).rows) == 2 * len(names)
    is_small(text)


def test_every_answer_is_on_the_page(text, name, standings):
    words = said(text)
    for family in standings[name]:
        for order in (family.evaluations, family.seconds):
            assert name == "nothing" or " ".join(order.answer.split()) in words


def test_every_contestant_and_every_problem_is_named(text, comparison):
    words = said(text)
    for name, title in comparison.solvers.items():
        assert name in words
        assert title in words
    for problem in comparison.problems:
        assert problem.title in words


def test_an_unfinished_comparison_says_so_at_the_top(pages, comparisons):
    made, wanted = len(comparisons["large"].runs), comparisons["large"].wanted
    assert made < wanted
    lead = re.search(r'<p class="lead">.*?</p>', pages["large"])[0]
    assert f"{made} of {wanted} runs so far" in lead
    assert f"0 of {wanted} runs so far" in pages["nothing"]
    assert "runs so far" not in said(pages["complete"])


def test_before_the_first_run_the_page_says_what_was_asked(pages):
    words = said(pages["nothing"])
    assert "No run has finished yet." in words
    assert "Problems" in words
    assert "tcp://10.0.0.7:8786" in words


def test_failures_are_grouped_by_reason_and_name_their_seeds(comparisons, pages):
    rows = list(failure_rows(comparisons["large"]))
    assert sum(count for _, _, count, _ in rows) == len(comparisons["large"].failures)
    assert len({(name, reason) for name, reason, _, _ in rows}) == len(rows)
    words = said(pages["large"])
    for name, reason, _, where in rows:
        assert name in words
        assert reason in words
        assert where in words


def test_who_was_not_asked_is_named_with_the_reason(pages, comparisons):
    for reason in comparisons["large"].refused.values():
        assert reason in said(pages["large"])


def test_the_table_follows_the_standings(comparisons, standings):
    comparison = comparisons["large"]
    for family in standings["large"]:
        rows = by_column(standing_table(PlotContext(comparison, family), 5))
        assert [row["Algorithm"].text for row in rows] == [place.algorithm for place in family.evaluations.places]
        for row, place in zip(rows, family.evaluations.places, strict=True):
            assert list(row["Algorithm"].below) == [comparison.solvers[row["Algorithm"].text]]
            assert bool(row["Failed"].text) == bool(place.failed) if "Failed" in row else not place.failed
            if place.against_first is not None and place.against_first.p_adjusted is not None:
                said = row["Significantly worse than the first?"].text
                assert said.startswith("yes" if place.against_first.significant else "no")


def test_what_nobody_reached_is_never_cheap(comparisons, standings):
    context = PlotContext(comparisons["all_fail"], standings["all_fail"][0])
    for row in by_column(standing_table(context, 5)):
        assert row["Evaluations to the target"].text == row["Time to the target"].text == "never"
        assert row["Failed"].text
    for on in context.standings.by_problem:
        for row in result_table(context, on).rows:
            assert {cell.text for cell in row[2:-1]} == {"never"}


def test_each_pair_is_shown_from_both_sides(comparisons, standings):
    order = standings["large"][0].by_problem[0].evaluations
    matrix = [row[1:] for row in pairwise_matrix(order).rows]
    assert len(matrix) == len(order.places)
    for i, row in enumerate(matrix):
        assert row[i].lean is None
        for j, cell in enumerate(row):
            if cell.lean is not None:
                assert cell.order + matrix[j][i].order == pytest.approx(1.0)
                assert cell.lean == pytest.approx(-matrix[j][i].lean)
                assert cell.text.endswith("*") == matrix[j][i].text.endswith("*")


def test_probabilities_are_those_of_the_first_against_each_other_and_add_up(comparisons, standings):
    context = PlotContext(comparisons["complete"], standings["complete"][0])
    table = probable_table(context)
    assert [cells[0].text for cells in table.cells] == list(context.order[1:])
    assert all(sum(cell.order for cell in cells[1:]) == pytest.approx(1.0) for cells in table.cells)
    assert probable_table(PlotContext(comparisons["tiny"], standings["tiny"][0])) is None


def test_a_profile_never_falls_and_begins_with_shares_of_who_is_fastest(pages):
    data = titled(pages["complete"])["Evaluations against the fastest"]["layer"][0]["data"]["values"]
    of = {name: [row["share"] for row in data if row["series"] == name] for name in {row["series"] for row in data}}
    assert all(np.all(np.diff(shares) >= 0) for shares in of.values())
    assert sum(shares[0] for shares in of.values()) >= 100 - 1e-3


def test_the_leading_and_the_papers_algorithm_have_colours_and_the_others_are_grey(comparisons, standings):
    context = PlotContext(comparisons["complete"], standings["complete"][0])
    assert set(context.order[:5]) <= set(context.coloured)
    assert "rcga" in context.coloured
    assert len(set(context.coloured.values())) == len(context.coloured) <= 7
    colours = context.by_algorithm(context.order)["scale"]
    assert len(set(colours["range"])) == len(context.coloured) + 1
    assert sorted(context.back_to_front(context.order)) == sorted(context.order)
    assert context.back_to_front(context.order)[-1] == context.order[0]


def test_the_legend_is_in_the_order_of_the_ranking_in_every_chart(pages, standings):
    ranking = [place.algorithm for place in standings["complete"][0].evaluations.places]
    for chart in titled(pages["complete"]).values():
        names = list(series(chart))
        assert names == [name for name in ranking if name in names]


def test_names_from_data_and_contestants_stay_text():
    one = made(names=("de", LONG, "rcga"), problems=(replace(PROBLEMS[0], name=HOSTILE, title=HOSTILE),), seeds=6)
    runs = tuple(replace(run, algorithm=HOSTILE) if run.algorithm == "de" else run for run in one.runs)
    one = replace(one, solvers=dict.fromkeys((HOSTILE, LONG, "rcga"), HOSTILE), runs=runs)
    text = page(one, judged(one), command=HOSTILE)
    runs_only_our_own_scripts(text)
    read = Reader(text)
    assert "<script>alert" in "".join(read.texts)
    assert not read.open
    assert len(set(read.ids)) == len(read.ids)


def test_the_same_comparison_gives_the_same_page(comparisons, standings, pages):
    assert page(comparisons["pair"], standings["pair"], command=COMMAND) == pages["pair"]


def test_prices_are_written_as_people_read_them():
    assert [count(n) for n in (7.0, 999.4, 12_345.6, 880_123.0, np.inf)] == ["7", "999", "12,300", "880,000", "never"]
    assert [duration(s) for s in (2e-5, 0.0213, 1.5, 60.0, 250.0, 7200.0)] == [
        "20 µs", "21.3 ms", "1.5 s", "60 s", "4.17 min", "2 h"
    ]  # fmt: skip
    assert [manifold(r) for r in (1.04, 9.94, 9.96, 104.0, 2779.0)] == ["1.0", "9.9", "10", "100", "2,800"]


def test_qualities_are_said_as_an_rms():
    assert rms_excess(0.0) == rms_excess(1e-9) == "best"
    assert rms_excess(0.0201) == "+1 %"
    assert rms_excess(15.0) == "4.0 times"
    assert rms_excess(np.inf) == "nothing found"
    assert rms_target(1e-2) == "0.5 %"


def test_seeds_are_counted_in_spans():
    assert spans([3, 1, 2, 7, 9, 10]) == "1 to 3, 7, 9, 10"
    assert spans([4]) == "4"


def test_numbers_and_their_signs_stay_on_a_line():
    assert unbroken("in 93 % (81 to 97 %), p < 0.0001") == "in 93\u00a0% (81 to 97\u00a0%), p\u00a0<\u00a00.0001"


def test_what_is_printed_is_short_plain_and_says_where_to_look(name, comparison, standings, tmp_path):
    text = printed(comparison, standings[name], tmp_path)
    assert "\x1b" not in text
    assert len(text.splitlines()) < 40
    assert str(tmp_path / "report.html") in text
    if len(comparison.runs) < comparison.wanted:
        assert "runs so far" in text


def test_names_are_not_taken_for_markup_when_printed():
    one = made(names=("de", "rcga"), problems=PROBLEMS[:1], seeds=5)
    runs = tuple(replace(run, algorithm="[bold]x[/bold]") if run.algorithm == "de" else run for run in one.runs)
    one = replace(one, solvers={"[bold]x[/bold]": "", "rcga": ""}, runs=runs)
    assert "[bold]x[/bold]" in printed(one, judged(one))
