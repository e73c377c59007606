"""The functions of the package: they take a data set or its folder, and effects by class or by name."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from robolaser.arrays import Progress
from robolaser.calibration import calibrate as fitting
from robolaser.calibration.plan import Plan
from robolaser.data.dataset import Dataset
from robolaser.data.importers import ImportOptions, importer_for
from robolaser.data.loading import load as load_dataset
from robolaser.diagnosis.data_check import DataCheck, check_data
from robolaser.diagnosis.pipeline import examine
from robolaser.diagnosis.pose_plan import PosePlan, examine_plan
from robolaser.errors import UsageError, check_seed
from robolaser.model.effects import EFFECTS, unknown_effect
from robolaser.model.effects.effect import Effect
from robolaser.motion.log import MotionLog
from robolaser.motion.reading import is_motion, load_motion
from robolaser.results.calibration import CalibrationResult
from robolaser.results.diagnosis import DiagnosisResult

if TYPE_CHECKING:
    from robolaser.benchmark.result import BenchmarkResult
    from robolaser.results.comparison import ComparisonResult
    from robolaser.results.motion import MotionCalibrationResult, MotionResult

Data = Dataset | str | Path  # a data set, or its folder
Named = type[Effect] | str  # an effect's class or its name


def load(folder: str | Path) -> Any:
    """Read and check a data set, or a log of a moving arm.

    Args:
        folder: Contains dataset.toml, poses.csv and, unless it is a recording, points.csv; or dataset.toml with
            kind = "motion", and motion.csv.

    Returns:
        A `Dataset`, or a `MotionLog`.

    Raises:
        DataError: Names file, row and column of the fault.
        RobotError: The URDF, its flange or its joints are not usable.

    Examples:
        >>> robolaser.save(dataset, "cell")
        >>> robolaser.load("cell").name
        'paper'
    """
    return load_motion(folder) if is_motion(folder) else load_dataset(folder)


def calibrate(
    data: Data | MotionLog,
    plan: Plan | None = None,
    *,
    effects: Sequence[Named] | str | None = None,
    weights: str | None = None,
    seed: int | None = None,
    progress: Progress | None = None,
) -> "CalibrationResult | MotionCalibrationResult":
    """Estimate the parameters of a data set's sensor, and of effects added to the model.

    Args:
        data: A data set or its folder; of the log of a moving arm, only the effects are estimated.
        plan: The options; the defaults when absent. A log takes only effects and seed.
        effects: Effects to add to the model: names, `NAME:WHERE` or classes; default: the plan's.
        weights: "plain" or "noise", see `Plan`; default: the plan's.
        seed: Seed of the search; default: the plan's.
        progress: Called with the current step and its finished share.

    Raises:
        EstimationError, DataError: The data are insufficient for a calibration.
        EffectError, UsageError: An effect, location or algorithm is unknown.

    Examples:
        >>> found = robolaser.calibrate(dataset, effects=["laser_roll"])
        >>> found.rms_m < 0.001
        True
    """
    plan = plan or Plan()
    if effects is not None:
        plan = replace(plan, effects=tuple(_effects(effects)))
    plan = plan if weights is None else replace(plan, weights=weights)
    plan = plan if seed is None else replace(plan, seed=seed)
    if _is_motion(data):
        from robolaser.motion.calibration import calibrate_motion  # noqa: PLC0415 - measured poses need none of it
        from robolaser.results.motion import MotionCalibrationResult  # noqa: PLC0415

        usual = Plan(effects=plan.effects, seed=plan.seed)
        if unused := [name for name, value in vars(plan).items() if value != getattr(usual, name)]:
            raise UsageError(f"A log of a moving arm is fitted by least squares: leave out {', '.join(unused)}.")
        fit = calibrate_motion(_motion_log(data), _names(plan.effects), seed=plan.seed, progress=progress)
        return MotionCalibrationResult.of(fit, plan.seed)
    return CalibrationResult.of(fitting.calibrate(_data_set(data), plan, progress=progress))


def diagnose(
    data: Data | MotionLog,
    effects: Sequence[Named] | str | None = None,
    seed: int | None = None,
    *,
    without: Sequence[Named] | Named = (),
    validate: Sequence[Data] | Data = (),
    progress: Progress | None = None,
) -> "DiagnosisResult | MotionResult":
    """Determine where the gap is, which effects cause it, and how far it shrinks.

    Args:
        data: A data set, or the log of a moving arm; or its folder.
        effects: The library of effects, classes or names; `[*robolaser.EFFECTS, Mine]` extends the default.
        seed: Seed of folds and resampling; 1 by default. The same seed gives the same answer.
        without: Effects to remove from the library, classes or names, or one of these.
        validate: Other data of the same arm, on which the result is tested: several data sets or one.
        progress: Called with the current step and its finished share.

    Returns:
        The contents of diagnosis.json: gaps in millimetres, everything else in SI units.

    Raises:
        DataError: The data set has too few data, or other data are of another arm or kind of sensor.
        UsageError: There is no effect of that name, other data are given to a moving arm's, or
            the seed is negative.

    Examples:
        >>> why = robolaser.diagnose(dataset, effects=["laser_roll", "target_scale"], seed=1)
        >>> why.verdict
        'no_gap'
    """
    seed, without = 1 if seed is None else seed, _names(_effects(without))
    check_seed(seed)
    others = _listed(validate)
    if _is_motion(data):
        from robolaser.motion.diagnosis import diagnose_motion  # noqa: PLC0415 - measured poses need none of it
        from robolaser.results.motion import MotionResult  # noqa: PLC0415

        if others:
            raise UsageError("`validate` predicts measured poses: leave it out for the log of a moving arm.")
        log = _motion_log(data)
        names = None if effects is None else _names(_effects(effects))
        return MotionResult.of(diagnose_motion(log, names, without, seed, progress))
    kinds = None if effects is None else _kinds(effects)
    again = partial(examine, effects=kinds, seed=seed, without=without, validate=[_data_set(one) for one in others])
    return DiagnosisResult.of(again(_data_set(data), progress=progress), seed, again)


def compare(
    problems: Sequence[object] | Mapping[str, object],
    algorithms: Sequence[object] | Mapping[str, object] | None = None,
    **options: Any,
) -> "ComparisonResult":
    """Run algorithms side by side, and determine which is better, by how much, and with what certainty.

    Args:
        problems: Data sets or their folders, other names as in `robolaser compare`, or pymoo problems (class,
            instance or function); a mapping names them. One needs no list if it is a data set, a name or a class.
        algorithms: Names, or pymoo algorithms, or functions `search(evaluator, seed)`, likewise. Default: those of
            `robolaser list algorithms`.
        options: `seeds`, `first_seed`, `budget`, `target`, `time_limit_s`, `on_error`, `jobs`, `scheduler`, `output`,
            `resume`, `force` and `progress`: see `robolaser.benchmark.compare.compare`.

    Raises:
        UsageError: A problem, algorithm or setting is unknown, or a number is invalid.
        BenchmarkError: Runs in `output` were made under other conditions, or the cluster is lost.
        OutputError: `output` cannot be written to, or has runs and neither `resume` nor `force` is set.
        Interrupted: It was stopped; the runs so far are in `output`.

    Examples:
        >>> result = robolaser.compare(["pymoo:sphere-2"], ["de"], seeds=1, budget=100)
        >>> result.to_frame()["state"].tolist()
        ['done']
    """
    from robolaser.benchmark import compare as comparing  # noqa: PLC0415 - a second that calibrations do without
    from robolaser.benchmark.solvers import DEFAULT  # noqa: PLC0415
    from robolaser.results.comparison import ComparisonResult  # noqa: PLC0415

    def write(made: "BenchmarkResult", folder: Path) -> None:
        ComparisonResult(made).save(folder)

    solvers = _listed(algorithms or DEFAULT)
    return ComparisonResult(comparing.compare(_listed(problems), solvers, write=write, **options))


def check(data: Data) -> DataCheck:
    """List what can be estimated from a data set, and which data are missing for the rest, without a fit.

    Examples:
        >>> robolaser.check(dataset).hindrance
        ''
    """
    return check_data(_data_set(data))


def plan(data: Data, *, points: int | None = None, seed: int = 1) -> PosePlan:
    """Show which effects could be detected and distinguished at planned poses.

    Args:
        data: A data set with poses, kind of sensor and expected noise, or its folder.
        points: Number of simulated points in each pose, if the data set has none.
        seed: Seed of the simulated sensor.

    Raises:
        DataError: There are no joint readings, or no noise is stated.
        EstimationError: Too few poses see the target.

    Examples:
        >>> len(robolaser.plan(dataset).limits) > 10
        True
    """
    check_seed(seed)
    return examine_plan(_data_set(data), points=points, seed=seed)


def extract(recording: Data, *, progress: Progress | None = None) -> Dataset:
    """Find board and laser stripe, or a camera's target, in the images of a recording.

    Args:
        recording: A data set with [board], [image] and a column `image` in poses.csv; or its folder.
        progress: Called with the current step and its finished share.

    Returns:
        The data set with points; `robolaser.save` writes it.

    Raises:
        DataError, ImageError: There is no board or no image, or no image shows them.

    Examples:
        >>> try:
        ...     robolaser.extract(dataset)
        ... except robolaser.RobolaserError as error:
        ...     print(type(error).__name__)
        ImageError
    """
    from robolaser.vision.recordings import points_of_images  # noqa: PLC0415 - OpenCV takes long to load

    return points_of_images(_data_set(recording), progress=progress)[1]


def import_files(*sources: str | Path, options: ImportOptions | None = None, kind: str | None = None) -> Dataset:
    """Convert files to a data set.

    Args:
        sources: Files or folders that belong together.
        options: Information that the files lack: robot, units, columns.
        kind: One of `robolaser list importers`; by default the one that recognises the files.

    Returns:
        The data set; `robolaser.save` writes it, but not images, which only `robolaser import` copies.

    Raises:
        DataError, UsageError: A file cannot be read, or information is missing.

    Examples:
        >>> _ = Path("log.csv").write_text("x,y,z")
        >>> try:
        ...     robolaser.import_files("log.csv")
        ... except robolaser.RobolaserError as error:
        ...     print(type(error).__name__)
        UsageError
    """
    paths, stated = [Path(source) for source in sources], options or ImportOptions()
    importer = importer_for(paths, kind)
    importer.check(stated, paths)
    return importer.read(paths, stated).checked()


def _is_motion(data: object) -> bool:
    return isinstance(data, MotionLog) or (isinstance(data, str | Path) and is_motion(data))


def _motion_log(data: Any) -> MotionLog:
    return data if isinstance(data, MotionLog) else load_motion(data)


def _data_set(data: object) -> Dataset:
    if isinstance(data, Dataset):
        return data
    if isinstance(data, str | Path):
        return load_dataset(data)
    inner = " Did you mean its attribute `dataset`?" if isinstance(getattr(data, "dataset", None), Dataset) else ""
    raise UsageError(f"Expected a data set or the path of its folder, not a {type(data).__name__}.{inner}")


def _listed(given: Any) -> Any:
    """One name, class or data set as a list of it; several as they are."""
    return [given] if isinstance(given, str | Path | type | Dataset) else given


def _effects(given: Sequence[Named] | Named) -> list[Named]:
    """Names or classes of effects.

    Raises:
        UsageError: One is neither.
    """
    effects = list(_listed(given))
    for one in effects:
        if not isinstance(one, str | type):
            raise UsageError(f"Expected the name of an effect or its class, not a {type(one).__name__}.")
    return effects


def _names(effects: Sequence[Named]) -> list[str]:
    return [one if isinstance(one, str) else one.name for one in effects]


def _kinds(effects: Sequence[Named] | str) -> list[type[Effect]]:
    by_name, listed = {kind.name: kind for kind in EFFECTS}, _effects(effects)
    for one in listed:
        if isinstance(one, str) and one not in by_name:
            raise unknown_effect(one, by_name)
    return [by_name[one] if isinstance(one, str) else one for one in listed]
