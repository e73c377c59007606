"""robolaser diff: two results side by side."""

from pathlib import Path

from robolaser.commands.terminal import TERMINAL, Terminal, say


def diff(first: Path, second: Path, /, *, terminal: Terminal = TERMINAL) -> None:
    """Show two calibrations, or two diagnoses, side by side.

    For example:

        robolaser diff result-monday result-friday

    Args:
        first: Folder of a result, or its JSON file.
        second: Folder of another result of the same kind, or its JSON file.
    """
    from robolaser.results.difference import difference, table

    found = difference(first, second)

    def print_rows() -> None:
        for line in table(found, (str(first), str(second))):
            say(line)

    terminal.show(found, print_rows)
