"""The problem for tests of operators."""

import pytest
from bowl import Bowl


@pytest.fixture
def problem():
    return Bowl()
