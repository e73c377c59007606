"""What every operator keeps to, whatever it does, and where it works."""

import inspect
from pathlib import Path

import numpy as np
import pymoo
import pytest
from bowl import LOWER, UPPER, Bowl, population
from pymoo.algorithms.soo.nonconvex.ga import GA
from pymoo.core.parameters import get_params
from pymoo.core.variable import Real
from pymoo.optimize import minimize

import robolaser.operators
from robolaser.operators.testing import FAILS, IGNORED, MISSING, NO_PLACE, REFUSED, SLOTS, WORKS, check_operator

FAMILY = [getattr(robolaser.operators, name) for name in robolaser.operators.__all__]
DOCS = Path(__file__).parents[2] / "docs" / "reference" / "operators.md"


def compatibility_table(found):
    """Markdown: a line for the algorithms that treat all operators alike, a column for each operator."""
    marks = {WORKS: "✓", REFUSED: "refused", FAILS: "fails", IGNORED: "ignored", NO_PLACE: "–", MISSING: "?"}
    alike = {}
    for name in found[0].algorithms:
        alike.setdefault(" | ".join(marks[each.algorithms[name][0]] for each in found), []).append(name)
    lines = [f"| | {' | '.join(each.operator for each in found)} |", "|---" * (len(found) + 1) + "|"]
    return "\n".join(lines + [f"| {', '.join(names)} | {row} |" for row, names in alike.items()])


def slot(operator):
    return next(name for base, name in SLOTS.items() if isinstance(operator, base))


@pytest.fixture(params=FAMILY, ids=lambda kind: kind.__name__)
def operator(request):
    return request.param()


@pytest.fixture(scope="module")
def compatibility():
    """With code that Numba does not optimize: that takes longer than all runs."""
    with pytest.MonkeyPatch.context() as patch:
        for name in ("OPT", "LOOP_VECTORIZE", "SLP_VECTORIZE"):
            patch.setenv(f"NUMBA_{name}", "0")
        return [check_operator(kind()) for kind in FAMILY]


def test_all_keep_to_the_contract_and_no_algorithm_fails_with_any(compatibility):
    failed = [(c.operator, name) for c in compatibility for name, (how, _) in c.algorithms.items() if how == FAILS]
    assert not failed


def test_a_refusal_names_both_the_operator_and_what_it_lacks(compatibility):
    refused = [(c.operator, why) for c in compatibility for how, why in c.algorithms.values() if how == REFUSED]
    assert refused
    assert all(operator in why for operator, why in refused)


def test_the_documented_table_is_what_is_found(compatibility):
    page = DOCS.read_text(encoding="utf-8")
    if f"With pymoo {pymoo.__version__};" not in page:
        pytest.skip(f"the table is made with another pymoo than {pymoo.__version__}")
    assert compatibility_table(compatibility) in page


def test_probabilities_are_found_by_pymoos_tuning(operator):
    numbers = {
        name
        for name in inspect.signature(type(operator)).parameters
        if (name.startswith("prob") and name != "progress") or name == "b"
    }
    tunable = get_params(operator)
    assert numbers <= tunable.keys()
    assert all(isinstance(tunable[name], Real) for name in numbers)


def test_it_improves_a_population_with_one_objective(operator):
    found = minimize(Bowl(), GA(**{slot(operator): operator}, pop_size=20), ("n_gen", 6), seed=1)
    X = found.pop.get("X")
    assert np.all((X >= LOWER) & (X <= UPPER))
    assert found.F[0] < np.median(population(100).get("F"))
