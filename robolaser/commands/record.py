"""robolaser record: drive the arm from pose to pose and take images."""

import math
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager, nullcontext, suppress
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, final

from cyclopts import Group, Parameter
from cyclopts.validators import mutually_exclusive

from robolaser.commands.terminal import Count, PositiveOption, Seed, Terminal, ended_as_by_hand, say
from robolaser.errors import PlanError, UsageError

if TYPE_CHECKING:
    from robolaser.arrays import Progress
    from robolaser.cell.arm import Arm
    from robolaser.cell.camera import Camera
    from robolaser.cell.clock import Clock
    from robolaser.cell.recording_writer import RecordingWriter
    from robolaser.cell.route import Waypoint
    from robolaser.data.cell_config import Cell

RUN_UP_DEG = 3.0  # more than the lost motion of any gearbox
WHERE = Group("Poses, from exactly one of", sort_key=-3, validator=mutually_exclusive)
GOING = Group("Whether the arm moves", sort_key=-1, validator=mutually_exclusive)
THERE = Group("Result", sort_key=1, validator=mutually_exclusive)


@final
@Parameter(name="*")
@dataclass(frozen=True)
class RouteOptions:
    """Where the arm goes.

    Attributes:
        poses: Go to the poses of this table: columns q_<joint>, and pose for their names.
        plan: Go to N poses that see the board and are the most informative.
        next_poses: Go to the next poses that a diagnosis recommends.
        watch: Take N images while the arm is moved by hand or by another program; Ctrl-C ends it earlier.
        separate: With --plan, also separate this effect from all others; may be given again.
        repeats: Number of shots at each pose. Default: 1.
        both_ways: Visit each pose twice, all joints from below and from above.
        run_up: With --both-ways, the distance from which the joints approach. Default: 3.
    """

    poses: Annotated[Path | None, Parameter(metavar="POSES.csv", group=WHERE)] = None
    plan: Annotated[Count | None, Parameter(group=WHERE)] = None
    next_poses: Annotated[Path | None, Parameter(name="--next", metavar="DIAGNOSIS.json", group=WHERE)] = None
    watch: Annotated[Count | None, Parameter(group=WHERE)] = None
    separate: Annotated[tuple[str, ...], Parameter(metavar="EFFECT[:WHERE]")] = ()
    repeats: Count | None = None
    both_ways: bool = False
    run_up: Annotated[PositiveOption | None, Parameter(metavar="DEGREES")] = None
    seed: Annotated[Seed | None, Parameter(help="Seed of --plan. Default: 1.")] = None

    @property
    def files(self) -> list[Path]:
        """Its input files."""
        return [file for file in (self.poses, self.next_poses) if file is not None]

    def check(self, *, resume: bool) -> None:
        """Check that poses are stated and that every option has an effect.

        Raises:
            UsageError: They are not, or one has none.
        """
        is_named = self.plan is not None or bool(self.files)
        if not is_named and not resume and self.watch is None:
            raise UsageError(
                "State where the arm should go: --poses POSES.csv, --plan N or --next DIAGNOSIS.json. If others move"
                " it, use --watch N."
            )
        _refuse_idle("--both-ways", self.both_ways, "--poses, --plan or --next", is_named)
        _refuse_idle("--seed", self.seed is not None, "--plan", self.plan is not None)
        _refuse_idle("--separate", bool(self.separate), "--plan", self.plan is not None)
        _refuse_idle("--run-up", self.run_up is not None, "--both-ways", self.both_ways)

    def waypoints(self, cell: "Cell") -> "tuple[Waypoint, ...] | None":
        """The poses in their order; None where none are stated."""
        from robolaser.cell.plan_validation import RouteCheck
        from robolaser.cell.route import both_ways, from_diagnosis, from_table, numbered
        from robolaser.estimation.optimal_poses import planned

        run_up = math.radians(self.run_up or RUN_UP_DEG) if self.both_ways else 0.0
        if self.plan is not None:
            may, seed = partial(RouteCheck.of(cell).allows, run_up=run_up), 1 if self.seed is None else self.seed
            chosen = planned(cell.description, count=self.plan, effects=self.separate, allowed=may, seed=seed)
            waypoints = numbered(chosen)
        elif self.poses is not None:
            waypoints = from_table(self.poses, cell.robot)
        elif self.next_poses is not None:
            waypoints = from_diagnosis(self.next_poses, cell.robot)
        else:
            return None
        return both_ways(waypoints, run_up) if self.both_ways else waypoints


