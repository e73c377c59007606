"""Pickles that another process can read, also of what is defined in a script or a notebook."""

import pickle
from typing import Any

from robolaser.errors import DependencyMissing, UsageError


def pickled(thing: Any, name: str) -> bytes:
    """Pickle a thing; what lies in `__main__` or cannot be found by a name goes by value.

    Raises:
        UsageError: It cannot be pickled.
        DependencyMissing: It needs cloudpickle, which is not installed.
    """
    try:
        found = pickle.dumps(thing)
        if b"__main__" not in found:
            return found
    except Exception:  # lambdas, local classes
        pass
    try:
        import cloudpickle  # noqa: PLC0415 - an extra
    except ImportError:
        raise DependencyMissing(
            f"{name} is defined in a script or a notebook, and other processes need cloudpickle to get it:"
            " pip install 'robolaser[compare]'. Or move it to a module of its own."
        ) from None
    try:
        found = cloudpickle.dumps(thing)
    except Exception as error:
        raise UsageError(
            f"{name} cannot be sent to another process ({type(error).__name__}: {error}). Leave out what it holds open"
            " (files, connections), or open that at the first evaluation."
        ) from error
    return bytes(found)
