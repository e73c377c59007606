"""Comparisons run in the folder of `mine.py`, on one core."""

from pathlib import Path

import pytest


@pytest.fixture(autouse=True)
def at_home(monkeypatch):
    monkeypatch.chdir(Path(__file__).parent)


@pytest.fixture(autouse=True)
def on_one_core(monkeypatch):
    """Make all runs in one process by default: starting another one takes longer than the runs."""
    monkeypatch.setattr("os.sched_getaffinity", lambda process: {0}, raising=False)
