"""Fixtures of the diagnosis tests."""

import pytest
from board_cell import begun, cell

from robolaser.diagnosis.fit import Fit
from robolaser.estimation.averaging import AveragedData


@pytest.fixture(scope="session")
def clean() -> tuple[AveragedData, Fit]:
    """A scanner without faults: its rows, and the first fit of its diagnosis."""
    return begun(cell())
