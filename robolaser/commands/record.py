"""robolaser record: drive the arm from pose to pose and take images."""

import argparse
import math
import signal
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, ClassVar, Never, final

from robolaser.commands.argument_types import count, positive, seed
from robolaser.commands.command import Command, make_folder, progress_bar, warn
from robolaser.errors import NothingMoved, NowhereToGo, OptionIdle, PlanUnsafe

if TYPE_CHECKING:
    from robolaser.cell.recording_writer import Journal
    from robolaser.cell.route import Visit
    from robolaser.data.cell_config import Cell
    from robolaser.geometry.kinematics import Robot

RUN_UP_DEG = 3.0  # more than any gearbox's lost motion
SEED = 1
SOURCES = ("poses", "plan", "next")
NEEDS = {"seed": "plan", "separate": "plan", "run_up": "both_ways"}
"""Options that say nothing without another."""


@final
class Record(Command):
    """Takes a recording."""

    name: ClassVar[str] = "record"
    summary: ClassVar[str] = "drive a cell's arm from pose to pose and take images; nothing moves without --move"

    def declare(self, parser: argparse.ArgumentParser) -> None:
        """Say what can be given to it."""
        parser.add_argument("cell", metavar="CELL", type=Path, help="folder with dataset.toml, cell.toml and the URDF")
        parser.add_argument("--output", metavar="RECORDING", type=Path, required=True, help="folder for the recording")
        where = parser.add_mutually_exclusive_group()
        where.add_argument(
            "--poses", metavar="POSES.csv", type=Path, help="go to these: columns q_<joint>, and pose for names"
        )
        where.add_argument("--plan", metavar="N", type=count, help="go to N poses that see the board and tell the most")
        where.add_argument(
            "--next", metavar="DIAGNOSIS.json", type=Path, help="go to the poses that a diagnosis asks for"
        )
        parser.add_argument(
            "--separate",
            metavar="EFFECT[:WHERE]",
            action="append",
            help="with --plan: also tell this effect from all else; may be given again",
        )
        parser.add_argument("--repeats", metavar="N", type=count, help="shots at each pose; default: 1")
        parser.add_argument(
            "--both-ways", action="store_true", help="visit each pose twice, all joints from below and from above"
        )
        parser.add_argument(
            "--run-up",
            metavar="DEGREES",
            type=positive,
            help=f"with --both-ways: from how far; default: {RUN_UP_DEG:g}",
        )
        parser.add_argument("--port", metavar="URL", help="of the arm, in place of cell.toml's")
        parser.add_argument("--camera", metavar="SOURCE", help="in place of cell.toml's")
        parser.add_argument("--seed", metavar="N", type=seed, help=f"of --plan; default: {SEED}")
        going = parser.add_mutually_exclusive_group()
        going.add_argument("--dry-run", action="store_true", help="print the plan, check it, open nothing")
        going.add_argument("--move", action="store_true", help="let the arm move")
        there = parser.add_mutually_exclusive_group()
        there.add_argument("--resume", action="store_true", help="go on with a recording that was interrupted")
        there.add_argument("--force", action="store_true", help="overwrite a recording that is there")

    def run(self, args: argparse.Namespace) -> None:
        """Check, and only then move."""
        from robolaser.cell.arms import language_of  # noqa: PLC0415
        from robolaser.cell.recording_writer import Journal  # noqa: PLC0415
        from robolaser.data.cell_config import load_cell  # noqa: PLC0415 - `--help` must not pay for physics

        _see_sense(args)
        cell = _as_asked(load_cell(args.cell), args)
        robot = cell.robot
        for sentence in cell.warnings:
            warn(sentence)
        language_of(cell)
        visits = _visits(cell, robot, args) if _asked(args) else None
        if args.resume:
            journal = Journal.resume(cell, robot, args.output, visits, args.repeats)
            remaining = journal.remaining
        else:
            remaining = visits or ()
        _print_plan(cell, robot, remaining)
        if args.dry_run or not remaining:
            return
        if not args.move:
            raise NothingMoved()
        if not args.resume:
            make_folder(args.output)
            journal = Journal.begin(cell, robot, args.output, remaining, args.repeats or 1, force=args.force)
        _record(cell, robot, journal)


def _asked(args: argparse.Namespace) -> list[str]:
    """The sources of poses that were named."""
    return [name for name in SOURCES if getattr(args, name) is not None]


def _see_sense(args: argparse.Namespace) -> None:
    if not _asked(args):
        if not args.resume:
            raise NowhereToGo()
        if args.both_ways:
            raise OptionIdle("--both-ways", "poses that are named")
    for option, other in NEEDS.items():
        if getattr(args, option) is not None and not getattr(args, other):
            raise OptionIdle(f"--{option.replace('_', '-')}", f"--{other.replace('_', '-')}")


