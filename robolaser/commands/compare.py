"""robolaser compare: algorithms side by side."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from robolaser.benchmark.defaults import BUDGET, MEMORY_LIMIT_B, SEEDS, TIME_LIMIT_S
from robolaser.commands.options import RESULT, Count, Force, Positive, Resume, Typed
from robolaser.commands.signals import ended_as_by_hand
from robolaser.commands.terminal import TERMINAL, Terminal
from robolaser.errors import DependencyMissing, Interrupted, OutputError, UsageError

if TYPE_CHECKING:
    from robolaser.benchmark.result import BenchmarkResult
    from robolaser.benchmark.setting_space import SettingSpace
    from robolaser.benchmark.standings import Standings

RESULT_FILE, RUNS, PAGE = "comparison.json", "runs.csv", "report.html"
GB = 1e9


def compare(
    *datasets: str,
    output: Annotated[Path, Parameter(metavar="DIR", group=RESULT)],
    algorithms: Annotated[str | None, Parameter(metavar="A,B")] = None,
    stock: Annotated[str | None, Parameter(metavar="NAME")] = None,
    exchange: Annotated[tuple[str, ...], Parameter(metavar="SLOT=A,B")] = (),
    factorial: Annotated[bool, Parameter(negative="")] = False,
    vary: Annotated[tuple[str, ...], Parameter(metavar="KEY=A,B|LOW..HIGH")] = (),
    samples: Count | None = None,
    race: Annotated[bool, Parameter(negative="")] = False,
    start_from: Annotated[Path | None, Parameter(metavar="PATH")] = None,
    seeds: Count = SEEDS,
    budget: Annotated[Count, Parameter(metavar="EVALS")] = BUDGET,
    time_limit: Annotated[Positive, Parameter(metavar="S")] = TIME_LIMIT_S,
    memory_limit: Annotated[Positive, Parameter(metavar="GB")] = MEMORY_LIMIT_B / GB,
    jobs: Count | None = None,
    scheduler: Annotated[str | None, Parameter(metavar="ADDRESS")] = None,
    seed: Count = 1,
    iohprofiler: Annotated[bool, Parameter(group=RESULT)] = False,
    parquet: Annotated[bool, Parameter(group=RESULT)] = False,
    table: Annotated[Literal["latex", "markdown"] | None, Parameter(group=RESULT)] = None,
    label: Annotated[tuple[str, ...], Parameter(metavar="NAME=LABEL", group=RESULT)] = (),
    resume: Resume = False,
    force: Force = False,
    terminal: Terminal = TERMINAL,
    typed: Typed = "",
) -> None:
    """Run algorithms side by side and say which is better, by how much, and how certain that is.

    For example:

        robolaser compare paper --algorithms rcga,de --output comparison
        robolaser compare measured pymoo:rastrigin-14 --seeds 30 --output comparison
        robolaser compare paper --stock GA --exchange crossover=ArithmeticCrossover --output effect
        robolaser compare paper --algorithms rcga --vary b=0.5..8 --vary pop_size=20..200 --race --output race

    Args:
        datasets: Folders of data sets, `paper`, reduced:DATASET (its closed-form reduction), pymoo:NAME[-DIMENSION],
            bbob:NUMBER[-DIMENSION], or your own, package.module:attribute.
        output: Folder for the result.
        algorithms: Of `robolaser list algorithms`, as rcga or rcga:b=2; or package.module:attribute. Default: all.
        stock: An algorithm of which parts are exchanged; beside ours, any class of pymoo's algorithms, as GA or NSGA2.
        exchange: A slot and the operators that take their turn in it, as crossover=ArithmeticCrossover,SBX:eta=3 or
            mutation=package.module:attribute; may be given again.
        factorial: Combine exchanges in all ways, instead of one part at a time.
        vary: A setting of the algorithm and its values, or its range; may be given again.
        samples: Number of settings to begin with. Default: all combinations of values, or 20 where there are ranges.
        race: Drop, seed by seed, who is significantly worse than the best; sample new settings near the best.
        start_from: An earlier comparison, whose best candidates all algorithms begin with.
        seeds: Number of runs of each algorithm on each problem, with seeds from --seed on.
        budget: Most evaluations of a run.
        time_limit: Most seconds of a run.
        memory_limit: Most memory of a run [GB].
        jobs: Number of runs at a time. Default: one on each core.
        scheduler: Address of a Dask cluster, tcp://HOST:PORT.
        seed: First seed.
        iohprofiler: Also write the runs in IOHprofiler's format.
        parquet: Also write the tables of runs and of their improvements as Parquet files.
        table: Also write tables for a paper, to tables.tex or tables.md.
        label: What page, terminal and tables call an algorithm; may be given again.
        resume: Continue a comparison that was stopped.
        force: Overwrite an earlier result.
    """
    from robolaser.benchmark import racing
    from robolaser.benchmark.engines import DaskCluster, EngineLost, ThisMachine
    from robolaser.benchmark.plan import RunPlan
    from robolaser.benchmark.result_files import comparison_json, exported, runs_csv
    from robolaser.benchmark.run_loop import fill
    from robolaser.benchmark.solvers import DEFAULT
    from robolaser.benchmark.standings import standings
    from robolaser.benchmark.table import FILES, NAME, RunTable, starting_points
    from robolaser.data.result_folder import results_in, write_results
    from robolaser.report.comparison import page, print_comparison

    if not datasets:
        raise UsageError("Name a problem, DATASET: see `robolaser compare --help`.")
    if scheduler and jobs:
        raise UsageError("--scheduler and --jobs exclude each other: leave one of them out.")
    if not (resume or force):
        _refuse_to_mix(output)
    if parquet and find_spec("pyarrow") is None:
        raise DependencyMissing("--parquet needs pyarrow, which is not installed: pip install 'robolaser[parquet]'.")
    named = _algorithms(algorithms, stock, exchange, factorial=factorial) or DEFAULT
    space = _settings(named, vary, samples, seed)
    plan = RunPlan.of(
        datasets,
        named if space is None else space.first,
        seeds=seeds,
        first_seed=seed,
        budget=budget,
        time_limit_s=time_limit,
        memory_limit_b=round(memory_limit * GB),
        starts=None if start_from is None else starting_points(start_from),
    )
    labels = labels_of(label, [solver.name for solver in plan.solvers])
    files = (RESULT_FILE, RUNS, PAGE)
    with (
        ended_as_by_hand(),
        DaskCluster(scheduler, plan.packages) if scheduler else ThisMachine(jobs) as engine,
        results_in(
            output,
            command="compare",
            files=files,
            state=FILES,
            inputs=[path for path in (*map(Path, datasets), start_from) if path is not None and path.is_dir()],
            force=force or resume,
        ) as claim,
    ):
        if not resume:
            for name in FILES:
                (output / name).unlink(missing_ok=True)
        with RunTable(output / NAME) as runs:

            def conclude() -> None:
                result = runs.result(plan)
                ranked = tuple(standings(result, family) for family in result.families)
                text = comparison_json(result, ranked)
                shown, judged = _labelled(result, ranked, labels)
                exports = exported(result, iohprofiler=iohprofiler, parquet=parquet) | _tables(shown, judged, table)
                claim(exports)
                html = page(shown, judged, command=typed)
                write_results(output, {**exports, RUNS: runs_csv(result), PAGE: html, RESULT_FILE: text})
                terminal.show(text, lambda: print_comparison(shown, judged, output))

            try:
                with terminal.progress() as progress:
                    for plan in racing.race(plan, runs, space) if race else (plan,):  # noqa: B020 - `conclude` reads it
                        fill(runs, plan, engine, progress)
            except (KeyboardInterrupt, EngineLost) as stopped:
                engine.close()
                with suppress(KeyboardInterrupt):  # the runs are there even without the report
                    if runs.begun:
                        conclude()
                why = str(stopped).rstrip(".") if isinstance(stopped, EngineLost) else "Stopped"
                raise Interrupted(
                    f"{why}, after {len(runs.result(plan).runs)} of {len(plan.tasks)} runs. They are in"
                    f" {output / NAME}: continue with --resume."
                ) from None
            conclude()


def _refuse_to_mix(output: Path) -> None:
    """Raise if runs or a result would be overwritten."""
    from robolaser.benchmark.table import NAME, RunTable

    if not (output / NAME).is_file():
        return
    with RunTable(output / NAME, readonly=True) as table:
        runs = len(table)
    if runs:
        raise OutputError(
            f"{output} holds {runs} runs of a comparison. Continue or extend it with --resume; start over with --force."
        )


def _algorithms(typed: str | None, stock: str | None, exchanges: tuple[str, ...], *, factorial: bool) -> list[str]:
    """Who takes part: those that are named, and those of a study of one algorithm's parts."""
    from robolaser.benchmark.exchange import study

    if bool(stock) != bool(exchanges):
        raise UsageError("--stock and --exchange belong together: name an algorithm, and what is exchanged in it.")
    named = [] if typed is None else [name.strip() for name in typed.split(",")]
    return named + (study(stock, exchanges, factorial=factorial) if stock else [])


