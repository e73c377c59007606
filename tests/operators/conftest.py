"""The problem that operators are tried on."""

import pytest
from bowl import Bowl


@pytest.fixture
def problem():
    return Bowl()
