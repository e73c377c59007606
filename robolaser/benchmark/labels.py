"""Names by which readers know the solvers, in place of those by which they are found."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from robolaser.benchmark.result import BenchmarkResult
from robolaser.errors import UsageError


def labels_of(texts: Sequence[str], names: Sequence[str]) -> Mapping[str, str]:
    """Labels by name, as typed in `NAME=LABEL`; a name may have equals signs itself.

    Raises:
        UsageError: A text is not of that form, names nobody who takes part, or makes two names alike.
    """
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


def labelled(result: BenchmarkResult, labels: Mapping[str, str]) -> BenchmarkResult:
    """The same result with other names for solvers; who has none keeps the old one."""
    new = {name: labels.get(name, name) for name in result.solvers}
    return replace(
        result,
        problems=tuple(replace(one, found_by=new.get(one.found_by, one.found_by)) for one in result.problems),
        solvers={new[name]: title for name, title in result.solvers.items()},
        refused={(problem, new[name]): reason for (problem, name), reason in result.refused.items()},
        dropped={new[name]: count for name, count in result.dropped.items()},
        runs=tuple(replace(run, algorithm=new[run.algorithm]) for run in result.runs),
    )
