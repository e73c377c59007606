"""robolaser check: what a data set allows, before anyone waits."""

from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING

from robolaser.commands.terminal import TERMINAL, Terminal, say

if TYPE_CHECKING:
    from robolaser.diagnosis.data_check import DataCheck

WIDTH = 110


def check(dataset: Path, /, *, terminal: Terminal = TERMINAL) -> None:
    """Say what a data set allows and what is missing for the rest, before anything is fitted.

    For example:

        robolaser check measured

    Args:
        dataset: Folder with dataset.toml, poses.csv and, once there are points, points.csv.
    """
    from robolaser.data.loading import load
    from robolaser.diagnosis.data_check import check_data

    found = check_data(load(dataset))
    if not terminal.json:
        for warning in found.dataset.warnings:
            terminal.warn(warning)
    terminal.show(found.to_dict(), lambda: say(_text(found)))


def _text(found: "DataCheck") -> str:
    check_json = found.to_dict()
    lines = [
        f"{check_json['dataset']}: {found.dataset.format.title}, {check_json['points']} points in"
        f" {check_json['poses_with_points']} of {check_json['poses']} poses",
        "",
        "Calibration",
    ]
    if found.hindrance:
        lines.append(_item(f"not possible: {found.hindrance}"))
    else:
        lines.append(_item(f"{len(found.parameters)} parameters: {', '.join(found.parameters)}"))
        lines += [_item(f"indistinguishable at these poses: {', '.join(names)}") for names in found.inseparable]
    tested = {one.effect: one.locations for one in found.effects if not one.reason}
    lines += ["", f"Diagnosis: {len(tested)} of {len(found.effects)} effects can be tested"]
    lines += [_item(f"{effect}: {', '.join(locations)}") for effect, locations in tested.items()]
    reasons: dict[str, list[str]] = {}
    for one in found.effects:
        if one.reason:
            reasons.setdefault(str(one.reason), []).append(one.effect)
    if reasons:
        lines += ["", "Not testable"]
        lines += [_item(f"{', '.join(names)}: {reason}") for reason, names in reasons.items()]
    if found.missing:
        lines += ["", "More could be tested with"]
        lines += [_item(f"{remedy}: {', '.join(names)}") for remedy, names in found.missing.items()]
    return "\n".join(lines)


def _item(text: str) -> str:
    return fill(text, WIDTH, initial_indent="  ", subsequent_indent="    ", break_on_hyphens=False)
