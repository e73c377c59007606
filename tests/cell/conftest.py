"""The cell of most tests: an emulated SCORBOT's."""

from pathlib import Path

import bench
import pytest

from robolaser.data.cell_config import Cell


@pytest.fixture
def cell(tmp_path: Path) -> Cell:
    return bench.cell(tmp_path)
