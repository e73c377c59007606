"""robolaser challenge: blind data sets whose truth is kept apart, and the score of a diagnosis on them."""

import re
import shlex
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import App, Parameter

from robolaser.commands.terminal import RESULT, Count, Flange, Force, Seed, Terminal, aligned, refuse, say
from robolaser.errors import Interrupted, UsageError

if TYPE_CHECKING:
    from robolaser.data.dataset import Dataset
    from robolaser.robot.kinematics import Robot

NEW, SCORE = "challenge new", "challenge score"
USUAL_ARM = "scorbot_er7"  # needs no further package

challenge = App(
    "challenge", help="Make blind data sets with hidden faults, and score their diagnoses.", group_commands="Commands"
)


@challenge.command
def new(
    folder: Path,
    /,
    *,
    robot: Annotated[tuple[str, ...], Parameter(metavar="NAME_OR_URDF")] = (),
    flange: Flange = None,
    like: Annotated[tuple[Path, ...], Parameter(metavar="DATASET")] = (),
    count: Count = 12,
    poses: Annotated[str | None, Parameter(metavar="A-B")] = None,
    points: Annotated[str | None, Parameter(metavar="A-B")] = None,
    kinds: Annotated[str | None, Parameter(metavar="A,B")] = None,
    seed: Annotated[Seed | None, Parameter(help="Seed of the trial. Default: a new, secret one each time.")] = None,
    truth: Annotated[Path | None, Parameter(metavar="DIR", group=RESULT)] = None,
    force: Force = False,
    terminal: Terminal = Terminal(),
) -> None:
    """Make data sets with hidden faults.

    For example:

        robolaser challenge new trial --count 24 --robot panda --robot ur5

    Args:
        folder: Folder for the trial.
        robot: A robot or a URDF file; may be given again, they take turns. Default: scorbot_er7.
        like: Data set whose arm, sensor, poses and noise are imitated; may be given again.
        count: Number of data sets.
        poses: Range of the number of poses. Default: 36-72.
        points: Range of the number of points in each pose. Default: 6-12.
        kinds: Kinds of data sets, or names of faults, in equal shares. Default: all but physics, mostly single faults.
        truth: Folder for the truth; keep it to yourself. Default: FOLDER.truth, beside the folder.
    """
    import secrets

    from robolaser.data.importers.robots import find_robot
    from robolaser.data.loading import load
    from robolaser.data.result_folder import results_in
    from robolaser.trials import trial
    from robolaser.trials.building import Ranges

    if like and not robot:
        idle = {"--flange": flange, "--poses": poses, "--points": points}
        refuse("Data sets of --like have their own arm, and as many poses and points", idle)
    usual = Ranges()
    plan = trial.TrialPlan(
        count=count,
        seed=secrets.randbits(48) if seed is None else seed,
        kinds=[name.strip() for name in kinds.split(",")] if kinds else (),
        ranges=Ranges(poses=_range("--poses", poses, usual.poses), points=_range("--points", points, usual.points)),
    )
    sources: list[Robot | Dataset] = [load(path) for path in like]
    sources += [find_robot(name, flange=flange) for name in robot or (() if sources else (USUAL_ARM,))]
    kept = [] if truth is None else ["--truth", str(truth)]
    truth = truth or trial.truth_beside(folder)
    if truth.resolve().is_relative_to(folder.resolve()):
        raise UsageError(f"--truth {truth} is in {folder} and would be given away with it. Keep it elsewhere.")
    writing = results_in(folder, command=NEW, files=[], inputs=like, over=[SCORE], force=force)
    with writing as claim, terminal.progress() as progress:
        names = trial.new(folder, truth, sources, plan, claim=claim, progress=progress)

    def print_names() -> None:
        say(f"{len(names)} blind data sets: {folder / names[0]} to {names[-1]}. Diagnose them, then:")
        say(shlex.join(["robolaser", "challenge", "score", str(folder), *kept]))
        say(f"Keep {truth} to yourself: it holds the truth.")

    terminal.show({"folder": str(folder), "datasets": names}, print_names)


