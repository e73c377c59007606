"""Comparison of the answers of two versions with each other, and with the truth where it is known."""

import json
import statistics
from collections import Counter, defaultdict
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from answers import GAPS, as_written
from worlds import HARMLESS_RAD, sealed

from robolaser.trials.score import SURE, outcome

GAP = 0.01  # smallest reported change of a gap, J or an error, relative
MOVED = 0.1  # smallest reported change of a parameter, in standard errors
SCATTER = "pose_scatter"  # the right effect for joints that scatter
COMMANDS = ("calibrate", "diagnose")


@dataclass(frozen=True)
class Judgement:
    """A diagnosis compared with the truth; None where the truth is unknown or not required."""

    right: dict[str, bool | None]  # verdict, class, first location, and the whole answer
    true: frozenset[str]  # names
    false: frozenset[str]
    sure_false: frozenset[str]


def lines(file: Path) -> list[dict[str, Any]]:
    """The lines of a file."""
    return [json.loads(line) for line in file.read_text(encoding="utf-8").splitlines()]


def judged(line: Mapping[str, Any]) -> Judgement | None:
    """Compare an answer with the truth; None if either is missing."""
    truth, found = line.get("truth"), line["diagnose"]
    if truth is None or "fails" in found:
        return None
    stated = {f"{e} at {w}": (p, [e, w]) for e, w, p, *_ in found["effects"] if e != "outliers"}
    if "scatter_rad" in truth:
        harmless = truth["scatter_rad"] <= HARMLESS_RAD
        verdict = found["verdict"] == ("no_gap" if harmless else "unexplained")
        held = {name for name, (_, (effect, _)) in stated.items() if effect == SCATTER and not harmless}
        right: dict[str, bool | None] = {"verdict": verdict, "whole": verdict and held == set(stated)}
    else:
        truth = sealed(truth)
        seen = outcome(truth, as_written(found))
        right = {
            "verdict": seen.verdict_right,
            "class": seen.class_right,
            "place": seen.site_first,
            "whole": seen.right,
        }
        good = [*truth["background"], *([e["effect"], e["where"]] for e in truth["each"])]
        good += [pair for e in truth["each"] for pair in (*e["also_right"], *e["rivals"])]
        held = {name for name, (_, pair) in stated.items() if pair in good}
    false = set(stated) - held
    return Judgement(right, frozenset(held), frozenset(false), frozenset(n for n in false if stated[n][0] >= SURE))


def compare(before: Path, after: Path) -> int:
    """Print improvements, regressions and other changes of each data set, then counts and CPU; 1 after a regression."""
    was, now = ({line["name"]: line for line in lines(file)} for file in (before, after))
    shared = [name for name in was if name in now]
    worse = alike = 0
    for name in shared:
        changes = _differences(was[name], now[name])
        worse += bool(changes["WORSE"])
        alike += not any(changes.values())
        print(f"{name}: CPU of {_cpu(was[name], now[name])}{'' if any(changes.values()) else '; alike'}")
        for mark, texts in changes.items():
            for text in texts:
                print(f"  {mark}: {text}")
    only = f"{len(was) - len(shared)} only before, {len(now) - len(shared)} only after"
    print(f"\n{alike} of {len(shared)} data sets alike, {worse} worse; {only}\n")
    _counts([was[name] for name in shared], [now[name] for name in shared])
    for command in COMMANDS:
        pairs = [(was[n][command]["cpu_s"], now[n][command]["cpu_s"]) for n in shared if command in was[n]]
        ratios = [b / max(a, 0.01) for a, b in pairs]
        if ratios:
            total = sum(b for _, b in pairs) / sum(a for a, _ in pairs)
            middle = f"median {statistics.median(ratios):.2f}, most {max(ratios):.2f}"
            print(f"CPU of {command}, after / before: {middle}, sum {total:.2f}")
    return int(worse > 0)


def _differences(was: Mapping[str, Any], now: Mapping[str, Any]) -> dict[str, list[str]]:
    changes: dict[str, list[str]] = {"better": [], "WORSE": [], "other": []}
    if was["data"] != now["data"]:
        changes["other"].append(f"not the same data: {now['data']}, was {was['data']}")
    for command in COMMANDS:
        a, b = was.get(command, {}), now.get(command, {})
        if ("fails" in a) != ("fails" in b):
            ends = f"{command} {b.get('fails', 'answers')}, was {a.get('fails', 'an answer')}"
            changes["WORSE" if "fails" in b else "better"].append(ends)
        elif a and b and "fails" not in a:
            changes["other"] += _calibrations(a, b) if command == "calibrate" else _diagnoses(a, b)
    before, after = judged(was), judged(now)
    if before and after:
        for what, held in after.right.items():
            if None not in (held, before.right[what]) and held != before.right[what]:
                changes["better" if held else "WORSE"].append(
                    f"{what} {'right' if held else 'wrong'}: {_said(now)}, was {_said(was)}"
                )
        for kind, a_names, b_names, more_is in (
            ("true", before.true, after.true, "better"),
            ("false", before.false, after.false, "WORSE"),
            ("false and sure", before.sure_false, after.sure_false, "WORSE"),
        ):
            if len(b_names) != len(a_names):  # an exchanged name is neither better nor worse
                mark = more_is if len(b_names) > len(a_names) else ({"better", "WORSE"} - {more_is}).pop()
                changes[mark].append(f"names {kind}: {sorted(b_names)}, was {sorted(a_names)}")
    return changes


