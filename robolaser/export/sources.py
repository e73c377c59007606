"""The source of functions and classes with all that they are made of, for a file that stands alone."""

import ast
import inspect
import sys
import textwrap
from collections.abc import Iterable
from functools import cache
from types import ModuleType
from typing import Any, final

BESIDE = frozenset({*sys.stdlib_module_names, "numpy", "scipy"})  # packages that are imported and not copied


@final
class Sources:
    """Sources, imports and constants, in the order in which they must stand; `given` names are defined elsewhere."""

    def __init__(self, given: Iterable[str]) -> None:
        self.imports: dict[str, str] = {}
        self.texts: dict[str, str] = {}  # by name
        self._given = frozenset(given)
        self._of: dict[str, Any] = {}

    def add(self, name: str, thing: Any) -> None:
        """Take a global name with all that it is made of.

        Raises:
            ValueError: Two things have one name.
        """
        if name in self._given or self._of.get(name, self) is thing:
            return
        if name in self._of and self._of[name] != thing:
            raise ValueError(f"'{name}' means {self._of[name]!r} here and {thing!r} there.")
        self._of[name] = thing  # before what it is made of, which may call it in turn
        if isinstance(thing, ModuleType):
            self.imports[name] = f"import {thing.__name__} as {name}"
        elif not is_defined(thing):
            self.texts[name] = f"\n\n{name} = {thing!r}\n"
        elif thing.__module__.partition(".")[0] in BESIDE:
            renamed = "" if name == thing.__name__ else f" as {name}"
            self.imports[name] = f"from {thing.__module__} import {thing.__name__}{renamed}"
        else:
            text = source_of(thing)
            self.use(text, thing.__module__)
            self.texts[name] = f"\n\n{text}"

    def use(self, text: str, module: str) -> None:
        """Take all global names of a module that a source of it reads."""
        for name in names_of(text):
            if name in vars(sys.modules[module]):
                self.add(name, vars(sys.modules[module])[name])

    def add_methods(self, kind: type, wanted: str) -> set[str]:
        """Take a class with one method, and those that it calls; return what these, and theirs, read of `run`."""
        found, texts, read = [wanted], {}, set[str]()
        for name in found:
            text = source_of(getattr(kind, name))
            texts[name] = text
            self.use(textwrap.dedent(text), getattr(kind, name).__module__)
            own = attributes_of(textwrap.dedent(text), "self")
            found += [each for each in own if callable(getattr(kind, each, None)) and each not in found]
            read |= attributes_of(textwrap.dedent(text), "run")
            for called in names_of(textwrap.dedent(text)):
                read |= attributes_of(self.texts.get(called, ""), "run")
        self.texts[kind.__name__] = f"\n\nclass {kind.__name__}(Effect):\n" + "\n".join(texts.values())
        return read


def is_defined(thing: Any) -> bool:
    """Whether a thing is a function or a class."""
    return inspect.isfunction(thing) or inspect.isclass(thing)


@cache
def source_of(thing: Any) -> str:
    """The source of a function or class."""
    return inspect.getsource(thing)


@cache
def names_of(text: str) -> tuple[str, ...]:
    """The names that a source reads, those in annotations left out, in their order."""
    tree = ast.parse(text)
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef):
            node.returns = None
            for each in ast.walk(node.args):
                if isinstance(each, ast.arg):
                    each.annotation = None
        elif isinstance(node, ast.AnnAssign):
            node.annotation = ast.Constant(None)
    names = [node for node in ast.walk(tree) if isinstance(node, ast.Name)]
    local = {node.id for node in names if isinstance(node.ctx, ast.Store)}
    local |= {node.arg for node in ast.walk(tree) if isinstance(node, ast.arg)}
    return tuple(dict.fromkeys(node.id for node in names if node.id not in local))


@cache
def attributes_of(text: str, name: str) -> frozenset[str]:
    """What a source reads of what has a name: `run.progress` -> progress."""
    return frozenset(
        node.attr
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == name
    )
