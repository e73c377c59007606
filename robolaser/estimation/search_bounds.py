"""Bounds are a must where something searches within them, and nowhere else."""

from robolaser.errors import UsageError
from robolaser.model.forward_model import Model


def check_bounds(model: Model, what: str) -> None:
    """See that somebody gave bounds for all that is searched.

    Args:
        model: Whose sensor has free parameters.
        what: Searches within bounds: "--algorithm rcga".

    Raises:
        UsageError: Nobody did for some.
    """
    names = model.sensor_parameters.unbounded(model.blocks.free)
    if names:
        raise UsageError(
            f"{what} searches within bounds, but dataset.toml gives none for {', '.join(names)}: these start from"
            " closed forms. State { nominal, lower, upper } for each under [parameters], or calibrate without a search."
        )