def record(
    cell: Path,
    /,
    *,
    route: RouteOptions = RouteOptions(),
    port: Annotated[str | None, Parameter(metavar="URL")] = None,
    camera: Annotated[str | None, Parameter(metavar="SOURCE")] = None,
    diagnose: bool = False,
    dry_run: Annotated[bool, Parameter(group=GOING)] = False,
    move: Annotated[bool, Parameter(group=GOING)] = False,
    output: Annotated[Path, Parameter(metavar="RECORDING")],
    resume: Annotated[bool, Parameter(group=THERE)] = False,
    force: Annotated[bool, Parameter(group=THERE)] = False,
    confirm_position: bool = False,
    terminal: Terminal = Terminal(),
) -> None:
    """Drive a cell's arm from pose to pose and take images; nothing moves without --move.

    For example:

        robolaser record cell --plan 30 --output recording --dry-run
        robolaser record cell --plan 30 --output recording --move
        robolaser record cell --watch 200 --output recording

    Args:
        cell: Folder with dataset.toml, cell.toml and the URDF.
        output: Folder for the recording.
        port: Port of the arm, instead of that in cell.toml.
        camera: Camera, instead of that in cell.toml.
        diagnose: After each pose, show the diagnosis of all poses so far.
        dry_run: Print and check the plan; open no port and no camera.
        move: Let the arm move.
        resume: Continue a recording that was interrupted.
        force: Overwrite an earlier recording.
        confirm_position: With --resume, trust the controller's position although it differs from the recorded one.
    """
    from robolaser.cell.arm import arm_class
    from robolaser.cell.recording_writer import RecordingWriter
    from robolaser.data.cell_config import load_cell
    from robolaser.data.result_folder import results_in

    if route.watch is not None and (move or resume or dry_run or route.repeats):
        raise UsageError("--watch moves nothing: leave out --move, --dry-run, --resume and --repeats.")
    route.check(resume=resume)
    _refuse_idle("--confirm-position", confirm_position, "--resume", resume)
    _refuse_idle("--diagnose", diagnose, "--move", move)
    described = _rewired(load_cell(cell), port, camera)
    read = [*described.inputs, *route.files]
    terminal.warn(*described.warnings)
    arm_class(described)
    if route.watch is not None:
        _watch(described, output, route.watch, read, terminal, force=force)
        return
    waypoints = route.waypoints(described)
    if resume:
        writer = RecordingWriter.resume(described, output, waypoints, route.repeats)
    else:
        writer = RecordingWriter(described, output, waypoints or (), route.repeats or 1)
    _print_plan(described, writer.remaining, terminal)
    if dry_run or not writer.remaining:
        terminal.show(_state(writer), lambda: None)
        return
    if not move:
        raise UsageError(
            "Nothing was moved and no port was opened: this is only the plan. Let the arm move with --move."
        )
    with results_in(output, command="record", files=writer.files, inputs=read, over=["extract"], force=force or resume):
        _record(described, writer, terminal, position_confirmed=confirm_position, diagnose=diagnose)


def _refuse_idle(option: str, given: bool, other: str, there: bool) -> None:  # noqa: FBT001 - a table, read in rows
    """Refuse an option that has no effect without another one."""
    if given and not there:
        raise UsageError(f"{option} has no effect without {other}: add that, or leave {option} out.")


def _rewired(cell: "Cell", port: str | None, camera: str | None) -> "Cell":
    """The cell with another port or camera; typed paths are relative to the working directory, not to the cell."""
    if port is not None:
        port = str(Path(port).absolute()) if cell.arm.kind == "replay" else port
        cell = replace(cell, arm=replace(cell.arm, port=port))
    if camera is not None:
        typed = camera if "://" in camera else str(Path(camera).absolute())
        source = int(camera) if camera.isdecimal() else typed
        cell = replace(cell, camera=replace(cell.camera, source=source))
    return cell


