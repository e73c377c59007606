"""robolaser challenge: blind data sets whose effects are sealed, and the score of a diagnosis on them."""

import argparse
import re
import secrets
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar, final

from robolaser.commands.argument_types import count, seed
from robolaser.commands.command import Command, make_folder, progress_bar
from robolaser.errors import OutputExists, RangeUnclear

if TYPE_CHECKING:
    from robolaser.data.dataset import Dataset
    from robolaser.geometry.kinematics import Robot
    from robolaser.trials.building import Ranges

USUAL_ARM = "scorbot_er7"  # the one that needs no further package
NUMBER = r"(\d+(?:\.\d*)?(?:e-?\d+)?)"
MOST_ROWS = 5  # of confusions shown: score.json has all
N = TypeVar("N", int, float)


@final
class Challenge(Command):
    """Makes and scores blind trials."""

    name: ClassVar[str] = "challenge"
    summary: ClassVar[str] = "make blind data sets whose effects are sealed, and score a diagnosis on them"

    def declare(self, parser: argparse.ArgumentParser) -> None:
        """Say what can be given to it."""
        words = parser.add_subparsers(metavar="new|score", required=True)
        self._declare_new(words.add_parser("new", help="make data sets, and seal what is wrong in them"))
        self._declare_score(words.add_parser("score", help="open the seals and score the diagnoses"))

    def _declare_new(self, parser: argparse.ArgumentParser) -> None:
        parser.add_argument("folder", metavar="DIR", type=Path, help="for the trial")
        parser.add_argument(
            "--robot",
            metavar="NAME_OR_URDF",
            action="append",
            default=[],
            help=f"default: {USUAL_ARM}; several take turns",
        )
        parser.add_argument("--flange", metavar="FRAME", help="of URDF files: the frame that carries the sensor")
        parser.add_argument(
            "--like",
            metavar="DATASET",
            action="append",
            default=[],
            type=Path,
            help="its arm, scanner, poses and noise",
        )
        parser.add_argument("--count", metavar="N", type=count, default=12, help="data sets; default: 12")
        parser.add_argument("--poses", metavar="A-B", help="default: 36-72")
        parser.add_argument("--points", metavar="A-B", help="in each pose; default: 6-12")
        parser.add_argument("--pixel-noise", metavar="A-B", help="in pixels; default: 0.06-0.2")
        parser.add_argument(
            "--kinds",
            metavar="A,B",
            help="of none,single,pair,triple,unknown,outliers, in equal shares; default: all, singles most",
        )
        parser.add_argument("--seed", metavar="N", type=seed, help="default: a new one each time, and a secret")
        parser.add_argument("--force", action="store_true", help="overwrite a trial that is there")
        parser.set_defaults(act=_new)

    def _declare_score(self, parser: argparse.ArgumentParser) -> None:
        parser.add_argument("folder", metavar="DIR", type=Path, help="of the trial")
        parser.add_argument("--output", metavar="DIR", type=Path, help="for score.json; default: the trial's folder")
        parser.add_argument("--seed", metavar="N", type=seed, default=1, help="of diagnoses not yet made; default: 1")
        parser.add_argument("--jobs", metavar="N", type=count, default=1, help="diagnoses at a time; default: 1")
        parser.add_argument("--force", action="store_true", help="overwrite a score that is there")
        parser.set_defaults(act=_score)

    def run(self, args: argparse.Namespace) -> None:
        """Make or score."""
        args.act(args)


def _new(args: argparse.Namespace) -> None:
    from robolaser.data.loading import load  # noqa: PLC0415
    from robolaser.geometry.robots import find_robot  # noqa: PLC0415
    from robolaser.trials.making import USUAL  # noqa: PLC0415 - `--help` must not pay for physics
    from robolaser.trials.trial import new  # noqa: PLC0415

    ranges = _ranges(args)
    kinds = dict.fromkeys(args.kinds.split(","), 1.0) if args.kinds else USUAL
    sources: list[Robot | Dataset] = [load(path) for path in args.like]
    named = args.robot or ([] if sources else [USUAL_ARM])
    sources += [find_robot(name, flange=args.flange) for name in named]
    make_folder(args.folder)
    drawn = secrets.randbits(48) if args.seed is None else args.seed
    with progress_bar() as tell:
        names = new(
            args.folder,
            sources,
            count=args.count,
            seed=drawn,
            kinds=kinds,
            ranges=ranges,
            overwrite=args.force,
            tell=tell,
        )
    print(f"{len(names)} sealed data sets: {args.folder / names[0]} to {names[-1]}. Diagnose them, then:")
    print(f"robolaser challenge score {args.folder}")


