"""The suite as a sequence of problems, each built when it is asked for."""

from collections.abc import Iterator, Sequence
from typing import final

from robolaser.problems.calibration_suite.instance import instance_named, instances
from robolaser.problems.calibration_suite.problem import SuiteProblem


@final
class Suite:
    """Problems in a fixed order; each time one is asked for it is a new one, that nobody has evaluated yet.

    Examples:
        >>> from robolaser.problems import suite
        >>> [(problem.id, problem.dimension) for problem in suite(["lee2004", "lee2004-reduced"])]
        [('lee2004', 14), ('lee2004-reduced', 6)]
    """

    def __init__(self, ids: Sequence[str]) -> None:
        self.ids = tuple(ids)

    def __len__(self) -> int:
        return len(self.ids)

    def __getitem__(self, which: int | str) -> SuiteProblem:
        """The problem of this number or id.

        Raises:
            UsageError: There is none of that id.
            IndexError: There is none of that number.
        """
        return SuiteProblem(instance_named(which if isinstance(which, str) else self.ids[which]))

    def __iter__(self) -> Iterator[SuiteProblem]:
        return (self[name] for name in self.ids)


def suite(ids: Sequence[str] | None = None) -> Suite:
    """Calibrations of scanners, cameras and arms, measured and simulated, with the lowest J that is known of each.

    Args:
        ids: Those wanted, in this order; all when absent.

    Raises:
        UsageError: There is no instance of that id.

    Examples:
        >>> from robolaser.problems import suite
        >>> problem = suite()["ur5-tracker"]
        >>> minimize(problem, GA(pop_size=20), ("n_eval", 200), seed=1).F[0] > problem.lowest
        np.True_
    """
    return Suite([instance_named(name).id for name in (instances() if ids is None else ids)])
