"""robolaser compare: algorithms side by side."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from robolaser.benchmark.defaults import BUDGET, SEEDS, TIME_LIMIT_S
from robolaser.commands.options import RESULT, Count, Force, Positive, Resume, Typed
from robolaser.commands.signals import ended_as_by_hand
from robolaser.commands.terminal import TERMINAL, Terminal
from robolaser.errors import BenchmarkError, Interrupted, UsageError

if TYPE_CHECKING:
    from robolaser.benchmark.result import BenchmarkResult


def compare(
    *datasets: str,
    output: Annotated[Path, Parameter(metavar="DIR", group=RESULT)],
    algorithms: Annotated[str | None, Parameter(metavar="A,B")] = None,
    stock: Annotated[str | None, Parameter(metavar="NAME")] = None,
    exchange: Annotated[tuple[str, ...], Parameter(metavar="SLOT=A,B")] = (),
    factorial: Annotated[bool, Parameter(negative="")] = False,
    seeds: Count = SEEDS,
    seed: Count = 1,
    budget: Annotated[str, Parameter(metavar="EVALS")] = str(BUDGET),
    target: Annotated[Positive | None, Parameter(metavar="EXCESS")] = None,
    time_limit: Annotated[Positive, Parameter(metavar="S")] = TIME_LIMIT_S,
    on_error: Literal["fail", "inf"] = "fail",
    jobs: Count | None = None,
    scheduler: Annotated[str | None, Parameter(metavar="ADDRESS")] = None,
    merge: Annotated[bool, Parameter(negative="")] = False,
    iohprofiler: Annotated[bool, Parameter(group=RESULT)] = False,
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
        robolaser compare measured pymoo:rastrigin-14 --seeds 30 --budget 1000d --output comparison
        robolaser compare paper --stock GA --exchange crossover=ArithmeticCrossover --output effect
        robolaser compare --merge node-1 node-2 --output all

    Args:
        datasets: Folders of data sets, `paper`, reduced:DATASET (its closed-form reduction), `suite` or suite:NAME
            (calibrations with known optima), pymoo:NAME[-DIMENSION], bbob:NUMBER[-DIMENSION], or your own,
            package.module:attribute.
        output: Folder for the result.
        algorithms: Of `robolaser list algorithms`, as rcga or rcga:b=2; any class of pymoo's, as NSGA3; or
            package.module:attribute. Default: all of the list.
        stock: An algorithm of which parts are exchanged.
        exchange: A slot and the operators that take their turn in it, as crossover=ArithmeticCrossover,SBX:eta=3 or
            mutation=package.module:attribute; may be given again.
        factorial: Combine exchanges in all ways, instead of one part at a time.
        seeds: Number of runs of each algorithm on each problem, with seeds from --seed on.
        seed: First seed.
        budget: Evaluations of a run, as 20000, or 1000d: 1000 for each variable.
        target: How far above the lowest known cost counts as reached; for calibrations a share of J, for several
            objectives IGD+. Default: 0.01.
        time_limit: Most seconds of a run; what it found by then counts.
        on_error: A candidate whose evaluation raises an error makes its run fail, or costs infinity (inf).
        jobs: Number of runs at a time. Default: one on each core.
        scheduler: Address of a Dask cluster, tcp://HOST:PORT.
        merge: Put finished or unfinished comparisons together, whose folders are named instead of problems.
        iohprofiler: Also write the runs in IOHprofiler's format.
        table: Also write tables for a paper, to tables.tex or tables.md.
        label: What page, terminal and tables call an algorithm; may be given again.
        resume: Continue a comparison that was stopped, or extend it.
        force: Overwrite an earlier result.
    """
    from robolaser.benchmark import compare as comparing
    from robolaser.benchmark import journal
    from robolaser.benchmark.solvers import DEFAULT

    if not datasets:
        raise UsageError("Name a problem, DATASET: see `robolaser compare --help`.")
    if scheduler and jobs:
        raise UsageError("--scheduler and --jobs exclude each other: leave one of them out.")
    with ended_as_by_hand():
        if merge:
            result = journal.merge(datasets)
            comparing.refuse_to_mix(output, resume=resume, force=force)
        else:
            try:
                with terminal.progress() as progress:
                    result = comparing.compare(
                        datasets,
                        _algorithms(algorithms, stock, exchange, factorial=factorial) or DEFAULT,
                        seeds=seeds,
                        first_seed=seed,
                        budget=budget,
                        target=target,
                        time_limit_s=time_limit,
                        on_error=on_error,
                        jobs=jobs,
                        scheduler=scheduler,
                        output=output,
                        resume=resume,
                        force=force,
                        progress=progress,
                    )
            except Interrupted:
                so_far = journal.merge([output])
                if so_far.runs:
                    _show(so_far, output, label, table, terminal, iohprofiler=iohprofiler, typed=typed)
                raise
        _show(result, output, label, table, terminal, iohprofiler=iohprofiler, typed=typed)
    if not result.runs or len(result.failures) == len(result.runs):
        raise BenchmarkError(
            "Every run failed." if result.runs else "No algorithm could be run on any of the problems."
        )


def _show(
    result: "BenchmarkResult",
    output: Path,
    label: Sequence[str],
    table: Literal["latex", "markdown"] | None,
    terminal: Terminal,
    *,
    iohprofiler: bool,
    typed: str,
) -> None:
    """Write all files, the page with the names that readers know, and print the result."""
    from robolaser.benchmark import journal
    from robolaser.benchmark.export import comparison_json, iohprofiler_files, runs_csv
    from robolaser.benchmark.standings import standings
    from robolaser.data.result_folder import results_in, write_results
    from robolaser.report.comparison import page, print_comparison
    from robolaser.report.comparison.paper_tables import FILES, paper_tables

    shown = result.labelled(labels_of(label, list(result.solvers)))
    judged = [standings(shown, family) for family in shown.families]
    text = comparison_json(result, [standings(result, family) for family in result.families])
    files: dict[str, str | bytes | None] = {
        journal.NAME: result.journal,
        "runs.csv": runs_csv(result),
        "report.html": page(shown, judged, command=typed),
        "comparison.json": text,
    }
    if iohprofiler:
        files |= {f"iohprofiler/{name}": text for name, text in iohprofiler_files(result).items()}
    if table is not None:
        files[FILES[table]] = paper_tables(shown, judged, table)
    with results_in(output, command="compare", files=list(files), force=True):
        write_results(output, files)
    terminal.show(text, lambda: print_comparison(shown, judged, output))


def _algorithms(typed: str | None, stock: str | None, exchanges: tuple[str, ...], *, factorial: bool) -> list[str]:
    """Who takes part: those that are named, and those of a study of one algorithm's parts."""
    from robolaser.benchmark.exchange import study

    if bool(stock) != bool(exchanges):
        raise UsageError("--stock and --exchange belong together: name an algorithm, and what is exchanged in it.")
    named = [] if typed is None else [name.strip() for name in typed.split(",")]
    return named + (study(stock, exchanges, factorial=factorial) if stock else [])


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
