"""The bar of long work: on a terminal, in a notebook, and nowhere else."""

import io
import sys
import time
from types import SimpleNamespace

import pytest

import robolaser
from robolaser.report import progress_bar as bars


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.fixture
def impatient(monkeypatch):
    monkeypatch.setattr(bars, "PATIENCE_S", 0.0)
    monkeypatch.setattr(bars, "APART_S", 0.0)
    monkeypatch.setattr(bars, "_kernel", lambda: None)


@pytest.mark.usefixtures("impatient")
def test_a_terminal_shows_what_is_being_done_and_the_bar_is_gone_afterwards(monkeypatch):
    monkeypatch.setattr(bars, "PATIENCE_S", 0.1)
    monkeypatch.setattr(sys, "stderr", Terminal())
    monkeypatch.setenv("TERM", "xterm")
    with robolaser.progress_bar() as progress:
        progress("weighing [the] evidence", 0.5)  # and nothing more, however long it takes
        for _ in range(1000):
            if "weighing" in sys.stderr.getvalue():
                break
            time.sleep(0.01)
    shown = sys.stderr.getvalue()
    assert "weighing [the] evidence" in shown
    assert shown.endswith("\x1b[2K")


@pytest.mark.usefixtures("impatient")
def test_nothing_is_shown_where_nobody_looks(monkeypatch):
    monkeypatch.setattr(sys, "stderr", io.StringIO())
    with robolaser.progress_bar() as progress:
        progress("weighing", 0.5)
    assert sys.stderr.getvalue() == ""


@pytest.mark.usefixtures("impatient")
def test_a_notebook_shows_one_bar_that_is_empty_in_the_end(monkeypatch):
    shown = []
    handle = SimpleNamespace(update=shown.append)
    display = SimpleNamespace(HTML=str, display=lambda bar, display_id: shown.append(bar) or handle)
    monkeypatch.setitem(sys.modules, "IPython", SimpleNamespace(display=display))
    monkeypatch.setitem(sys.modules, "IPython.display", display)
    monkeypatch.setattr(bars, "_kernel", object)
    with robolaser.progress_bar() as progress:
        progress("fitting <all>", 0.25)
        progress("weighing", 0.5)
    assert shown == [
        "<progress value=0.250></progress> fitting &lt;all&gt;",
        "<progress value=0.500></progress> weighing",
        "",
    ]