def _ranges(args: argparse.Namespace) -> "Ranges":
    from robolaser.trials.building import Ranges  # noqa: PLC0415

    usual = Ranges()
    return Ranges(
        poses=_range("--poses", args.poses, usual.poses, int),
        points=_range("--points", args.points, usual.points, int),
        pixel_px=_range("--pixel-noise", args.pixel_noise, usual.pixel_px, float),
    )


def _range(option: str, text: str | None, usual: tuple[N, N], kind: Callable[[str], N]) -> tuple[N, N]:
    if text is None:
        return usual
    expected = f"two positive {'whole ' if kind is int else ''}numbers"
    match = re.fullmatch(rf"{NUMBER}(?:-{NUMBER})?", text.strip())
    try:
        low, high = (kind(part) for part in ((match[1], match[2] or match[1]) if match else ("", "")))
    except ValueError:
        raise RangeUnclear(option, text, expected) from None
    if not 0 < low <= high:
        raise RangeUnclear(option, text, expected)
    return low, high


def _score(args: argparse.Namespace) -> None:
    import json  # noqa: PLC0415

    from robolaser.data.csv_tables import write_text  # noqa: PLC0415
    from robolaser.trials.trial import score  # noqa: PLC0415

    folder = args.output or args.folder
    file = folder / "score.json"
    if file.exists() and not args.force:
        raise OutputExists(file)
    if args.output:
        make_folder(folder)
    with progress_bar() as tell:
        scored = score(args.folder, seed=args.seed, jobs=args.jobs, tell=tell)
    write_text(file, json.dumps(scored, indent=1) + "\n")
    print("\n".join(summary(scored)))
    print(f"Wrote {file}")


TITLES = {
    "one": "one effect, named first and alone",
    "confusable": "one effect, it or its class named",
    "several": "two or three effects, all and no other",
    "none": "nothing wrong, nothing found",
    "outliers": "gross errors only, no other effect",
    "unknown": "unknown effect, said so or harmless",
}


def summary(scored: Mapping[str, Any]) -> list[str]:
    """A score as some twenty lines for a terminal."""
    from robolaser.trials.worlds.families import STRANGERS  # noqa: PLC0415 - `--help` must not pay for physics

    lines = [f"{'worlds: ' + str(scored['worlds']):40} {'right':>9}  {'share':>6}  {'95 %':>11}  {'asked':>6}"]
    lines += [_line(title, scored["groups"][group]) for group, title in TITLES.items()]
    unknown = scored["unknown"]
    lines += [
        "",
        _line("hits: first of those named, one effect", scored["hits"]),
        _line("false alarms: nothing wrong, yet a gap", scored["false_alarms"]),
        _line("unknown: sure of a wrong cause", unknown["sure_and_wrong"]),
        _line("unknown: its site first", unknown["site_first"]),
        _line("95 % intervals that hold the truth", scored["coverage_95"]),
        f"gap closed, median: {_number(scored['gap_closed'])}; "
        f"left over the noise floor, median: {_number(scored['left_over_noise'])}",
        "stated probability against share right: "
        + (
            ", ".join(f"{b['stated']:.2f} {b['share']:.2f} ({b['of']})" for b in scored["reliability"] if b["of"])
            or "-"
        ),
    ]
    taken = [
        (said, f"{true} taken for {column}")
        for true, row in scored["confusion"].items()
        for column, said in row.items()
        if column not in (true, "no_gap") and true not in ("none", "outliers")
        if column != "unexplained" or true not in STRANGERS
    ]
    lines += [f"{said:4d} x {text}" for said, text in sorted(taken, reverse=True)[:MOST_ROWS]]
    return lines


def _line(title: str, part: Mapping[str, Any]) -> str:
    if not part["of"]:
        return f"{title:40} {'-':>9}"
    low, high = part["ci95"]
    asked = f"{part['asked']:6.0%}" if "asked" in part else ""
    share = f"{part['right']:4d}/{part['of']:<4d}  {part['share']:6.1%}  {low:4.0%}..{high:4.0%}"
    return f"{title:40} {share}  {asked}".rstrip()


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.3f}"
