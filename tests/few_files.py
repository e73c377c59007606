"""Results with few files of the corrected arm, or untried ones: to write and read each for each fold takes longest."""

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from robolaser.results import delivered


@contextmanager
def only(*names: str) -> Iterator[None]:
    """State only these files."""
    few = {name: write if name in names else lambda made: None for name, write in delivered.EXPORTED.items()}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(delivered, "EXPORTED", few)
        yield


@contextmanager
def untried() -> Iterator[None]:
    """Write all files, but try none on unseen poses, as where nothing is installed that reads them."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(delivered, "missing_reader", lambda name: "reader")
        yield
