"""robolaser challenge: blind data sets whose truth is kept apart, and the score of a diagnosis on them."""

import json
import re
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

from cyclopts import App, Parameter

from robolaser.commands.options import RESULT, Count, Force, Seed
from robolaser.commands.terminal import TERMINAL, Terminal, say
from robolaser.errors import UsageError

if TYPE_CHECKING:
    from robolaser.data.dataset import Dataset
    from robolaser.robot.kinematics import Robot

NEW, SCORE = "challenge new", "challenge score"
USUAL_ARM = "scorbot_er7"  # the one that needs no further package
NUMBER = r"(\d+(?:\.\d*)?(?:e-?\d+)?)"
MOST_ROWS = 5  # of confusions shown: score.json has all
N = TypeVar("N", int, float)

challenge = App(
    "challenge",
    help="Make blind data sets with hidden faults, and score the diagnoses of them.",
    group_commands="Commands",
)


@challenge.command
def new(
    folder: Path,
    /,
    *,
    robot: Annotated[tuple[str, ...], Parameter(metavar="NAME_OR_URDF")] = (),
    flange: Annotated[str | None, Parameter(metavar="FRAME")] = None,
    like: Annotated[tuple[Path, ...], Parameter(metavar="DATASET")] = (),
    count: Count = 12,
    poses: Annotated[str | None, Parameter(metavar="A-B")] = None,
    points: Annotated[str | None, Parameter(metavar="A-B")] = None,
    pixel_noise: Annotated[str | None, Parameter(metavar="A-B")] = None,
    kinds: Annotated[str | None, Parameter(metavar="A,B")] = None,
    tracked: Annotated[bool, Parameter(negative="")] = False,
    seed: Seed | None = None,
    truth: Annotated[Path | None, Parameter(metavar="DIR", group=RESULT)] = None,
    force: Force = False,
    terminal: Terminal = TERMINAL,
) -> None:
    """Make data sets with hidden faults.

    For example:

        robolaser challenge new trial --count 24 --robot panda --robot ur5

    Args:
        folder: Folder for the trial.
        robot: A robot or a URDF file; may be given again, they take turns. Default: scorbot_er7.
        flange: Frame of URDF files that carries the sensor.
        like: Data set whose arm, sensor, poses and noise are imitated; may be given again.
        count: Number of data sets.
        poses: Range of the number of poses. Default: 36-72.
        points: Range of the number of points in each pose. Default: 6-12.
        pixel_noise: Range of the noise in pixels. Default: 0.06-0.2.
        kinds: Kinds of worlds, or names of faults, in equal shares. Default: all but physics, mostly single faults.
        tracked: Measure all arms with a tracker, whatever the kind of world.
        seed: Seed of the trial. Default: a new, secret one each time.
        truth: Folder for the truth; keep it to yourself. Default: FOLDER.truth, beside the folder.
        force: Overwrite an earlier trial.
    """
    import secrets

    from robolaser.data.importers.robots import find_robot
    from robolaser.data.loading import load
    from robolaser.data.result_folder import results_in
    from robolaser.trials import trial
    from robolaser.trials.building import Ranges
    from robolaser.trials.sealed_truth import truth_beside

    usual = Ranges()
    plan = trial.TrialPlan(
        count=count,
        seed=secrets.randbits(48) if seed is None else seed,
        kinds=kinds.split(",") if kinds else (),
        ranges=Ranges(
            poses=_range("--poses", poses, usual.poses, int),
            points=_range("--points", points, usual.points, int),
            pixel_px=_range("--pixel-noise", pixel_noise, usual.pixel_px, float),
        ),
        tracked=tracked,
    )
    sources: list[Robot | Dataset] = [load(path) for path in like]
    sources += [find_robot(name, flange=flange) for name in robot or (() if sources else (USUAL_ARM,))]
    truth = truth or truth_beside(folder)
    if truth.resolve().is_relative_to(folder.resolve()):
        raise UsageError(f"--truth {truth} is in {folder} and would be given away with it. Keep it elsewhere.")
    with results_in(folder, command=NEW, files=[], over=[SCORE], force=force) as claim, terminal.progress() as tell:
        names = trial.new(folder, truth, sources, plan, claim=claim, tell=tell)

    def print_names() -> None:
        say(f"{len(names)} blind data sets: {folder / names[0]} to {names[-1]}. Diagnose them, then:")
        say(f"robolaser challenge score {folder}")
        say(f"Keep {truth} to yourself: it holds the truth.")

    terminal.show({"folder": str(folder), "datasets": names}, print_names)


@challenge.command
def score(
    folder: Path,
    /,
    *,
    output: Annotated[Path | None, Parameter(metavar="DIR", group=RESULT)] = None,
    seed: Seed = 1,
    jobs: Count | None = None,
    scheduler: Annotated[str | None, Parameter(metavar="ADDRESS")] = None,
    truth: Annotated[Path | None, Parameter(metavar="DIR")] = None,
    force: Force = False,
    terminal: Terminal = TERMINAL,
) -> None:
    """Score the diagnoses of a trial against the truth.

    For example:

        robolaser challenge score trial --jobs 4

    Args:
        folder: Folder of the trial.
        output: Folder for score.json. Default: FOLDER.
        seed: Seed of the diagnoses that have yet to be made.
        jobs: Number of diagnoses at a time. Default: 1.
        scheduler: Address of a Dask cluster, tcp://HOST:PORT.
        truth: Folder of the trial's truth. Default: FOLDER.truth, beside the folder.
        force: Overwrite an earlier score.
    """
    from robolaser.benchmark.executors import engine_of
    from robolaser.data.result_folder import results_in, write_results
    from robolaser.trials import trial
    from robolaser.trials.sealed_truth import truth_beside, unseal

    if scheduler and jobs:
        raise UsageError("--scheduler and --jobs exclude each other: leave one of them out.")
    file = (output or folder) / "score.json"
    with results_in(file.parent, command=SCORE, files=[file.name], force=force) as claim, ExitStack() as stack:
        truths = unseal(folder, truth or truth_beside(folder))
        diagnoses = trial.diagnosis_files(folder, truths, file.parent)
        claim(f"{name}/{trial.DIAGNOSIS}" for name, path in diagnoses.items() if not path.exists())
        executor = None
        if scheduler or (jobs or 1) > 1:
            executor = stack.enter_context(engine_of(jobs, scheduler)).executor
        tell = stack.enter_context(terminal.progress())
        trial.diagnose_missing(folder, diagnoses, seed=seed, executor=executor, tell=tell)
        scored = trial.score(folder, truths, diagnoses)
        text = json.dumps(scored, indent=1) + "\n"
        write_results(file.parent, {file.name: text})
    terminal.show(text, lambda: say("\n".join([*summary(scored), f"Wrote {file}"])))


