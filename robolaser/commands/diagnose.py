"""robolaser diagnose: why the robot deviates from its model."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from robolaser.commands.terminal import RESULT, TERMINAL, Force, Seed, Terminal, Typed
from robolaser.errors import UsageError


def diagnose(
    dataset: Path,
    /,
    *,
    output: Annotated[Path, Parameter(metavar="DIR", group=RESULT)],
    without: Annotated[tuple[str, ...], Parameter(metavar="EFFECT")] = (),
    validate: Annotated[tuple[Path, ...], Parameter(metavar="DATASET")] = (),
    seed: Seed = 1,
    force: Force = False,
    terminal: Terminal = TERMINAL,
    typed: Typed = "",
) -> None:
    """Find out why the robot deviates from its model: where, through which effects, and by how much.

    For example:

        robolaser diagnose measured --output why
        robolaser diagnose measured --output why --without thermal_drift
        robolaser diagnose measured --output why --validate measured-later

    Args:
        dataset: Folder with dataset.toml, poses.csv and points.csv; or motion.csv, of a moving arm.
        output: Folder for the result.
        without: Remove this effect of `robolaser list effects` from the library; may be given again.
        validate: Test the result on other data of the same arm; may be given again.
        seed: Seed of the random draws.
        force: Overwrite an earlier result.
    """
    from robolaser.data.result_folder import results_in, write_results
    from robolaser.motion.reading import is_motion, load_motion

    if is_motion(dataset):
        if validate:
            raise UsageError(f"{dataset} is the log of a moving arm; --validate predicts measured poses. Leave it out.")
        from robolaser.commands.moving_arm import found_in
        from robolaser.motion.diagnosis import diagnose_motion
        from robolaser.results.motion import MOTION_FILES, MotionResult

        log = load_motion(dataset)
        with results_in(output, command="diagnose", files=MOTION_FILES, inputs=[dataset], force=force):
            moving = found_in(
                log,
                lambda progress: MotionResult(diagnose_motion(log, without=without, seed=seed, progress=progress)),
                output, terminal, typed,
            )  # fmt: skip
        terminal.show(moving.to_dict(), lambda: moving.print(output))
        return
    from robolaser.data.loading import load
    from robolaser.diagnosis import examine
    from robolaser.export.files import is_withheld
    from robolaser.results.diagnosis import DIAGNOSIS_FILES, DiagnosisResult

    data, others = load(dataset), [load(other) for other in validate]
    with results_in(output, command="diagnose", files=DIAGNOSIS_FILES, inputs=[dataset, *validate], force=force):
        with terminal.progress() as progress:
            found = examine(data, seed=seed, without=without, validate=others, progress=progress)
        terminal.warn(*data.warnings)
        result = DiagnosisResult.of(found, seed)
        texts = result.files(command=typed)
        if result.model and is_withheld(result.model):
            terminal.warn(
                "With all that was found, points are still centimetres off: the data set describes the cell wrongly;"
                " only robot.urdf is exported. Check the start values in [parameters], units and signs, and the flange."
            )
        write_results(output, texts)
    terminal.show(texts["diagnosis.json"] or "", lambda: result.print(output))