def _as_asked(cell: "Cell", args: argparse.Namespace) -> "Cell":
    """The cell with another port or camera; paths typed are from here, not from the cell's folder."""
    if args.port is not None:
        port = str(Path(args.port).absolute()) if cell.arm.kind == "replay" else args.port
        cell = replace(cell, arm=replace(cell.arm, port=port))
    if args.camera is not None:
        source: str | int = args.camera
        if args.camera.isdecimal():
            source = int(args.camera)
        elif "://" not in args.camera:
            source = str(Path(args.camera).absolute())
        cell = replace(cell, camera=replace(cell.camera, source=source))
    return cell


def _visits(cell: "Cell", robot: "Robot", args: argparse.Namespace) -> "tuple[Visit, ...]":
    from robolaser.cell.plan_validation import allowed  # noqa: PLC0415
    from robolaser.cell.route import both_ways, from_diagnosis, from_table, numbered  # noqa: PLC0415

    run_up = math.radians(args.run_up or RUN_UP_DEG) if args.both_ways else 0.0
    if args.poses is not None:
        visits = from_table(args.poses, robot)
    elif args.next is not None:
        visits = from_diagnosis(args.next, robot)
    else:
        from robolaser.estimation.optimal_poses import planned  # noqa: PLC0415

        may = allowed(cell.description, cell.limits, run_up)
        wanted = args.separate or ()
        number = SEED if args.seed is None else args.seed
        q = planned(cell.description, count=args.plan, effects=wanted, allowed=may, seed=number)
        visits = numbered(q)
    return both_ways(visits, run_up) if args.both_ways else visits


def _print_plan(cell: "Cell", robot: "Robot", visits: "Sequence[Visit]") -> None:
    """Each place, the time to it and the height of the arm's lowest part there.

    Raises:
        PlanUnsafe: It breaks the cell's limits.
    """
    from robolaser.cell.angles import shown  # noqa: PLC0415
    from robolaser.cell.pace import seconds_for  # noqa: PLC0415
    from robolaser.cell.plan_validation import carried, lowest, violations  # noqa: PLC0415
    from robolaser.cell.route import way  # noqa: PLC0415

    if not visits:
        print("No pose remains.")
        return
    names, q = way(visits)
    tools = carried(cell.description)
    heights = lowest(robot, q, tools)
    seconds = [0.0, *(seconds_for(step, cell.limits.speed_rad_s) for step in q[1:] - q[:-1])]
    width = max(4, *map(len, names))
    print(f"{'pose':<{width}} {' '.join(f'{joint:>10}' for joint in robot.joints)}  way [s]  lowest [m]")
    for name, row, time_s, height in zip(names, q, seconds, heights, strict=True):
        angles = " ".join(f"{shown(robot, i, float(value)):>10}" for i, value in enumerate(row))
        print(f"{name:<{width}} {angles}  {time_s:>7.1f}  {height:>10.3f}")
    print(f"{len(visits)} poses; {sum(seconds):.0f} s on the way between them, and the way to the first.")
    broken = violations(robot, cell.limits, tools, None, names, q)
    if broken:
        run_up = any(visit.approach is not None for visit in visits)
        raise PlanUnsafe([str(violation) for violation in broken], run_up=run_up)


def _record(cell: "Cell", robot: "Robot", journal: "Journal") -> None:
    import cv2  # noqa: PLC0415

    from robolaser.cell.arms import open_arm  # noqa: PLC0415
    from robolaser.cell.cameras import open_camera  # noqa: PLC0415
    from robolaser.cell.clock import WallClock  # noqa: PLC0415
    from robolaser.cell.session import Session  # noqa: PLC0415

    cv2.utils.logging.setLogLevel(
        cv2.utils.logging.LOG_LEVEL_SILENT
    )  # what OpenCV says of a lost camera is said again in a sentence
    clock = WallClock()
    planned = len(journal.visits)
    with (
        _ended_as_by_hand(),
        progress_bar() as progress,  # which counts from here: to open a line takes its time too
        open_camera(cell, clock, warn) as camera,
        open_arm(cell, clock) as arm,
    ):

        def tell(what: str) -> None:
            progress(what, journal.done / planned)

        session = Session(cell, robot, arm, camera, journal, clock, warn)
        session.run(lambda visit: tell(visit.name), tell)
    print(f"Wrote {journal.done} of {planned} poses to {journal.folder}")


@contextmanager
def _ended_as_by_hand() -> Iterator[None]:
    """Whoever ends the program (a closed terminal, the system) stops the arm as Ctrl-C does."""

    def stop(number: int, frame: FrameType | None) -> Never:
        raise KeyboardInterrupt

    ends = [signal.SIGTERM] if sys.platform == "win32" else [signal.SIGTERM, signal.SIGHUP]
    before = {end: signal.signal(end, stop) for end in ends}
    try:
        yield
    finally:
        for end, action in before.items():
            signal.signal(end, action)
