"""First candidates of a pymoo algorithm, the foremost of them given."""

from typing import Any, final

from pymoo.core.sampling import Sampling

from robolaser.arrays import Array


@final
class _Starting(Sampling):  # type: ignore[misc]
    def __init__(self, starts: Array, others: Any) -> None:
        super().__init__()
        self._starts, self._others = starts, others

    def _do(self, problem: Any, n_samples: int, **kwargs: Any) -> Array:
        x: Array = self._others(problem, n_samples, **kwargs).get("X")
        x[: len(self._starts)] = self._starts[: len(x)]
        return x


def starting_with(starts: Array, others: Any) -> Any:
    """Candidates (k, d) in place of the first k that an algorithm would sample; its own fixed ones go first."""
    return _Starting(starts, others) if isinstance(others, Sampling) else others
