"""The problem and the population that operators are tried on."""

import pytest
from bowl import Bowl, population


@pytest.fixture
def problem():
    return Bowl()


@pytest.fixture
def pop(problem):
    return population(problem, 40)
