"""robolaser plan: effects that poses or motions could show, before any measurement."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from robolaser.commands.terminal import Count, Flange, NoiseOptions, Seed, Terminal, refuse
from robolaser.data.sensor_format import Mount
from robolaser.errors import DataError, UsageError, near

if TYPE_CHECKING:
    from robolaser.data.dataset import Dataset


def plan(
    poses: Path,
    /,
    *,
    robot: Annotated[str | None, Parameter(metavar="NAME_OR_URDF")] = None,
    flange: Flange = None,
    sensor: Annotated[str | None, Parameter(metavar="KIND")] = None,
    mount: Mount = "flange",
    points: Count | None = None,
    noise: NoiseOptions = NoiseOptions(),
    seed: Seed = 1,
    terminal: Terminal = Terminal(),
) -> None:
    """Show which effects could be detected and distinguished at planned poses or in planned motions.

    For example:

        robolaser plan poses.csv --robot ur5e --sensor camera --pixel-px 0.1 --joint-rad 2e-5
        robolaser plan recording

    Args:
        poses: A poses.csv with joint angles, or a data set. The points of a data set are used as measured; of the log
            of a moving arm, only the commands.
        robot: A robot of `robolaser list robots`, or a URDF file, for a poses.csv.
        sensor: Kind of sensor, for a poses.csv: one of `robolaser list sensors`.
        mount: Carrier of the camera.
        points: Number of points in each pose.
    """
    from dataclasses import replace

    from robolaser.data.loading import load
    from robolaser.diagnosis.pose_plan import examine_plan
    from robolaser.model.sensors.in_cell import Mounting
    from robolaser.motion.plan import plan_motion
    from robolaser.motion.reading import is_motion, load_motion
    from robolaser.report import motion, pose_plan
    from robolaser.report.console import print_document

    if not poses.exists():
        raise DataError(f"{poses} does not exist. Name a poses.csv, or the folder of a data set.", file=poses)
    if poses.is_dir():
        given = {"--robot": robot, "--flange": flange, "--sensor": sensor, "--mount": mount != "flange"}
        refuse(f"{poses} is a data set, which contains that", given)
        if is_motion(poses):
            refuse(f"{poses} is the log of a moving arm", {"--points": points, "the noise": noise.typed})
            with terminal.progress():
                motions = plan_motion(load_motion(poses, planned=True))
            terminal.show(motions.to_dict(), lambda: print_document(motion.plan_document(motions)))
            return
        dataset = load(poses)
        refuse(f"The points of {poses} are used as measured", {"--points": points and len(dataset.points)})
    else:
        if robot is None or sensor is None:
            raise UsageError(f"State --robot and --sensor, which {poses} does not contain.")
        dataset = _of_table(poses, robot, flange, sensor)
        _warn_of_collisions(dataset, terminal)
    terminal.warn(*noise.unused(dataset))
    dataset = replace(dataset, noise=replace(dataset.noise, **noise.typed))
    terminal.warn(*dataset.warnings)
    with terminal.progress():
        found = examine_plan(dataset, points=points, mount=mount, seed=seed)
    if not isinstance(found.dataset.options, Mounting):
        refuse("Only a camera and a profile sensor stand in the cell", {"--mount": mount != "flange"})
    terminal.show(found.to_dict(), lambda: print_document(pose_plan.document(found)))


def _warn_of_collisions(dataset: "Dataset", terminal: Terminal) -> None:
    """Warn of poses at which the arm would collide with itself."""
    from robolaser.cell.plan_validation import collision_model, collisions
    from robolaser.data.cell_config import Limits

    bodies = collision_model(dataset, Limits())
    for name, q in zip(dataset.poses.names, dataset.arm[1], strict=True):
        for _, hit in collisions(bodies, 0.0, q[None]):
            terminal.warn(
                f"pose {name}: {hit}. Leave it out if links are as thick as that (see [limits] of cell.toml)."
            )


def _of_table(file: Path, robot: str, flange: str | None, sensor: str) -> "Dataset":
    """The poses of a separate poses.csv."""
    from robolaser.data.data_tables import read_poses
    from robolaser.data.dataset import Dataset
    from robolaser.data.importers.robots import find_robot
    from robolaser.model.sensors import sensors

    if sensor not in sensors():
        raise UsageError(f"No sensor '{sensor}'.{near(sensor, sensors())}")
    arm = find_robot(robot, flange=flange)
    read, odd = read_poses(file, arm)
    return Dataset(file.stem, read, kind=sensor, robot=arm, warnings=tuple(odd))
