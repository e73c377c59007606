"""Files of the corrected arm that are written, but not tried on unseen poses."""

from collections.abc import Iterator
from contextlib import contextmanager

import pytest


@contextmanager
def untried_files() -> Iterator[None]:
    """As where nothing is installed that reads them: to try them takes as long as their diagnosis.

    test_delivered_files.py tries them.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("robolaser.results.delivered.missing_reader", lambda name: "reader")
        yield
