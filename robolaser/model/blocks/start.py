"""Start values of a problem's parameters, and those that follow from the others, block by block."""

from collections.abc import Mapping, Sequence

import numpy as np

from robolaser.arrays import Array
from robolaser.data.sessions import OWN, matches
from robolaser.errors import DataError, EstimationError, near
from robolaser.model.blocks.block import Block
from robolaser.model.blocks.blocks import Blocks
from robolaser.model.sensors.sensor import not_given
from robolaser.model.stages import Perturbation
from robolaser.parameters import Parameter, Parameters, Values, from_batch

LENGTH_SPAN_M = 1.0  # closed forms are off by centimetres; an arm's reach bounds the search generously
ANGLE_SPAN_RAD = np.pi


def parameters_of(blocks: Blocks, T_base_flange: Array) -> Parameters:
    """All parameters, sensor after sensor: as given, else around a closed form; each knows the earlier ones.

    Raises:
        DataError: The data set gives one that no sensor has, or not all free ones of a sensor.
        EstimationError: The data do not determine them.
    """
    _check_given(blocks)
    found = dict(blocks.given)
    for of_sensor in _by_knowledge(blocks):
        found |= _of_sensor(of_sensor, found, T_base_flange)
    return Parameters(tuple(found[name] for name in blocks.free + blocks.derived))


def _check_given(blocks: Blocks) -> None:
    """Check that each sensor has rows, and that all given parameters, of the whole or of a session, are theirs."""
    names, sessions = blocks.free + blocks.derived, blocks.dataset.sessions
    for sensor in blocks.dataset.sensors:
        if not len(sensor.rows):
            raise DataError(
                f"{sensor.file} has no rows: sensor {sensor.name} saw nothing. Add its points, or delete it from"
                " [[sensors]].",
                file=sensor.file,
            )
    plain = {name.partition("@")[0] for name in names} if sessions else set()
    for name in blocks.dataset.parameters:
        if name not in names and name not in plain:
            raise DataError(
                f"dataset.toml, [parameters]: no parameter '{name}' here.{near(name, names)}",
                file="dataset.toml",
                column=f"[parameters] {name}",
            )
    known = {name for block in blocks for name in block.named}
    for pattern in () if sessions is None or sessions.own == OWN else sessions.own:
        if not any(matches(name, (pattern,)) for name in known):
            groups = {name.partition(".")[0] + ".*" if "." in name else name for name in known}
            raise DataError(
                f"dataset.toml, [sessions] own: '{pattern}' matches no parameter of this sensor, which has"
                f" {', '.join(sorted(groups))}.",
                file="dataset.toml",
                column="[sessions] own",
            )


def _by_knowledge(blocks: Blocks) -> Sequence[Sequence[Block]]:
    """Sensors whose free parameters are given, then those that start from a closed form, laser planes last."""

    def rank(of_sensor: Sequence[Block]) -> tuple[bool, bool]:
        free = (block.named[name] for block in of_sensor for name in block.sensor.parameters.free)
        return any(name not in blocks.given for name in free), of_sensor[0].sensor.has_laser_plane()

    each = blocks.by_sensor
    return sorted(each, key=rank) if any(rank(of_sensor)[0] for of_sensor in each) else each


def _of_sensor(blocks: Sequence[Block], known: Mapping[str, Parameter], T_base_flange: Array) -> dict[str, Parameter]:
    """The parameters of one sensor in all its sessions: as known, else around its closed forms."""
    free = tuple(dict.fromkeys(block.named[name] for block in blocks for name in block.sensor.parameters.free))
    derived = tuple(dict.fromkeys(block.named[name] for block in blocks for name in block.sensor.parameters.derived))
    given = {name: known[name] for name in free + derived if name in known}
    if any(name not in given for name in free):
        for block in blocks:
            missing = [name for name in block.sensor.parameters.free if block.named[name] not in given]
            if missing and not block.sensor.parameters.closed_form:
                raise not_given(block.sensor.format, missing)
        values = {name: np.array([item.nominal]) for name, item in given.items()}
        started = _initialized(blocks, values, T_base_flange, Perturbation()) | values
        given = _around(blocks, from_batch(started)) | given
    if any(name not in given for name in derived):
        fixed = [name for name in derived if name in given and given[name].fixed]
        fixed += [block.named[name] for block in blocks for name in block.sensor.parameters.fixed]
        nominal = {name: np.array([given[name].nominal]) for name in (*free, *fixed) if name in given}
        found = _initialized(blocks, nominal, T_base_flange, Perturbation())
        at = {name: float(found[name][0]) for name in derived if name not in given}
        given = _around(blocks, {name: item.nominal for name, item in given.items()} | at) | given
    return given


