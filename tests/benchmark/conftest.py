"""Comparisons are made where `mine.py` lies."""

from pathlib import Path

import pytest


@pytest.fixture(autouse=True)
def at_home(monkeypatch):
    monkeypatch.chdir(Path(__file__).parent)
