"""robolaser compare: algorithms side by side."""

from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from robolaser.benchmark import BUDGET, SEEDS, TIME_LIMIT_S
from robolaser.commands.terminal import (
    RESULT,
    Count,
    Force,
    PositiveOption,
    ResultFlag,
    Terminal,
    Typed,
    ended_as_by_hand,
    refuse,
)
from robolaser.errors import BenchmarkError, UsageError

if TYPE_CHECKING:
    from robolaser.benchmark.result import BenchmarkResult


def compare(
    *datasets: str,
    output: Annotated[Path, Parameter(metavar="DIR", group=RESULT)],
    algorithms: Annotated[str | None, Parameter(metavar="A,B")] = None,
    seeds: Count = SEEDS,
    seed: Count = 1,
    budget: Annotated[str, Parameter(metavar="EVALS")] = str(BUDGET),
    target: Annotated[PositiveOption | None, Parameter(metavar="EXCESS")] = None,
    time_limit: Annotated[PositiveOption, Parameter(metavar="S")] = TIME_LIMIT_S,
    on_error: Literal["fail", "inf"] = "fail",
    jobs: Count | None = None,
    scheduler: Annotated[str | None, Parameter(metavar="ADDRESS")] = None,
    merge: Annotated[bool, Parameter(negative="")] = False,
    iohprofiler: ResultFlag = False,
    latex: ResultFlag = False,
    resume: ResultFlag = False,
    force: Force = False,
    terminal: Terminal = Terminal(),
    typed: Typed = "",
) -> None:
    """Run algorithms side by side and report which is better, by how much, and how certain that is.

    For example:

        robolaser compare paper --algorithms rcga,de --output comparison
        robolaser compare measured pymoo:rastrigin-14 --seeds 30 --budget 1000d --output comparison
        robolaser compare paper --algorithms GA,GA:crossover=ArithmeticCrossover --output effect
        robolaser compare --merge node-1 node-2 --output all

    Args:
        datasets: Folders of data sets, `paper`, reduced:DATASET (its closed-form reduction), `suite` or suite:NAME
            (calibrations with known optima), pymoo:NAME[-DIMENSION], bbob:NUMBER[-DIMENSION], or your own,
            package.module:attribute.
        output: Folder for the result.
        algorithms: Of `robolaser list algorithms`, as rcga or rcga:b=2; any class of pymoo's, as NSGA3; or
            package.module:attribute. Operators are exchanged as in GA:crossover=SBX. Default: all of the list.
        seeds: Number of runs of each algorithm on each problem, with seeds from --seed on.
        seed: First seed.
        budget: Evaluations of a run, as 20000, or 1000d: 1000 for each variable.
        target: Excess over the lowest known cost that counts as reached; for calibrations a share of J, for several
            objectives IGD+. Default: 0.01.
        time_limit: Maximum seconds of a run; its best result by then counts.
        on_error: A candidate whose evaluation raises an error makes its run fail, or costs infinity (inf).
        jobs: Number of runs at a time. Default: one on each core.
        scheduler: Address of a Dask cluster, tcp://HOST:PORT.
        merge: Merge finished or unfinished comparisons; name their folders instead of problems.
        iohprofiler: Also write the runs in IOHprofiler's format.
        latex: Also write the tables of the report for a paper, to tables.tex.
        resume: Continue a comparison that was stopped, or extend it.
    """
    from robolaser.benchmark import compare as comparing
    from robolaser.benchmark import journal
    from robolaser.benchmark.solvers import DEFAULT
    from robolaser.data.result_folder import results_in

    if not datasets:
        raise UsageError("Name a problem, DATASET: see `robolaser compare --help`.")
    if merge:
        idle = {"--algorithms": algorithms, "--seeds": seeds != SEEDS, "--seed": seed != 1, "--target": target,
                "--budget": budget != str(BUDGET), "--time-limit": time_limit != TIME_LIMIT_S,
                "--on-error": on_error != "fail", "--jobs": jobs, "--scheduler": scheduler}  # fmt: skip
        refuse("--merge makes no runs", idle)
    if scheduler and jobs:
        raise UsageError("--scheduler and --jobs exclude each other: leave one of them out.")

    with ended_as_by_hand(), ExitStack() as shown:

        def write(result: "BenchmarkResult", folder: Path) -> None:
            shown.close()  # ends the progress bar before the result is printed
            _write(result, folder, terminal, iohprofiler=iohprofiler, latex=latex, typed=typed)

        if merge:
            with results_in(output, command="compare", files=(), inputs=[*map(Path, datasets)]):
                extended = resume and (output / journal.NAME).is_file()
                result = journal.merge([output, *datasets] if extended else datasets)
                comparing.refuse_to_mix(output, resume=resume, force=force)
            write(result, output)
        else:
            result = comparing.compare(
                datasets,
                DEFAULT if algorithms is None else [name.strip() for name in algorithms.split(",")],
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
                progress=shown.enter_context(terminal.progress()),
                write=write,
            )
    if not result.runs or len(result.failures) == len(result.runs):
        raise BenchmarkError(
            "Every run failed." if result.runs else "No algorithm could be run on any of the problems."
        )


def _write(
    result: "BenchmarkResult", folder: Path, terminal: Terminal, *, iohprofiler: bool, latex: bool, typed: str
) -> None:
    from robolaser.benchmark.export import iohprofiler_files
    from robolaser.data.result_folder import results_in, write_results
    from robolaser.report.comparison.page import document
    from robolaser.report.latex import latex_tables
    from robolaser.results.comparison import ComparisonResult

    compared = ComparisonResult(result)
    files = dict(compared.files(command=typed))
    if iohprofiler:
        files |= {f"iohprofiler/{name}": text for name, text in iohprofiler_files(result).items()}
    if latex:
        files["tables.tex"] = latex_tables(document(result, compared.standings))
    with results_in(folder, command="compare", files=list(files), force=True) as claim:
        write_results(folder, {**dict.fromkeys(claim(())), **files})
    terminal.show(str(files["comparison.json"]), lambda: compared.print(folder))