def _settings(named: Sequence[str], vary: tuple[str, ...], samples: int | None, seed: int) -> "SettingSpace | None":
    """Where settings of the one algorithm come from, if they are varied."""
    from robolaser.benchmark.setting_space import SettingSpace

    if not vary:
        if samples is not None:
            raise UsageError("--samples needs --vary: name a setting and its values.")
        return None
    if len(named) != 1:
        raise UsageError(f"--vary needs one algorithm in --algorithms, and there are {len(named)}.")
    return SettingSpace(named[0], vary, samples=samples, seed=seed)


def labels_of(texts: Sequence[str], names: Sequence[str]) -> Mapping[str, str]:
    """What readers call the algorithms, by name, as typed in `NAME=LABEL`; a name may have equals signs itself."""
    labels = {}
    for text in texts:
        name = next((name for name in names if text.startswith(f"{name}=") and len(text) > len(name) + 1), None)
        if name is None:
            raise UsageError(
                f"--label {text}: expected NAME=LABEL, with the name of one that takes part: {', '.join(names)}."
            )
        labels[name] = text[len(name) + 1 :]
    if len({labels.get(name, name) for name in names}) < len(names):
        raise UsageError(f"--label {' '.join(texts)}: two algorithms would have one name. Give each its own.")
    return labels


def _labelled(
    result: "BenchmarkResult", ranked: tuple["Standings", ...], labels: Mapping[str, str]
) -> tuple["BenchmarkResult", tuple["Standings", ...]]:
    """Result and standings with the names that readers know."""
    from robolaser.benchmark.standings import standings

    if not labels:
        return result, ranked
    shown = result.labelled(labels)
    return shown, tuple(
        replace(
            standings(shown, one.family),
            effects=tuple(replace(effect, stock=labels.get(effect.stock, effect.stock)) for effect in one.effects),
        )
        for one in ranked
    )


def _tables(
    result: "BenchmarkResult", judged: tuple["Standings", ...], form: Literal["latex", "markdown"] | None
) -> dict[str, str]:
    """The file of the tables for a paper, if it is wanted."""
    from robolaser.report.comparison.paper_tables import FILES, paper_tables

    return {} if form is None else {FILES[form]: paper_tables(result, judged, form)}
