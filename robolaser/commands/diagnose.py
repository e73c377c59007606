"""robolaser diagnose: why the robot deviates from its model."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from robolaser.commands.terminal import RESULT, Force, Seed, Terminal, Typed, refuse


def diagnose(
    dataset: Path,
    /,
    *,
    output: Annotated[Path, Parameter(metavar="DIR", group=RESULT)],
    without: Annotated[tuple[str, ...], Parameter(metavar="EFFECT")] = (),
    validate: Annotated[tuple[Path, ...], Parameter(metavar="DATASET")] = (),
    seed: Seed = 1,
    force: Force = False,
    terminal: Terminal = Terminal(),
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
    """
    from robolaser import api
    from robolaser.data.loading import load
    from robolaser.data.result_folder import results_in, write_results
    from robolaser.export.files import is_withheld
    from robolaser.motion.reading import is_motion
    from robolaser.results.diagnosis import DIAGNOSIS_FILES, DiagnosisResult
    from robolaser.results.motion import MOTION_FILES

    moves = is_motion(dataset)
    refuse(f"{dataset} is the log of a moving arm, without measured poses", {"--validate": moves and validate})
    data, others = api.load(dataset), [load(other) for other in validate]
    terminal.warn(*data.warnings)
    files = MOTION_FILES if moves else DIAGNOSIS_FILES
    with results_in(output, command="diagnose", files=files, inputs=[dataset, *validate], force=force):
        with terminal.progress() as progress:
            result = api.diagnose(data, seed=seed, without=without, validate=others, progress=progress)
        texts = result.files(command=typed)
        write_results(output, texts)
    if isinstance(result, DiagnosisResult) and result.model and is_withheld(result.model):
        terminal.warn(
            "With all that was found, points are still centimetres off: the data set describes the cell wrongly;"
            " only robot.urdf is exported. Check the start values in [parameters], units and signs, and the flange."
        )
    terminal.show(texts["diagnosis.json"] or "", lambda: result.print(output))
