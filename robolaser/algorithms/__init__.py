"""Search algorithms: the genetic algorithm of Lee et al. 2004, its terminations and checkpoints; algorithms by name."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from robolaser.algorithms.rcga import RCGA
    from robolaser.algorithms.stopping import CostReached, Stalled

__all__ = ["RCGA", "CostReached", "Stalled"]


def __getattr__(name: str) -> Any:
    """Load what needs pymoo only when it is used."""
    if name == "RCGA":
        from robolaser.algorithms import rcga  # noqa: PLC0415

        return rcga.RCGA
    if name in ("CostReached", "Stalled"):
        from robolaser.algorithms import stopping  # noqa: PLC0415

        return getattr(stopping, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
