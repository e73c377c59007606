"""Where the made-up cells are, and a viewer without a server."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "scan"))


@pytest.fixture
def served(monkeypatch):
    """No server: what would be shown."""
    shown = []

    class ViewerApp:
        url = "http://nowhere"

        def __init__(self, *what):
            shown.append(what)

        def wait(self):
            """Until the user is tired of it."""

    monkeypatch.setattr("robolaser.report.viewer.serving.ViewerApp", ViewerApp)
    return shown
