"""Whatever the files of others hold, an importer reads them or names them."""

from pathlib import Path

import pytest
from damage import damaged_bytes
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from examples import EXAMPLES
from robolaser.cli import main
from robolaser.data.importers import importers

OURS = [name for name, importer in importers().items() if importer.__module__.startswith("robolaser.")]


@pytest.fixture(scope="module", params=OURS)
def typed(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[list[str], list[Path]]:
    """What is typed to import an example, and all its files."""
    folder = tmp_path_factory.mktemp("raw")
    sources, options = EXAMPLES[request.param](folder)
    words = ["import", *map(str, sources), "--kind", request.param, *options, "--output", f"{folder}-out", "--dry-run"]
    return words, [file for file in sorted(folder.rglob("*")) if file.is_file()]


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_damaged_files_of_others_are_read_or_named(typed, data, capsys):
    words, files = typed
    file = data.draw(st.sampled_from(files))
    whole = file.read_bytes()
    try:
        file.write_bytes(data.draw(damaged_bytes(whole)))
        assert main(words) in (0, 1, 2)
    finally:
        file.write_bytes(whole)
    said = capsys.readouterr().err
    assert not said or said.startswith(("robolaser: ", "warning: "))
