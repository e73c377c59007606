"""robolaser simulate: a data set as the real cell would give it."""

from functools import partial
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Group, Parameter

from robolaser.commands.terminal import RESULT, TERMINAL, Count, Force, Seed, Terminal, say, stated
from robolaser.errors import UsageError

NOISE = Group("Noise, one standard deviation", sort_key=0)
Deviation = Annotated[float | None, Parameter(metavar="STD", group=NOISE)]


def simulate(
    *,
    robot: Annotated[str, Parameter(metavar="NAME_OR_URDF")],
    flange: Annotated[str | None, Parameter(metavar="FRAME")] = None,
    output: Annotated[Path, Parameter(metavar="DATASET", group=RESULT)],
    sensor: Literal["stripe", "camera", "point", "pose", "socket", "profile", "stripe+camera", "motion"] = "stripe",
    mount: Literal["flange", "base"] = "flange",
    poses: Count = 40,
    points: Count | None = None,
    repeats: Count = 1,
    sessions: Count = 1,
    pixel_px: Deviation = None,
    target_m: Deviation = None,
    joint_rad: Deviation = None,
    point_m: Deviation = None,
    angle_rad: Deviation = None,
    unplaced: bool = False,
    effects: Annotated[tuple[str, ...], Parameter(name="--effect", metavar="NAME[:WHERE]=SIZE")] = (),
    paper: bool = False,
    seed: Seed = 1,
    force: Force = False,
    terminal: Terminal = TERMINAL,
) -> None:
    """Simulate a data set with noise and effects of your choice.

    For example:

        robolaser simulate --robot scorbot_er7 --output cell --effect backlash:joint_2=0.002
        robolaser simulate --robot panda --sensor point --poses 60 --output cell

    Args:
        robot: A robot of `robolaser list robots`, or a URDF file.
        flange: Frame of a URDF file that carries the sensor.
        output: Folder for the data set.
        sensor: Kind of sensor; stripe+camera is a scanner whose images show a board; motion is a log of the arm itself.
        mount: Carrier of a camera or a profile sensor; the board or the balls are at the other end.
        poses: Number of poses, in each session.
        points: Points in each pose. Default: 12 of a stripe, 35 corners, 3 reflectors, sockets or balls, 1 body.
        repeats: Number of shots in each pose.
        sessions: Number of sessions with other positions of base, target or sockets; series of a motion, 6 by default.
        pixel_px: Of a pixel coordinate.
        target_m: Of a target point's coordinate.
        joint_rad: Of a joint angle.
        point_m: Of a coordinate that a tracker or a profile sensor measures.
        angle_rad: Of a tracked body's rotation, about each axis.
        unplaced: Do not state the pose of the target.
        effects: Add one of `robolaser list effects`, with its size in SI units; may be given again.
        paper: Repeat the experiment of Lee et al. 2004: 25 points, 5 poses.
        seed: Seed of poses and noise.
        force: Overwrite an earlier data set.
    """
    from robolaser.data.importers.robots import find_robot
    from robolaser.data.result_folder import results_in, write_results
    from robolaser.data.stated_noise import Noise
    from robolaser.data.writing import FOLDER, files_of, texts_of
    from robolaser.model.sensors.in_cell import Mounting
    from robolaser.motion.reading import MOTION_FOLDER, motion_texts
    from robolaser.motion.simulation import simulate_motion
    from robolaser.simulation import CellOptions, sizes_of
    from robolaser.simulation import paper as paper_experiment
    from robolaser.simulation import simulate as simulated

    typed_noise = stated(
        pixel_px=pixel_px, target_m=target_m, joint_rad=joint_rad, point_m=point_m, angle_rad=angle_rad
    )
    fixed = {
        "--sensor": sensor != "stripe",
        "--mount": mount != "flange",
        "--poses": poses != 40,
        "--points": points is not None,
        "--repeats": repeats != 1,
        "--sessions": sessions != 1,
        "--unplaced": unplaced,
        **{f"--{name.replace('_', '-')}": True for name in typed_noise},
    }
    clashing = [option for option, changed in fixed.items() if changed]
    if paper and clashing:
        raise UsageError(f"--paper fixes what {', '.join(clashing)} would change: leave out one or the other.")
    files = MOTION_FOLDER if sensor == "motion" else FOLDER
    with results_in(output, command="simulate", files=files, force=force) as claim:
        arm, name = find_robot(robot, flange=flange), output.resolve().name
        sizes = sizes_of(effects)
        if sensor == "motion":
            log = simulate_motion(arm, series=sessions if sessions > 1 else 6, effects=sizes, seed=seed, name=name)
            counts = {"series": len(log.series), "rows": len(log)}
            write_results(output, dict(motion_texts(log)))
        else:
            make = partial(paper_experiment, arm)
            if not paper:
                noise = Noise(**typed_noise) if typed_noise else None
                options = CellOptions(repeats=repeats, sessions=sessions, placed=not unplaced, mount=mount, name=name)
                make = partial(simulated, arm, kind=sensor, poses=poses, points=points, noise=noise, options=options)
            dataset = make(effects=sizes, seed=seed).dataset
            if mount != "flange" and not isinstance(dataset.options, Mounting):
                raise UsageError(f"--mount {mount} is only for a camera or a profile sensor: leave it out.")
            counts = {"poses": len(dataset.poses), "points": len(dataset.points)}
            claim(files_of(dataset))
            write_results(output, texts_of(dataset))
    (groups, number), (rows, count) = counts.items()
    terminal.show(
        {"dataset": str(output), "robot": arm.name, **counts},
        lambda: say(f"{count} {rows} in {number} {groups} of {arm.name}. Wrote {output}"),
    )
