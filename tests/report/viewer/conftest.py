"""The folder of the synthetic cells, and a viewer without a server."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "scan"))


@pytest.fixture
def served(monkeypatch):
    """A viewer without a server; collects the shown elements."""
    shown = []

    class ViewerApp:
        url = "http://nowhere"

        def __init__(self, *what):
            shown.append(what)

        def wait(self):
            """Return at once, as if the user had ended it."""

    monkeypatch.setattr("robolaser.report.viewer.serving.ViewerApp", ViewerApp)
    return shown
