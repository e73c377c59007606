"""robolaser simulate: a data set of a simulated cell."""

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from robolaser.commands.terminal import RESULT, Count, Flange, Force, NoiseOptions, Seed, Terminal, refuse, say
from robolaser.data.sensor_format import Mount


def simulate(
    *,
    robot: Annotated[str, Parameter(metavar="NAME_OR_URDF")],
    flange: Flange = None,
    output: Annotated[Path, Parameter(metavar="DATASET", group=RESULT)],
    sensor: Literal["stripe", "camera", "point", "pose", "socket", "profile", "stripe+camera", "motion"] = "stripe",
    mount: Mount = "flange",
    poses: Count | None = None,
    points: Count | None = None,
    repeats: Count = 1,
    sessions: Count = 1,
    noise: NoiseOptions = NoiseOptions(),
    unplaced: bool = False,
    effects: Annotated[tuple[str, ...], Parameter(name="--effect", metavar="NAME[:WHERE]=SIZE")] = (),
    seed: Seed = 1,
    force: Force = False,
    terminal: Terminal = Terminal(),
) -> None:
    """Simulate a data set with noise and effects of your choice.

    For example:

        robolaser simulate --robot scorbot_er7 --output cell --effect backlash:joint_2=0.002
        robolaser simulate --robot panda --sensor point --poses 60 --output cell

    Args:
        robot: A robot of `robolaser list robots`, or a URDF file.
        output: Folder for the data set.
        sensor: Kind of sensor; stripe+camera is a scanner whose images show a board; motion is a log of the arm itself.
        mount: Carrier of a camera or a profile sensor; the board or the balls are at the other end.
        poses: Number of poses, in each session. Default: 40.
        points: Points in each pose. Default: 12 of a stripe, 35 corners, 3 reflectors, sockets or balls, 1 body.
        repeats: Number of shots in each pose.
        sessions: Number of sessions with other positions of base, target or sockets; of series of a motion (1 means 6).
        unplaced: Do not state the pose of the target.
        effects: Add one of `robolaser list effects`, with its size in SI units; may be given again.
    """
    from robolaser.data.importers.robots import find_robot
    from robolaser.data.result_folder import results_in, write_results
    from robolaser.data.stated_noise import Noise
    from robolaser.data.writing import FOLDER, files_of, texts_of
    from robolaser.model.sensors.in_cell import Mounting
    from robolaser.motion.reading import MOTION_FOLDER, motion_texts
    from robolaser.motion.simulation import simulate_motion
    from robolaser.simulation import CellOptions, sizes_of
    from robolaser.simulation import simulate as simulated

    if sensor == "motion":
        idle = {"--poses": poses, "--points": points, "--repeats": repeats > 1, "--mount": mount != "flange",
                "--unplaced": unplaced, "the noise": noise.typed}  # fmt: skip
        refuse("A log of a moving arm has --sessions and --effect only", idle)
    files = MOTION_FOLDER if sensor == "motion" else FOLDER
    inputs = [*filter(Path.is_file, [Path(robot)])]
    writing = results_in(output, command="simulate", files=files, inputs=inputs, force=force)
    with writing as claim, terminal.progress():
        arm, name = find_robot(robot, flange=flange), output.resolve().name
        sizes = sizes_of(effects)
        if sensor == "motion":
            log = simulate_motion(arm, series=sessions if sessions > 1 else 6, effects=sizes, seed=seed, name=name)
            counts = {"series": len(log.series), "rows": len(log)}
            write_results(output, dict(motion_texts(log)))
        else:
            made = simulated(
                arm,
                kind=sensor,
                poses=poses or 40,
                points=points,
                noise=Noise(**noise.typed) if noise.typed else None,
                effects=sizes,
                seed=seed,
                options=CellOptions(repeats=repeats, sessions=sessions, placed=not unplaced, mount=mount, name=name),
            )
            dataset = made.dataset
            terminal.warn(*noise.unused(dataset))
            if not isinstance(dataset.options, Mounting):
                refuse("Only a camera and a profile sensor stand in the cell", {"--mount": mount != "flange"})
            counts = {"poses": len(dataset.poses), "points": len(dataset.points)}
            claim(files_of(dataset))
            write_results(output, texts_of(dataset))
    (groups, number), (rows, count) = counts.items()
    terminal.show(
        {"dataset": str(output), "robot": arm.name, **counts},
        lambda: say(f"{count} {rows} in {number} {groups} of {arm.name}. Wrote {output}"),
    )