def _around(blocks: Sequence[Block], values: Mapping[str, float]) -> dict[str, Parameter]:
    """Parameters around values from closed forms, with the bounds that the sensor sees fit."""
    found: dict[str, Parameter] = {}
    for block in blocks:
        sensor, own = block.sensor, block.values(values)
        spans, origin = sensor.parameters.spans(own), sensor.parameters.closed_form or "the measurements"
        for name, at in own.items():
            unit, whole = sensor.format.unit_of(name), block.named[name]
            span = spans.get(name, ANGLE_SPAN_RAD if unit == "rad" else LENGTH_SPAN_M)
            found[whole] = Parameter(whole, unit, at, at - span, at + span, given=False, origin=origin)
    return found


def _largest_first(blocks: Sequence[Block]) -> list[Block]:
    return sorted(blocks, key=lambda block: -len(block.rows))


def _initialized(
    blocks: Sequence[Block], values: Values, T_base_flange: Array, perturb: Perturbation
) -> dict[str, Array]:
    """Derived and missing free parameters of one sensor; shared ones from the session with the most rows."""
    found: dict[str, Array] = {}
    for block in _largest_first(blocks):
        own = block.sensor.initialize(*block.at({**found, **values}, T_base_flange, perturb))
        found = block.of_problem(own) | found
    return found


def initialize(blocks: Blocks, values: Values, T_base_flange: Array, perturb: Perturbation) -> dict[str, Array]:
    """Start values of the derived parameters, for each candidate, (c,) by name.

    Sensors with the most rows come first; the others keep their values. Arguments as for a sensor's. A sample may have
    too few rows for some of them.

    Raises:
        EstimationError: No sensor could find any.
    """
    found: dict[str, Array] = {}
    failed: list[EstimationError] = []
    for of_sensor in sorted(blocks.by_sensor, key=lambda each: -sum(len(block.rows) for block in each)):
        try:
            found = _initialized(of_sensor, {**values, **found}, T_base_flange, perturb) | found
        except EstimationError as error:  # few rows of it, as of a sample: another sensor may find the same
            failed.append(error)
    if failed and not found:
        raise failed[0]
    return {name: value for name, value in found.items() if name in blocks.derived}


def conditionally_linear(blocks: Blocks) -> tuple[str, ...]:
    """Free parameters that `solve_conditional` finds from the other free ones; none where sensors share them."""
    each = blocks.one_sensor
    return tuple(dict.fromkeys(block.named[name] for block in each for name in block.sensor.parameters.linear))


def solve_conditional(
    blocks: Blocks, values: Values, T_base_flange: Array, perturb: Perturbation, bounds: Mapping[str, Parameter]
) -> Values:
    """The conditionally linear and the derived parameters that fit best with the others, (c,) each.

    Shared parameters fit best to the session with the most rows, the rest with them. Arguments as for
    `SensorParameters.solve`: the model is linearized at the parameters in `values`.
    """
    linear: dict[str, Array] = {}
    for block in _largest_first(blocks.one_sensor):
        parameters = block.sensor.parameters
        if parameters.solve is None or all(block.named[name] in linear for name in parameters.linear):
            continue
        own = parameters.solve(*block.at(values, T_base_flange, perturb), block.values(bounds))
        if len(blocks) == 1:
            return block.of_problem(own)
        linear = {**{block.named[name]: own[name] for name in parameters.linear}, **linear}
    others = {name: value for name, value in values.items() if name not in blocks.derived}
    return {**linear, **initialize(blocks, {**others, **linear}, T_base_flange, perturb)}
