"""What the solver minimises: any sum of squares, or of robust losses, within bounds, in batches of rows."""

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
        """M."""

    @property
    def batches(self) -> Sequence[tuple[Ints, Rows]]:
        """The rows in batches: their numbers (m',), and what they are."""

    def extra_residuals(self, x: Array) -> Array:
        """Further residuals, whose squares count whichever rows are left out, (c, d) -> (c, e)."""

    def extra_jacobian(self, x: Array) -> Array:
        """Derivatives of these by each parameter over its scale, (c, d) -> (c, d, e)."""
