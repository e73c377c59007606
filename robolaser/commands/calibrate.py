"""robolaser calibrate: from points to parameters."""

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from robolaser.commands.terminal import RESULT, Count, Force, ResultFlag, Seed, Terminal, Typed, refuse
from robolaser.errors import Interrupted, OutputError


def calibrate(
    dataset: Path,
    /,
    *,
    output: Annotated[Path, Parameter(metavar="DIR", group=RESULT)],
    algorithm: Annotated[str | None, Parameter(metavar="NAME")] = None,
    polish: Annotated[bool, Parameter(negative="--no-polish")] = True,
    weights: Literal["plain", "noise"] = "plain",
    effects: Annotated[tuple[str, ...], Parameter(name="--with", metavar="EFFECT[:WHERE]")] = (),
    generations: Count | None = None,
    seed: Seed = 1,
    resume: ResultFlag = False,
    force: Force = False,
    terminal: Terminal = Terminal(),
    typed: Typed = "",
) -> None:
    """Estimate the parameters of sensor, mount, base, target, tool or sockets from measurements.

    For example:

        robolaser calibrate measured --output result
        robolaser calibrate measured --output result --with laser_roll --with backlash:joint_2

    Args:
        dataset: Folder with dataset.toml, poses.csv and points.csv; or motion.csv, of a moving arm.
        output: Folder for the result.
        algorithm: Search with one of `robolaser list algorithms`. Default: screening for a stripe scanner, else none.
        polish: Refine the result of the search by least squares.
        weights: Minimise J, the sum of squares (plain), or weight each row by its noise.
        effects: Add an effect to the model; may be given again.
        generations: Number of generations of a genetic algorithm.
        resume: Continue a stopped search.
    """
    from robolaser import api
    from robolaser.algorithms.registry import POLISH_ONLY, SCREENING
    from robolaser.calibration.calibrate import calibrate as find
    from robolaser.calibration.plan import GENERATIONS, Plan
    from robolaser.calibration.pymoo_search import CHECKPOINT
    from robolaser.data.result_folder import results_in, write_results
    from robolaser.motion.reading import is_motion
    from robolaser.results.calibration import CALIBRATION_FILES, CalibrationResult
    from robolaser.results.motion import MOTION_CALIBRATION_FILES

    is_stopped = (output / CHECKPOINT).exists()
    if moves := is_motion(dataset):
        idle = {"--algorithm": algorithm, "--generations": generations, "--resume": resume, "--no-polish": not polish,
                "--weights": weights != "plain"}  # fmt: skip
        refuse("A log of a moving arm is fitted by least squares", idle)
    if is_stopped and not (resume or force):
        raise OutputError(
            f"{output} holds a search that was stopped. Continue it with --resume, or start over with --force."
        )
    if generations and algorithm in (None, SCREENING, POLISH_ONLY):
        terminal.warn(f"--generations has no effect: {algorithm or 'the default search'} has no generations.")
    if resume and not is_stopped:
        terminal.warn(f"--resume has no effect: {output} holds no search that was stopped.")
    data, files = api.load(dataset), MOTION_CALIBRATION_FILES if moves else CALIBRATION_FILES
    plan = Plan(algorithm, polish, weights, effects, seed=seed, generations=generations or GENERATIONS)
    with results_in(output, command="calibrate", files=files, state=(CHECKPOINT,), inputs=[dataset], force=force):
        try:
            with terminal.progress() as progress:
                result = (
                    api.calibrate(data, plan, progress=progress)
                    if moves
                    else CalibrationResult.of(find(data, plan, state=output, resume=resume, progress=progress))
                )
            terminal.warn(*(data.warnings if moves else result.warnings))
            texts = result.files(command=typed)
            write_results(output, texts)
        except KeyboardInterrupt:
            kept = (output / CHECKPOINT).exists()
            state = f"The search's state is in {output}: continue with --resume." if kept else "Nothing was written."
            raise Interrupted(f"Stopped. {state}") from None
        (output / CHECKPOINT).unlink(missing_ok=True)
    terminal.show(texts["calibration.json"] or "", lambda: result.print(output))
