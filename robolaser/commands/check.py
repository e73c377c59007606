"""robolaser check: what a data set allows, before anyone waits."""

from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING

from robolaser.commands.terminal import TERMINAL, Terminal, say

if TYPE_CHECKING:
    from robolaser.diagnosis.data_check import DataCheck
    from robolaser.motion.checking import MotionCheck

WIDTH = 110


def check(dataset: Path, /, *, terminal: Terminal = TERMINAL) -> None:
    """List what can be estimated from a data set, and which data are missing for the rest, without a fit.

    For example:

        robolaser check measured

    Args:
        dataset: Folder with dataset.toml, poses.csv and points.csv, if there are points; or motion.csv.
    """
    from robolaser.motion.reading import is_motion

    if is_motion(dataset):
        _check_motion(dataset, terminal)
        return
    from robolaser.data.loading import load
    from robolaser.diagnosis.data_check import check_data

    found = check_data(load(dataset))
    if not terminal.json:
        terminal.warn(*found.dataset.warnings)
    terminal.show(found.to_dict(), lambda: say(_text(found)))


def _check_motion(folder: Path, terminal: Terminal) -> None:
    from robolaser.motion.checking import check_motion
    from robolaser.motion.reading import load_motion

    found = check_motion(load_motion(folder))
    log = found.log
    if not terminal.json:
        terminal.warn(*log.warnings)
    reasons: dict[str, list[str]] = {}
    for name, reason in found.not_tested.items():
        reasons.setdefault(reason, []).append(name)
    lines = [
        f"{log.name}: moving arm, {len(log)} rows of {len(log.joints)} joints in {len(log.series)} series",
        f"Rows: {', '.join(found.kinds) or 'none'}",
        "",
        f"Diagnosis: {len(found.tested)} of {len(found.tested) + len(found.not_tested)} effects can be tested",
        *(_item(f"{where}: {', '.join(names)}") for where, names in _by_place(found).items()),
        *(["", "Not testable"] if reasons else []),
        *(_item(f"{', '.join(names)}: {reason}") for reason, names in reasons.items()),
    ]
    terminal.show(found.to_dict(), lambda: say("\n".join(lines)))


def _by_place(found: "MotionCheck") -> dict[str, list[str]]:
    """Names of effects by where they can be tested."""
    groups: dict[str, list[str]] = {}
    for name, where in found.tested.items():
        place = "every joint" if where == found.log.joints else ", ".join(where)
        groups.setdefault(place, []).append(name)
    return groups


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
