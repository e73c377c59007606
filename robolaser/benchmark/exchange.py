"""A study of one algorithm's parts: the algorithm beside itself with other operators."""

from collections.abc import Sequence
from itertools import product

from robolaser.algorithms.exchanged import joined, parted
from robolaser.errors import UsageError

STOCK = ""
"""The level of a slot that keeps the stock algorithm's own operator."""


def study(stock: str, exchanges: Sequence[str], *, factorial: bool = False) -> list[str]:
    """The algorithms of a study, by name: the stock one, and what an exchange makes of it.

    Args:
        stock: An algorithm's name.
        exchanges: `slot=OPERATOR,OPERATOR...` each.
        factorial: Whether exchanges are combined in all ways; else one part is exchanged at a time.

    Raises:
        UsageError: An exchange is not of that form, or a slot comes twice.
    """
    levels: dict[str, list[str]] = {}
    for text in exchanges:
        slot, equals, operators = (piece.strip() for piece in text.partition("="))
        names = [name.strip() for name in operators.split(",")]
        if not equals or not all(names) or slot in levels or parted(f"{stock}+{slot}=x")[0] != stock:
            raise UsageError(
                f"--exchange {text}: expected a slot, which comes once, and its operators, as in"
                " crossover=ArithmeticCrossover,SBX. Slots are sampling, selection, crossover, mutation, survival and"
                " repair."
            )
        levels[slot] = [STOCK, *names]
    combined = product(*levels.values())
    chosen = [dict(zip(levels, each, strict=True)) for each in combined]
    return [joined(stock, parts) for parts in chosen if factorial or sum(map(bool, parts.values())) <= 1]
