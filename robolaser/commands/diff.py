"""robolaser diff: two results side by side."""

from pathlib import Path

from robolaser.commands.terminal import TERMINAL, Terminal


def diff(first: Path, second: Path, /, *, terminal: Terminal = TERMINAL) -> None:
    """Show two calibrations, or two diagnoses, side by side.

    For example:

        robolaser diff result-monday result-friday

    Args:
        first: Folder of a result, or its JSON file.
        second: Folder of another result of the same kind, or its JSON file.
    """
    from robolaser.report.console import print_document
    from robolaser.report.difference import document
    from robolaser.results.difference import difference

    found = difference(first, second)
    names = (str(first), str(second)) if first.name == second.name else (first.name, second.name)
    terminal.show(found, lambda: print_document(document(found, names)))
