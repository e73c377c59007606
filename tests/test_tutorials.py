"""The notebooks of the docs run, and show what they did when they were written."""

import re
import shutil
import sys
from pathlib import Path
from typing import Any

import nbformat
import pytest
from nbclient import NotebookClient

sys.path.insert(0, str(Path(__file__).parents[1] / "docs"))

from run_code_blocks import same

ROOT = Path(__file__).parents[1]
NOTEBOOKS = sorted((ROOT / "docs" / "tutorials").glob("*.ipynb"))
TABLE = "\u2500"  # the rule below the headings of a table, whose cells a reader looks at and no sentence depends on


COUNT = re.compile(r"(?<![\w.])\d+(?![\w.])")  # such as of gross errors: one more or less is no other story


def text_of(cell: Any) -> str:
    """What a cell printed in one line, without tables and counts."""
    shown = [one for one in cell.outputs if one.output_type in ("stream", "execute_result")]
    text = " ".join((one.get("text") or one.data["text/plain"]).partition(TABLE)[0] for one in shown)
    return COUNT.sub("N", " ".join(text.split()))


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda notebook: notebook.stem)
@pytest.mark.filterwarnings("default")  # of Jupyter's own
def test_a_notebook_shows_what_it_showed_when_it_was_written(notebook: Path, tmp_path: Path) -> None:
    folder = tmp_path / "docs" / "tutorials"
    folder.mkdir(parents=True)
    shutil.copytree(ROOT / "examples", tmp_path / "examples")
    written = nbformat.read(notebook, as_version=4)
    again = nbformat.read(notebook, as_version=4)
    NotebookClient(again, timeout=300, startup_timeout=300, resources={"metadata": {"path": str(folder)}}).execute()
    for before, after in zip(written.cells, again.cells, strict=True):
        if before.cell_type == "code":
            assert same(text_of(before), text_of(after)), f"{text_of(before)}\nis now\n{text_of(after)}"