def _print_plan(cell: "Cell", waypoints: "Sequence[Waypoint]", terminal: Terminal) -> None:
    """Print each configuration, the time to it and the height of the arm's lowest part there."""
    from robolaser.cell.clock import seconds_for
    from robolaser.cell.failures import joint_text
    from robolaser.cell.plan_validation import RouteCheck, lowest
    from robolaser.cell.route import way

    if not waypoints:
        terminal.print("No pose remains.")
        return
    robot, check = cell.robot, RouteCheck.of(cell)
    names, q = way(waypoints)
    heights = lowest(robot, q, check.tools)
    seconds = [0.0, *(seconds_for(step, cell.limits.speed_rad_s) for step in q[1:] - q[:-1])]
    width = max(4, *map(len, names))
    terminal.print(f"{'pose':<{width}} {' '.join(f'{joint:>10}' for joint in robot.joints)}  way [s]  lowest [m]")
    for name, row, time_s, height in zip(names, q, seconds, heights, strict=True):
        angles = " ".join(f"{joint_text(robot, i, float(value)):>10}" for i, value in enumerate(row))
        terminal.print(f"{name:<{width}} {angles}  {time_s:>7.1f}  {height:>10.3f}")
    terminal.print(f"{len(waypoints)} poses; {sum(seconds):.0f} s on the way between them, and the way to the first.")
    bodies = check.bodies
    boxes = {box.name for box in cell.boxes}
    for pair in bodies.unchecked:
        if boxes & {bodies.bodies[i].name for i in pair}:
            raise PlanError(
                f"Nothing was moved: {bodies.name(pair)} overlap at every position of the arm."
                " Correct [[box]] in cell.toml."
            )
        terminal.warn(f"{bodies.name(pair)} overlap at every position of the arm: not checked against each other.")
    check.check(None, waypoints)


@contextmanager
def _opened(cell: "Cell", terminal: Terminal) -> "Iterator[tuple[Arm, Camera, Clock, Progress]]":
    """The cell's arm and camera, a clock and the progress bar, which are also closed when the program is ended."""
    from robolaser.cell.arm import arm_class
    from robolaser.cell.camera import open_camera
    from robolaser.cell.clock import Clock

    clock = Clock()
    with (
        ended_as_by_hand(),
        terminal.progress() as progress,  # which counts from here: opening a line takes time, too
        closing(open_camera(cell, clock, terminal.warn)) as camera,
        closing(arm_class(cell).open(cell, clock)) as arm,
    ):
        yield arm, camera, clock, progress


def _record(
    cell: "Cell", writer: "RecordingWriter", terminal: Terminal, *, position_confirmed: bool, diagnose: bool
) -> None:
    """Drive to all poses that remain."""
    from robolaser.cell.session import Session
    from robolaser.commands.running_diagnosis import RunningDiagnosis

    with closing(RunningDiagnosis(writer.folder, terminal.print)) if diagnose else nullcontext() as running:
        with _opened(cell, terminal) as (arm, camera, clock, progress):

            def report(what: str) -> None:
                progress(what, writer.done / len(writer.waypoints))

            def recorded(waypoint: "Waypoint") -> None:
                report(waypoint.name)
                if running is not None:
                    running.pose_recorded()

            session = Session(cell, arm, camera, writer, clock, terminal.warn, position_confirmed=position_confirmed)
            session.run(recorded, report)
        if running is not None:
            running.finish()
    terminal.show(
        _state(writer) | ({"diagnosis": running.latest} if running is not None else {}),
        lambda: say(f"Wrote {writer.done} of {len(writer.waypoints)} poses to {writer.folder}"),
    )


def _state(writer: "RecordingWriter") -> dict[str, object]:
    """What is on the disk of a recording, and how many poses are planned in all, as JSON."""
    folder = str(writer.folder) if writer.begun else None
    return {"recording": folder, "poses": writer.done, "planned": len(writer.waypoints)}


def _watch(cell: "Cell", output: Path, count: int, read: "Sequence[Path]", terminal: Terminal, *, force: bool) -> None:
    """Take images while others move the arm."""
    from robolaser.cell.recording_writer import RecordingWriter
    from robolaser.cell.route import pose_names
    from robolaser.cell.session import watch
    from robolaser.data.result_folder import results_in

    names, writer = list[str](), RecordingWriter(cell, output, (), 1)
    files = [*writer.files, *(f"images/{name}.png" for name in pose_names("w", count))]
    with (
        results_in(output, command="record", files=files, inputs=read, over=["extract"], force=force),
        _opened(cell, terminal) as (arm, camera, clock, progress),
    ):

        def report(name: str) -> None:
            names.append(name)
            progress(name, len(names) / count)

        writer.state_quantization_noise(arm.step, terminal.warn)
        with suppress(KeyboardInterrupt):
            watch(arm, camera, writer, clock, count, cell.laser_output, report, cell.camera.settle_s)
    terminal.show(
        {"recording": str(writer.folder), "poses": len(names), "planned": count},
        lambda: say(f"Wrote {len(names)} images of {count} to {writer.folder}"),
    )