def _cpu(was: Mapping[str, Any], now: Mapping[str, Any]) -> str:
    """Ratios of CPU time of the commands that both have."""
    both = [command for command in COMMANDS if command in was and command in now]
    return ", ".join(f"{command} {now[command]['cpu_s'] / max(was[command]['cpu_s'], 0.01):.2f}" for command in both)


def _said(line: Mapping[str, Any]) -> str:
    found = line["diagnose"]
    return f"{found['verdict']} ({', '.join(f'{e} at {w} {p}' for e, w, p, *_ in found['effects']) or 'nothing'})"


def _calibrations(a: Mapping[str, Any], b: Mapping[str, Any]) -> list[str]:
    changes = [_gap(name, a[name], b[name]) for name in ("J", "held_out_mm")]
    changes += [_moved(name, a["numbers"][name], b["numbers"][name]) for name in a["numbers"] if name in b["numbers"]]
    if sorted(a["unidentifiable"]) != sorted(b["unidentifiable"]) or set(a["numbers"]) != set(b["numbers"]):
        changes.append(f"not identifiable: {b['unidentifiable']}, was {a['unidentifiable']}")
    return [f"calibrate: {text}" for text in changes if text]


def _diagnoses(a: Mapping[str, Any], b: Mapping[str, Any]) -> list[str]:
    changes = [f"verdict {b['verdict']}, was {a['verdict']}" if a["verdict"] != b["verdict"] else ""]
    changes += [_gap(f"gap {name}", a["gap_mm"][name], b["gap_mm"][name]) for name in GAPS]
    sizes = [{f"{e} at {w}": numbers for e, w, _, numbers, _ in each["effects"]} for each in (a, b)]
    if set(sizes[0]) != set(sizes[1]):
        changes.append(f"names {sorted(sizes[1])}, was {sorted(sizes[0])}")
    for name in sizes[0].keys() & sizes[1].keys():
        changes += [
            _moved(f"{name}, {n}", sizes[0][name][n], sizes[1][name][n]) for n in sizes[0][name] if n in sizes[1][name]
        ]
    likely = [sorted(name for name, p in each["classes"] if p >= SURE) for each in (a, b)]
    if likely[0] != likely[1]:
        changes.append(f"sure classes {likely[1]}, was {likely[0]}")
    if [row[0] for row in a["where"][:1]] != [row[0] for row in b["where"][:1]]:
        changes.append(f"first location {b['where'][:1]}, was {a['where'][:1]}")
    return [f"diagnose: {text}" for text in changes if text]


def _gap(name: str, a: float | None, b: float | None) -> str:
    if a is None or b is None:
        return "" if a == b else f"{name} {b}, was {a}"
    return f"{name} {b:.5g}, was {a:.5g} ({b / a - 1:+.1%})" if abs(b - a) > GAP * abs(a) and a else ""


def _moved(name: str, a: list[float | None], b: list[float | None]) -> str:
    if a[0] is None or b[0] is None or not a[1] or not b[1]:
        return ""
    by = abs(b[0] - a[0]) / a[1]
    return f"{name} {b[0]:.6g}, was {a[0]:.6g}: {by:.2g} standard errors" if by > MOVED else ""


def counts(every: list[dict[str, Any]]) -> dict[str, Counter[str]]:
    """Counts of right answers, names and CPU seconds by group."""
    counted: dict[str, Counter[str]] = defaultdict(Counter)
    for line in every:
        group, seen = counted[line["group"]], judged(line)
        group["data sets"] += 1
        group["fails"] += sum("fails" in line.get(command, {}) for command in COMMANDS)
        group["cpu_s"] += round(sum(line.get(command, {}).get("cpu_s", 0) for command in COMMANDS))
        if seen is None:
            continue
        for what, held in seen.right.items():
            if held is not None:
                group[f"{what} right"] += held
                group[f"{what} known"] += 1
        group["names true"] += len(seen.true)
        group["names false"] += len(seen.false)
        group["sure and false"] += len(seen.sure_false)
    return counted


def _counts(was: list[dict[str, Any]], now: list[dict[str, Any]]) -> None:
    """Print a row for each group: before → after where they differ."""
    shares = ("whole", "verdict", "class", "place")
    whats = ("names true", "names false", "sure and false", "fails", "cpu_s")
    print(f"| group | data sets | {' | '.join(shares)} | {' | '.join(whats)} |")
    print("|---" * (2 + len(shares) + len(whats)) + "|")
    both = counts(was), counts(now)
    for group in both[0]:
        a, b = (each[group] for each in both)
        cells = [
            _cell(*(f"{c[f'{s} right']}/{c[f'{s} known']}" if c[f"{s} known"] else "" for c in (a, b))) for s in shares
        ]
        cells += [_cell(str(a[what]), str(b[what])) for what in whats]
        print(f"| {group} | {a['data sets']} | {' | '.join(cells)} |")
    print()


def _cell(a: str, b: str) -> str:
    return a if a == b else f"{a} → {b}"
