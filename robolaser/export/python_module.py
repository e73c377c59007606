"""`corrected.py`: the calibrated arm as one file of Python that needs NumPy alone."""

import ast
import inspect
import sys
import textwrap
from collections.abc import Iterable
from dataclasses import fields
from functools import cache
from types import ModuleType
from typing import Any, final

import numpy as np

from robolaser.calibration.result import Calibration
from robolaser.export import runtime
from robolaser.export.corrected_arm import CorrectedArm
from robolaser.model.effects.effect import CandidateEffect
from robolaser.model.effects.run import Run
from robolaser.model.forward_model import Model
from robolaser.model.stages import Stage

OF_THE_ARM = (Stage.JOINTS, Stage.LINKS, Stage.FLANGE)
KNOWN = {*dir(runtime.Conditions), *(each.name for each in fields(runtime.Conditions))}
IN_SESSIONS = "progress_of_all"  # attributes of several sessions: a pose of a new run is in none of them
HEAD = '''"""{name}: the calibrated arm. Joint values in, poses of flange and sensor out.

    import corrected
    T_base_flange = corrected.forward([0.1, -0.5, 0.9])

Poses are in metres, in the frame of the URDF's root link. Written by robolaser.
{notes}"""

'''
EFFECT = '''

class Effect:
    """A departure from the nominal arm; `apply` changes what passes its stage."""

    def __init__(self, where, **values):
        self.where = where
        vars(self).update((name, np.array([value])) for name, value in values.items())
'''
BESIDE = frozenset({*sys.stdlib_module_names, "numpy", "scipy"})  # packages that are imported and not copied


@final
class _Sources:
    """Functions and classes with all their dependencies, in the order of definition.

    `given` names are defined elsewhere.
    """

    def __init__(self, given: Iterable[str]) -> None:
        self.imports: dict[str, str] = {}
        self.texts: dict[str, str] = {}  # by name
        self._given = frozenset(given)
        self._of: dict[str, Any] = {}

    def add(self, name: str, thing: Any) -> None:
        """Take a global name with all its dependencies; a ValueError where two things have one name."""
        if name in self._given or self._of.get(name, self) is thing:
            return
        if name in self._of and self._of[name] != thing:
            raise ValueError(f"'{name}' means {self._of[name]!r} here and {thing!r} there.")
        self._of[name] = thing  # before its dependencies, which may call it in turn
        is_defined = inspect.isfunction(thing) or inspect.isclass(thing)
        if isinstance(thing, ModuleType):
            self.imports[name] = f"import {thing.__name__} as {name}"
        elif not is_defined:
            self.texts[name] = f"\n\n{name} = {thing!r}\n"
        elif thing.__module__.partition(".")[0] in BESIDE:
            renamed = "" if name == thing.__name__ else f" as {name}"
            self.imports[name] = f"from {thing.__module__} import {thing.__name__}{renamed}"
        else:
            text = _source_of(thing)
            self.use(text, thing.__module__)
            self.texts[name] = f"\n\n{text}"

    def use(self, text: str, module: str) -> None:
        """Take all global names of a module that a source reads."""
        for name in _names_of(text):
            if name in vars(sys.modules[module]):
                self.add(name, vars(sys.modules[module])[name])

    def add_methods(self, kind: type, wanted: str) -> set[str]:
        """Take a class with one method, and those that it calls; return the attributes of `run` that they read."""
        found, texts, read = [wanted], {}, set[str]()
        for name in found:
            text = _source_of(getattr(kind, name))
            texts[name] = textwrap.indent(text, "    ")
            self.use(text, getattr(kind, name).__module__)
            own = _attributes_of(text, "self")
            found += [each for each in own if callable(getattr(kind, each, None)) and each not in found]
            read |= _attributes_of(text, "run")
            for called in _names_of(text):
                read |= _attributes_of(self.texts.get(called, ""), "run")
        self.texts[kind.__name__] = f"\n\nclass {kind.__name__}(Effect):\n" + "\n".join(texts.values())
        return read


def corrected_module(calibration: Calibration) -> str | None:
    """Joint values in, flange and sensor poses out, by NumPy alone; None without a robot.

    It computes the model, with the source of each effect of joints, links and flange. The stated payload is its mean
    over the poses, and a mount that moves is as at the first pose.
    """
    if calibration.model.dataset.robot is None:
        return None
    arm, model = CorrectedArm(calibration), calibration.model
    run = model.run
    numbers = _numbers(arm, run) | {"FRAMES": calibration.in_cell.flange, "CELL": calibration.in_cell.base}
    sources = _Sources((*numbers, "EFFECTS"))
    for function in (runtime.corrected_targets, runtime.sensor):
        sources.add(function.__name__, function)
    sources.texts = {"Effect": EFFECT} | sources.texts
    made, leaves_out, absent = [], {}, []
    for one, effect in arm.effects:
        read = _read(sources, one, run)
        if read is None:
            absent.append(arm.with_numbers(one))
            continue
        if "reference" in read:
            numbers["CALIBRATED"] = run.q
        needs = _needs(read, run)
        if needs:
            leaves_out[str(one)] = ", ".join(needs)
        sizes = "".join(f", {name}={float(getattr(effect, name)[0])!r}" for name in one.effect.units())
        made.append(f"    ({type(effect).__name__}({one.where!r}{sizes}), {one.effect.stage.name!r}, {needs!r}),\n")
    notes = [f"Not contained: {each}." for each in absent]
    notes += [f"Left out of a pose without {needs}: {each}." for each, needs in leaves_out.items()]
    return "".join(
        [
            HEAD.format(name=_plain(model.dataset.name), notes="".join(f"{_plain(note)}\n" for note in notes)),
            "".join(f"{line}\n" for line in sorted(sources.imports.values())),
            "\n",
            "".join(f"{name} = {_written(value)}\n" for name, value in numbers.items()),
            f"LEAVES_OUT = {leaves_out!r}  # an effect, and what `forward` must be given to contain it\n",
            *sources.texts.values(),
            f"\n\nEFFECTS = [\n{''.join(made)}]\n",
        ]
    )