def _range(option: str, text: str | None, usual: tuple[N, N], kind: Callable[[str], N]) -> tuple[N, N]:
    """The least and the most of a number, as typed."""
    if text is None:
        return usual
    wrong = UsageError(
        f"{option} {text}: expected two positive {'whole ' if kind is int else ''}numbers, the least before the most,"
        " as in 36-72."
    )
    match = re.fullmatch(rf"{NUMBER}(?:-{NUMBER})?", text.strip())
    try:
        low, high = (kind(part) for part in ((match[1], match[2] or match[1]) if match else ("", "")))
    except ValueError:
        raise wrong from None
    if not 0 < low <= high:
        raise wrong
    return low, high


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
    from robolaser.trials.synthetic.fault_models import MODELLED

    lines = [f"{'worlds: ' + str(scored['worlds']):40} {'right':>9}  {'share':>6}  {'95 %':>11}  {'asked':>6}"]
    lines += [_line(title, scored["groups"][group]) for group, title in TITLES.items()]
    unknown = scored["unknown"]
    lines += [
        "",
        _line("hits: first of those named, one effect", scored["hits"]),
        _line("false alarms: nothing wrong, yet a gap", scored["false_alarms"]),
        _line("class of causes, all right", scored["by_class"]),
        _line("sure of a wrong cause (p >= 0.9)", scored["sure_and_wrong"]),
        _line("unknown: sure of a wrong cause", unknown["sure_and_wrong"]),
        _line("unknown: its site first", unknown["site_first"]),
        _line("95 % intervals that hold the truth", scored["coverage_95"]),
        f"gap closed, median: {_number(scored['gap_closed'])}; "
        f"left over the noise floor, median: {_number(scored['left_over_noise'])}",
    ]
    lines += ["", *_kinds(scored["kinds"]), "", *_intervals(scored["coverage_95_by_effect"]), *_reliability(scored)]
    taken = [
        (times, f"{true} taken for {column}")
        for true, row in scored["confusion"].items()
        for column, times in row.items()
        if column not in (true, "no_gap") and true not in ("none", "outliers")
        if column != "unexplained" or true in MODELLED
    ]
    lines += [f"{times:4d} x {text}" for times, text in sorted(taken, reverse=True)[:MOST_ROWS]]
    return lines


COLUMNS = {
    "by_name": "name",
    "by_class": "class",
    "verdict": "verdict",
    "site_first": "place",
    "sure_and_wrong": "sure, wrong",
    "coverage_95": "intervals",
}


def _kinds(kinds: Mapping[str, Any]) -> list[str]:
    """Shares of each kind of worlds, as a table."""
    head = f"{'kind':18} {'worlds':>6}" + "".join(f" {title:>11}" for title in COLUMNS.values())
    rows = []
    for kind, part in kinds.items():
        shares = (part[column]["share"] for column in COLUMNS)
        cells = "".join(f" {'-' if share is None else f'{share:.0%}':>11}" for share in shares)
        rows.append(f"{kind:18} {part['worlds']:6d}{cells}")
    return [head, *rows]


def _intervals(effects: Mapping[str, Any]) -> list[str]:
    """How many 95 % intervals of each effect's numbers hold the truth."""
    rows = [f"{name:28} {part['right']:4d} of {part['of']}" for name, part in effects.items()]
    return ["95 % intervals that hold the truth", *rows, ""] if rows else []


def _reliability(scored: Mapping[str, Any]) -> list[str]:
    """How often what was stated with some probability was right, names beside classes."""
    rows = [
        f"{names['from']:4.2f} to {names['to']:4.2f}{'':8} {_stated(names)} {_stated(classes)}"
        for names, classes in zip(scored["reliability"], scored["reliability_of_classes"], strict=True)
        if names["of"] or classes["of"]
    ]
    return (
        [f"{'stated probability':20} {'names: stated, right':>24} {'classes: stated, right':>24}", *rows]
        if rows
        else []
    )


def _stated(part: Mapping[str, Any]) -> str:
    if not part["of"]:
        return f"{'-':>24}"
    of = f"({part['right']}/{part['of']})"
    return f"{part['stated']:6.3f} {part['share']:6.3f} {of:>10}"


def _line(title: str, part: Mapping[str, Any]) -> str:
    if not part["of"]:
        return f"{title:40} {'-':>9}"
    low, high = part["ci95"]
    asked = f"{part['asked']:6.0%}" if "asked" in part else ""
    share = f"{part['right']:4d}/{part['of']:<4d}  {part['share']:6.1%}  {low:4.0%}..{high:4.0%}"
    return f"{title:40} {share}  {asked}".rstrip()


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.3f}"
