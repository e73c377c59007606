"""Calibrations to report on."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1]))

from calibrated import KINDS


@pytest.fixture(scope="session")
def calibrations():
    return {kind: make() for kind, make in KINDS.items()}


@pytest.fixture(params=KINDS)
def calibration(request, calibrations):
    return calibrations[request.param]
