"""robolaser diff: two results side by side."""

from contextlib import nullcontext
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from robolaser.commands.terminal import RESULT, Force, Terminal, Typed

FILES = ("diff.json", "report.html")


def diff(
    first: Path,
    second: Path,
    /,
    *,
    output: Annotated[Path | None, Parameter(metavar="DIR", group=RESULT)] = None,
    force: Force = False,
    terminal: Terminal = Terminal(),
    typed: Typed = "",
) -> None:
    """Show two calibrations, or two diagnoses, side by side.

    For example:

        robolaser diff result-monday result-friday
        robolaser diff result-monday result-friday --output moved

    Args:
        first: Folder of a result, or its JSON file.
        second: Folder of another result of the same kind, or its JSON file.
        output: Folder for the difference and its page. Default: they are not written.
    """
    from robolaser.data.result_folder import json_text, results_in, write_results
    from robolaser.report.console import print_document
    from robolaser.report.difference import document
    from robolaser.report.page import render
    from robolaser.results.difference import difference

    read = [first, second]
    writing = results_in(output, command="diff", files=FILES, inputs=read, force=force) if output else nullcontext()
    one, other = first.resolve().name, second.resolve().name  # of `.` too
    names = (str(first), str(second)) if one == other else (one, other)
    with writing:
        found = difference(first, second)
        if output:
            page = render(document(found, names), typed)
            write_results(output, {"report.html": page, "diff.json": json_text(found)})
    terminal.show(found, lambda: print_document(document(found, names)))
