"""What cross-validation leaves out together, where that is more than poses."""

from abc import ABC, abstractmethod

from robolaser.arrays import Array, Ints


class HeldOut(ABC):
    """Rows of things that only their own rows can locate."""

    @property
    @abstractmethod
    def groups(self) -> Ints:
        """Group of each row, (m,): rows of one group are held out together."""

    @abstractmethod
    def located_apart(self, errors: Array) -> Array:
        """Errors of held-out rows (m, k) once what only they can locate is located from them."""
