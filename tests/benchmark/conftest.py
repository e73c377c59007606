"""Comparisons are made where `mine.py` lies, on one core."""

from pathlib import Path

import pytest


@pytest.fixture(autouse=True)
def at_home(monkeypatch):
    monkeypatch.chdir(Path(__file__).parent)


@pytest.fixture(autouse=True)
def on_one_core(monkeypatch):
    """Where nothing is said of jobs, one process makes all runs: another one takes longer to start than they do."""
    monkeypatch.setattr("os.sched_getaffinity", lambda process: {0}, raising=False)