@challenge.command
def score(
    folder: Path,
    /,
    *,
    output: Annotated[Path | None, Parameter(metavar="DIR", group=RESULT)] = None,
    seed: Seed = 1,
    jobs: Count = 1,
    truth: Annotated[Path | None, Parameter(metavar="DIR")] = None,
    force: Force = False,
    terminal: Terminal = Terminal(),
) -> None:
    """Score the diagnoses of a trial against the truth.

    For example:

        robolaser challenge score trial --jobs 4

    Args:
        folder: Folder of the trial.
        output: Folder for score.json. Default: FOLDER.
        jobs: Number of diagnoses at a time.
        truth: Folder of the trial's truth. Default: FOLDER.truth, beside the folder.
    """
    from robolaser.benchmark.executors import Processes
    from robolaser.data.result_folder import json_text, results_in, write_results
    from robolaser.trials import trial

    file, truth = (output or folder) / "score.json", truth or trial.truth_beside(folder)
    writing = results_in(file.parent, command=SCORE, files=[file.name], inputs=[truth], force=force)
    with writing as claim, ExitStack() as stack:
        truths = trial.unseal(folder, truth)
        diagnoses = trial.diagnosis_files(folder, truths, file.parent)
        claim(f"{name}/{trial.DIAGNOSIS}" for name, path in diagnoses.items() if not path.exists())
        executor = stack.enter_context(Processes(jobs))
        progress = stack.enter_context(terminal.progress())
        try:
            trial.diagnose_missing(folder, diagnoses, seed=seed, pool=executor, progress=progress)
        except KeyboardInterrupt:
            made = sum(path.exists() for path in diagnoses.values())
            raise Interrupted(f"Stopped. {made} of {len(diagnoses)} data sets are diagnosed, and stay so.") from None
        scored = trial.score(truths, diagnoses)
        text = json_text(scored)
        write_results(file.parent, {file.name: text})
    terminal.show(text, lambda: say("\n".join([*summary(scored), f"Wrote {file}"])))


def _range(option: str, text: str | None, usual: tuple[int, int]) -> tuple[int, int]:
    """The typed range of a number."""
    if text is None:
        return usual
    match = re.fullmatch(r"(\d+)(?:-(\d+))?", text.strip(), re.ASCII)
    low, high = (int(match[1]), int(match[2] or match[1])) if match else (0, 0)
    if not 0 < low <= high:
        raise UsageError(
            f"{option} {text}: expected two positive whole numbers, the least before the most, as in 36-72."
        )
    return low, high


GROUPS = {
    "one": "one effect, named first and alone",
    "confusable": "one effect, it or its class named",
    "several": "two to four effects, all and no other",
    "none": "nothing wrong, nothing found",
    "outliers": "gross errors only, no other effect",
    "unknown": "unknown cause, reported or harmless",
}
COLUMNS = {
    "by_name": "name",
    "by_class": "class",
    "verdict": "verdict",
    "site_first": "place",
    "sure_and_wrong": "sure, wrong",
    "coverage_95": "intervals",
}


def summary(scored: Mapping[str, Any]) -> list[str]:
    """A score as some twenty lines for a terminal."""
    shares = {title: scored["groups"][group] for group, title in GROUPS.items()} | {
        "class of causes, all right": scored["by_class"],
        "sure of a wrong cause (p >= 0.9)": scored["sure_and_wrong"],
        "95 % intervals that hold the truth": scored["coverage_95"],
    }
    head = (f"data sets: {scored['worlds']}", "right", "share", "95 %")
    lines = aligned([head, *map(_share, shares, shares.values())], str.rjust)
    lines += [""]
    kinds = [
        (kind, str(part["worlds"]), *(f"{one['share']:.0%}" if one["of"] else "-" for one in map(part.get, COLUMNS)))
        for kind, part in scored["kinds"].items()
    ]
    return lines + aligned([("kind", "data sets", *COLUMNS.values()), *kinds], str.rjust)


def _share(title: str, part: Mapping[str, Any]) -> tuple[str, ...]:
    if not part["of"]:
        return title, "-", "", ""
    low, high = part["ci95"]
    return title, f"{part['right']}/{part['of']}", f"{part['share']:.1%}", f"{low:.0%}..{high:.0%}"
