"""A study of one algorithm's parts: the algorithm beside itself with other operators."""

from collections.abc import Sequence
from itertools import product

from robolaser.algorithms.spec import SLOTS, with_operators
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
        if not equals or not all(names) or slot in levels or slot not in SLOTS:
            raise UsageError(
                f"--exchange {text}: expected a slot, which comes once, and its operators, as in"
                f" crossover=ArithmeticCrossover,SBX. Slots are {', '.join(SLOTS)}."
            )
        levels[slot] = [STOCK, *names]
    chosen = [
        {slot: name for slot, name in zip(levels, each, strict=True) if name} for each in product(*levels.values())
    ]
    return [with_operators(stock, parts) for parts in chosen if factorial or len(parts) <= 1]
