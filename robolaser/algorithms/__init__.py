"""Search algorithms: the genetic algorithm of Lee et al. 2004, its termination; algorithms by name."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from robolaser.algorithms.rcga import RCGA
    from robolaser.algorithms.stopping import Stalled

__all__ = ["RCGA", "Stalled"]


def __getattr__(name: str) -> Any:
    """Load pymoo only when it is needed."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from robolaser.algorithms import rcga  # noqa: PLC0415

    return getattr(rcga, name)
