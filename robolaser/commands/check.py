"""robolaser check: what a data set can show, without a fit."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from textwrap import fill

from robolaser.commands.terminal import Terminal, say

WIDTH = 110
Checked = tuple[Mapping[str, object], Sequence[str], Sequence[str]]  # JSON, warnings, lines of text


def check(dataset: Path, /, *, terminal: Terminal = Terminal()) -> None:
    """List what can be estimated from a data set, and which data are missing for the rest, without a fit.

    For example:

        robolaser check measured

    Args:
        dataset: Folder with dataset.toml, poses.csv and points.csv, if there are points; or motion.csv.
    """
    from robolaser.motion.reading import is_motion

    found, warnings, lines = _of_motion(dataset) if is_motion(dataset) else _of_poses(dataset)
    if not terminal.json:
        terminal.warn(*warnings)
    terminal.show(found, lambda: say("\n".join(lines)))


def _of_motion(folder: Path) -> Checked:
    from robolaser.motion.checking import check_motion
    from robolaser.motion.reading import load_motion

    found = check_motion(load_motion(folder))
    log = found.log
    places: dict[str, list[str]] = {}
    for name, where in found.tested.items():
        places.setdefault("every joint" if where == log.joints else ", ".join(where), []).append(name)
    lines = [
        f"{log.name}: moving arm, {len(log)} rows of {len(log.joints)} joints in {len(log.series)} series",
        f"Rows: {', '.join(found.kinds) or 'none'}",
        *_effects(len(found.tested), places, found.not_tested),
    ]
    return found.to_dict(), log.warnings, lines


def _of_poses(folder: Path) -> Checked:
    from robolaser.data.loading import load
    from robolaser.diagnosis.data_check import check_data

    found = check_data(load(folder))
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
    lines += _effects(len(tested), tested, {one.effect: str(one.reason) for one in found.effects if one.reason})
    if found.missing:
        lines += ["", "More could be tested with"]
        lines += [_item(f"{remedy}: {', '.join(names)}") for remedy, names in found.missing.items()]
    return check_json, found.dataset.warnings, lines


def _effects(tested: int, listed: Mapping[str, Sequence[str]], untested: Mapping[str, str]) -> list[str]:
    """Testable effects with their locations, and the others by reason."""
    reasons: dict[str, list[str]] = {}
    for name, reason in untested.items():
        reasons.setdefault(reason, []).append(name)
    return [
        "",
        f"Diagnosis: {tested} of {tested + len(untested)} effects can be tested",
        *(_item(f"{one}: {', '.join(others)}") for one, others in listed.items()),
        *(["", "Not testable"] if reasons else []),
        *(_item(f"{', '.join(names)}: {reason}") for reason, names in reasons.items()),
    ]


def _item(text: str) -> str:
    return fill(text, WIDTH, initial_indent="  ", subsequent_indent="    ", break_on_hyphens=False)
