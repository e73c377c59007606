"""Optimisers side by side on the same problems: who is better, by how much, and how sure is that?"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from robolaser.benchmark.journal import load, merge

__all__ = ["load", "merge"]


def __getattr__(name: str) -> Any:
    """Load a name when it is first used: those who read defaults do not pay for NumPy."""
    if name not in __all__:
        raise AttributeError(f"module 'robolaser.benchmark' has no attribute '{name}'")
    from robolaser.benchmark import journal  # noqa: PLC0415

    return getattr(journal, name)
