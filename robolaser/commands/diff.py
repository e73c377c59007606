"""robolaser diff: two results side by side."""

from pathlib import Path
from typing import Any

from robolaser.commands.terminal import TERMINAL, Terminal, say


def diff(first: Path, second: Path, /, *, terminal: Terminal = TERMINAL) -> None:
    """Show two calibrations, or two diagnoses, side by side.

    For example:

        robolaser diff result-monday result-friday

    Args:
        first: Folder of a result, or its JSON file.
        second: Folder of another result of the same kind, or its JSON file.
    """
    from robolaser.results.difference import difference

    found = difference(first, second)

    def print_rows() -> None:
        cells = [("", str(first), str(second), "change"), *map(_cells, found["rows"])]
        widths = [max(len(row[i]) for row in cells) for i in range(4)]
        for name, *values in cells:
            numbers = "  ".join(value.rjust(width) for value, width in zip(values, widths[1:], strict=True))
            say(f"{name.ljust(widths[0])}  {numbers}".rstrip())

    terminal.show(found, print_rows)


def _cells(row: dict[str, Any]) -> tuple[str, str, str, str]:
    unit = f" {row['unit']}" if row.get("unit") else ""
    change = ""
    if row.get("change"):
        change = f"{row['change']:+.3g}{unit}"
        if row["errors"] is not None:
            change += f" ({abs(row['errors']):.1f} standard errors)"
    return row["name"], _said(row["first"], unit), _said(row["second"], unit), change


def _said(value: Any, unit: str) -> str:
    if value is None:
        return "-"
    return value if isinstance(value, str) else f"{value:.6g}{unit}"
