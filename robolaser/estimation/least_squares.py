"""What the solver minimises: any sum of squares, or of robust losses, within bounds, in blocks of rows."""

from collections.abc import Sequence
from typing import Protocol

from robolaser.arrays import Array, Ints
from robolaser.estimation.robust_loss import Loss


class Rows(Protocol):
    """Some rows of a problem; each has one or more numbers, and all of them stand in a flat vector (K,)."""

    @property
    def starts(self) -> Ints:
        """Where the numbers of each row begin, (m,)."""

    @property
    def row_of_number(self) -> Ints:
        """Row of each number, (K,)."""

    @property
    def loss(self) -> Loss:
        """What a row costs."""

    def residuals(self, x: Array) -> Array:
        """Candidates (c, d) -> (c, K); not finite at poles."""

    def jacobian(self, x: Array) -> Array:
        """Derivatives by each parameter over its scale, (c, d) -> (c, d, K); zero for fixed parameters."""


class LeastSquares(Protocol):
    """A problem with d parameters and m rows."""

    @property
    def lower(self) -> Array:
        """Lower bounds, (d,); may be -inf."""

    @property
    def upper(self) -> Array:
        """Upper bounds, (d,); equal to the lower for fixed parameters; may be inf."""

    @property
    def scale(self) -> Array:
        """A usual change of each parameter, (d,)."""

    @property
    def rows(self) -> int:
        """m."""

    @property
    def blocks(self) -> Sequence[tuple[Ints, Rows]]:
        """The rows in blocks: their numbers (m',), and what they are."""

    @property
    def prior_slopes(self) -> Array:
        """Derivatives of the prior's rows by each parameter over its scale, (d,); zero without a prior."""

    def prior_residuals(self, x: Array) -> Array:
        """Distances from the nominal values in units of the prior, (c, d) -> (c, d)."""
