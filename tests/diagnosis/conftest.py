"""What tests of the diagnosis share."""

import pytest
from board_cell import begun, cell

from robolaser.diagnosis.fit import Fit
from robolaser.estimation.averaging import AveragedData


@pytest.fixture(scope="session")
def clean() -> tuple[AveragedData, Fit]:
    """A scanner without faults: its rows, and the fit that a diagnosis begins with."""
    return begun(cell())