def contained(model: Model) -> tuple[CandidateEffect, ...]:
    """The effects of a model that are in its `corrected.py`."""
    return tuple(one for one in model.effects if _read(_Sources(()), one, model.run) is not None)


def _read(sources: _Sources, one: CandidateEffect, run: Run) -> set[str] | None:
    """Attributes of its run that an effect reads, its source taken; None if it has none, or a single pose lacks one."""
    if one.effect.stage not in OF_THE_ARM:
        return None
    try:
        read = sources.add_methods(one.effect, "apply")
    except (OSError, TypeError, ValueError):  # a custom effect, typed into an interpreter
        return None
    is_known = read <= KNOWN and not (IN_SESSIONS in read and run.dataset.sessions is not None)
    return read if is_known else None


def _numbers(arm: CorrectedArm, run: Run) -> dict[str, Any]:
    """The numbers that `runtime` uses."""
    robot, temperature = arm.robot, run.poses.temperature_c
    model = robot.by_pinocchio
    spans = [run.poses.time_s[path] for path in run.paths] if run.poses.time_s is not None else []
    duration = max(map(len, spans)) - 1.0 if run.dataset.time_is_order else max(map(np.ptp, spans), default=0.0)
    return {
        "JOINTS": robot.joints,
        "CHAIN": robot.chain,
        "COLUMNS": model.columns,
        "RATIOS": model.ratios,
        "OFFSETS": model.offsets,
        "PARENTS": model.parents.tolist(),
        "PLACEMENTS": model.placements,
        "AXES": model.axes,
        "SLIDES": model.slides,
        "RANGE": np.stack(robot.range),
        "MASSES": np.column_stack([model.masses, model.centres]),
        "TIP": model.tip,
        "END": model.end,
        "GRAVITY": robot.gravity,
        "PAYLOAD_KG": arm.stated_payload_kg,
        "DURATION": float(duration) or 1.0,
        "COLDEST_C": float(temperature.min()) if temperature is not None and run.rise is not None else None,
        "WARMING_C": 0.0 if temperature is None else float(np.ptp(temperature)),
        "CALIBRATED": np.zeros((0, len(robot.joints))),  # unless an effect is relative to them
    }


def _needs(read: set[str], run: Run) -> tuple[str, ...]:
    """The conditions that a pose needs for an effect that reads these attributes of its run."""
    warms = "temperature_c" if "rise" in read and run.rise is not None else "time_s"
    by_name = {"before": {"paths", "approach"}, warms: {"rise", "progress", IN_SESSIONS}, "velocity": {"qd"}}
    return tuple(name for name, parts in by_name.items() if read & parts)


def _written(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{name!r}: {_written(each)}" for name, each in value.items()) + "}"
    return f"np.array({value.tolist()!r})" if isinstance(value, np.ndarray) else repr(value)


def _plain(text: str) -> str:
    return "".join(letter for letter in text if letter.isprintable()).replace("\\", "/").replace('"', "'")


@cache
def _source_of(thing: Any) -> str:
    """A source without annotations, whose names are undefined in the copy; those of a dataclass are `object`."""
    text = textwrap.dedent(inspect.getsource(thing)).encode()
    begin = np.cumsum([0, *map(len, text.splitlines(keepends=True))])
    spans = []
    for node in ast.walk(ast.parse(text)):
        of = getattr(node, "returns", None) or getattr(node, "annotation", None)
        if of is not None:
            start, end = begin[of.lineno - 1] + of.col_offset, begin[of.end_lineno - 1] + of.end_col_offset
            is_field = isinstance(node, ast.AnnAssign)
            begins, instead = (start, b"object") if is_field else (len(text[:start].rstrip(b" ->:")), b"")
            spans.append((begins, end, instead))
    for start, end, instead in sorted(spans, reverse=True):
        text = text[:start] + instead + text[end:]
    return text.decode()


@cache
def _names_of(text: str) -> tuple[str, ...]:
    """The names that a source reads, in their order."""
    tree = ast.parse(text)
    names = [node for node in ast.walk(tree) if isinstance(node, ast.Name)]
    local = {node.id for node in names if isinstance(node.ctx, ast.Store)}
    local |= {node.arg for node in ast.walk(tree) if isinstance(node, ast.arg)}
    return tuple(dict.fromkeys(node.id for node in names if node.id not in local))


@cache
def _attributes_of(text: str, name: str) -> frozenset[str]:
    """Attributes of a name that a source reads: `run.progress` -> progress."""
    return frozenset(
        node.attr
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == name
    )
