"""A model of an antenna (or of one axis): the file's numbers, checked, and what one may change in it.

A model is frozen. `with_number`, `with_effect` and `with_base` answer a new one that has been through the same checks,
so a model that exists is a model that can be simulated and saved.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from pydantic import ValidationError

from firmware_protocol.documents import Refusals, copied, validated, yaml_text
from firmware_protocol.errors import BadInputError
from firmware_protocol.json_object import Json
from sim_backend.effects import LAWS, Effect, effect_named
from sim_backend.model.file import PARENT, EffectSection, ModelFile, ModelKind, Quantity, read_document
from sim_backend.model.formula import formula_of
from sim_backend.model.laws import Law, LawKind, curve_of
from sim_backend.model.numbers import AXIS_NUMBERS, NUMBER_AT, beside
from sim_backend.model.physical_checks import check_body, check_friction, temperature_table
from sim_backend.model.uncertainty import DEFAULT_SOURCE, Uncertainty, relative_by_source


@dataclass(frozen=True)
class EffectEntry:
    """An effect present on an axis, with its parameters in the catalogue's units."""

    effect: Effect
    axis: str
    parameters: tuple[float, ...]
    #: how far each parameter may be off, as stated or by its source
    uncertainties: tuple[float, ...] = ()
    #: of a law that the file states itself
    law: Law | None = None

    @property
    def states(self) -> int:
        """States in X that it needs."""
        return self.effect.states if self.law is None else self.law.states

    def value(self, name: str) -> float:
        """One parameter by name."""
        return self.parameters[[p.name for p in self.effect.parameters].index(name)]

    def uncertainty(self, name: str) -> float:
        """How far one parameter, by name, may be off."""
        return self.uncertainties[[p.name for p in self.effect.parameters].index(name)]


@dataclass(frozen=True)
class AntennaModel:
    """A validated model: file form, numbers per axis and path, effects, and where it came from."""

    file: ModelFile
    document: Json = field(repr=False)
    where: str
    numbers: Mapping[tuple[str, str], Quantity] = field(repr=False)
    effects: tuple[EffectEntry, ...]
    #: per axis: rows of (temperature degC, friction numbers in FRICTION_ROW order), empty when friction does not depend
    #: on it
    friction_over_temperature: Mapping[str, tuple[tuple[float, ...], ...]]

    @property
    def name(self) -> str:
        """The model's name."""
        return self.file.name

    @property
    def kind(self) -> ModelKind:
        """What moves."""
        return self.file.kind

    @property
    def axes(self) -> tuple[str, ...]:
        """Axis names, the one that carries the other first."""
        return tuple(self.file.axes)

    @property
    def is_linear(self) -> bool:
        """Whether the axis is a linear one (m, N, kg)."""
        return self.kind is ModelKind.LINEAR

    def number(self, axis: str, path: str) -> float:
        """One number, e.g. ("outer", "friction.viscous"), in the unit of the table in numbers.py."""
        return self.numbers[axis, path].value

    def uncertainty(self, axis: str, path: str) -> float:
        """How far one number may be off, to either side, in its unit: as stated beside it, else for the whole file,
        else by its source.

        Zero where the file does not give the number. What is stated for the file or follows from a source is a share of
        the number's size, which for centres of gravity and products of inertia is that of all three together: their
        zeros are not exact. The gain of an axis whose logs are in amperes is known as well as its torque constant.
        """
        path = self.number_path(axis, path)
        quantity = self.numbers[axis, path]
        spread = (
            quantity.uncertainty.absolute(abs(quantity.value))
            if quantity.uncertainty
            else self._by_source(axis, path, quantity)
        )
        constant = self.number(axis, "actuator.torque_constant")
        if path == "actuator.gain_error" and constant > 0.0:
            spread = math.hypot(spread, self.uncertainty(axis, "actuator.torque_constant") / constant)
        return spread

    def _by_source(self, axis: str, path: str, quantity: Quantity) -> float:
        if quantity.source == DEFAULT_SOURCE:
            return 0.0
        size = math.hypot(*(self.number(axis, one) for one in beside(path)))
        return (self.file.uncertainty or Uncertainty(relative_by_source(quantity.source), True)).absolute(size)

    def own_inertia_path(self, axis: str) -> str:
        """Path of the moment of a body about its own axis (the mass on a linear axis)."""
        if self.kind is ModelKind.LINEAR:
            return "body.mass"
        return "body.inertia.yy" if self.kind is ModelKind.GIMBAL and self.axes.index(axis) == 1 else "body.inertia.zz"

    def number_path(self, axis: str, path: str) -> str:
        """A path as effects give it, with `body.own_inertia` resolved for this axis."""
        return self.own_inertia_path(axis) if path == "body.own_inertia" else path

    def with_number(
        self, axis: str, path: str, value: float, source: str | None = None, uncertainty: float | None = None
    ) -> AntennaModel:
        """A model in which one number has another value."""
        return self.with_numbers(axis, {path: value}, source, {} if uncertainty is None else {path: uncertainty})

    def with_numbers(
        self,
        axis: str,
        values: Mapping[str, float],
        source: str | None = None,
        uncertainties: Mapping[str, float] | None = None,
    ) -> AntennaModel:
        """A model in which several numbers of an axis (path -> value) change at once, so that only the outcome need be
        possible.

        `uncertainties` say by path how far off a number may be; one without keeps what the file states beside it.
        """
        document = copied(self.document)
        stated = {self.number_path(axis, path): spread for path, spread in (uncertainties or {}).items()}
        for path, value in values.items():
            path = self.number_path(axis, path)
            section = document["axes"][axis]
            *parents, key = path.split(".")
            for parent in parents:
                section = section.setdefault(parent, {})
            kept = section[key].get("uncertainty") if isinstance(section.get(key), dict) else None
            section[key] = _written(value, NUMBER_AT[path].unit_for(self.is_linear), source, stated.get(path, kept))
        return model_from_document(document, self.where)

    def with_effect(
        self,
        name: str,
        axis: str,
        parameters: Mapping[str, float],
        source: str | None = None,
        uncertainties: Mapping[str, float] | None = None,
    ) -> AntennaModel:
        """A model with one more effect; a number effect (the model already has its numbers) changes those numbers
        instead.

        `uncertainties` say by parameter how far off it may be.
        """
        effect = effect_named(name, f"{self.where}: effects")
        stated = uncertainties or {}
        if effect.is_number:
            paths = {p.name: p.path for p in effect.parameters if p.path is not None}
            given = {path: parameters[key] for key, path in paths.items() if key in parameters}
            return self.with_numbers(
                axis, given, source, {path: stated[key] for key, path in paths.items() if key in stated}
            )
        document = copied(self.document)
        given = {p.name: parameters.get(p.name, p.neutral) for p in effect.parameters}
        entry = {"name": name, "axis": axis} | self._entry(effect, given, source, stated)
        document["effects"] = [*document.get("effects", []), entry]
        return model_from_document(document, self.where)

    def with_strengths(
        self, name: str, axis: str, parameters: Mapping[str, float], source: str | None = None
    ) -> AntennaModel:
        """A model in which an effect that the file states on an axis and that moves in place has other parameters;
        where it states none, a model with it.
        """
        index = self._stated(name, axis)
        if index is None:
            return self.with_effect(name, axis, parameters, source)
        document = copied(self.document)
        document["effects"][index] |= self._entry(self.effects[index].effect, parameters, source, {})
        return model_from_document(document, self.where)

    def _entry(
        self, effect: Effect, parameters: Mapping[str, float], source: str | None, uncertainties: Mapping[str, float]
    ) -> Json:
        """Parameters as a model file has them."""
        found = {}
        for parameter in effect.parameters:
            if parameter.name in parameters:
                unit = parameter.linear_unit if self.is_linear and parameter.linear_unit else parameter.unit
                found[parameter.name] = _written(
                    parameters[parameter.name], unit, source, uncertainties.get(parameter.name)
                )
        return found

    def own_instance(self, name: str, axis: str) -> int | None:
        """Place, among the instances that the plant has, of an effect that the file states on an axis and that moves in
        place; None where there is none.
        """
        index = self._stated(name, axis)
        return None if index is None else sum(not entry.effect.is_number for entry in self.effects[:index])

    def _stated(self, name: str, axis: str) -> int | None:
        """Index in `effects` of the same."""
        found = (
            index
            for index, entry in enumerate(self.effects)
            if (entry.effect.name, entry.axis) == (name, axis) and entry.effect.moves_in_place
        )
        return next(found, None)

    def with_law(self, entry: Mapping[str, object]) -> AntennaModel:
        """A model with one more law of its own: an entry of `effects:` with a `kind`."""
        document = copied(self.document)
        document["effects"] = [*document.get("effects", []), dict(entry)]
        return model_from_document(document, self.where)

    def with_base(self, base: Mapping[str, object]) -> AntennaModel:
        """A model on another base motion (the `base:` section of a model file)."""
        document = copied(self.document)
        document["base"] = dict(base)
        return model_from_document(document, self.where)

    def to_yaml(self) -> str:
        """The model as the text of a model file."""
        return yaml_text(self.document)


def load_model(path: Path | str) -> AntennaModel:
    """Read and check a model file; BadInputError names file, key and expectation."""
    path = Path(path)
    return model_from_document(read_document(path), str(path))


def model_from_document(document: Json, where: str) -> AntennaModel:
    """Check a document that has the form of a model file; `where` names it in errors."""
    document = _in_its_section(document)
    file = validated(ModelFile, document, where)
    expected = 2 if file.kind is ModelKind.GIMBAL else 1
    if len(file.axes) != expected:
        raise BadInputError(
            f"{where}: axes",
            f"{len(file.axes)} axes",
            f"{expected} for kind {file.kind.value} (a gimbal: one axis carries the other)",
        )
    numbers: dict[tuple[str, str], Quantity] = {}
    tables: dict[str, tuple[tuple[float, ...], ...]] = {}
    refusals = Refusals()
    for axis, section in file.axes.items():
        section = {key: value for key, value in section.items() if key != PARENT}
        friction = section.get("friction")
        if isinstance(friction, dict) and "over_temperature" in friction:
            friction = dict(friction)
            with refusals.kept():
                place = f"{where}: axes.{axis}.friction.over_temperature"
                tables[axis] = temperature_table(friction.pop("over_temperature"), place)
            section = {**section, "friction": friction}
        with refusals.kept():
            numbers.update(_axis_numbers(section, axis, file, where))
    refusals.settle()
    if tables and len({len(table) for table in tables.values()} | ({0} if len(tables) < len(file.axes) else set())) > 1:
        raise BadInputError(
            f"{where}: axes",
            "friction tables over temperature differ in length",
            "the same number of rows on every axis",
        )
    effects: tuple[EffectEntry, ...] = ()
    for index, entry_section in enumerate(file.effects):
        with refusals.kept():
            entry = _effect_entry if entry_section.kind is None else _law_entry
            effects += (entry(entry_section, index, file, where),)
    refusals.settle()
    model = AntennaModel(file, document, where, numbers, effects, tables)
    for given, found in zip(file.effects, effects, strict=True):
        for parameter in found.effect.parameters:
            if parameter.path is not None and parameter.name in given.amounts():
                path = model.number_path(found.axis, parameter.path)
                numbers[found.axis, path] = Quantity(
                    value=found.value(parameter.name),
                    unit=NUMBER_AT[path].unit_for(file.kind is ModelKind.LINEAR),
                    source=f"effect {found.effect.name}",
                    uncertainty=Uncertainty(found.uncertainty(parameter.name), False),
                )
    for axis in file.axes:
        with refusals.kept():
            check_body(numbers, axis, file, where)
        with refusals.kept():
            check_friction(numbers, axis, where)
    refusals.settle()
    return model


def _in_its_section(document: Json) -> Json:
    """The document with a torque constant that stands on an axis itself put where the actuator's numbers are."""
    axes = document.get("axes")
    if not isinstance(axes, dict) or not any(
        isinstance(axis, dict) and "torque_constant" in axis for axis in axes.values()
    ):
        return document
    document = copied(document)
    for axis in document["axes"].values():
        actuator = axis.setdefault("actuator", {}) if isinstance(axis, dict) and "torque_constant" in axis else None
        if isinstance(actuator, dict) and "torque_constant" not in actuator:
            actuator["torque_constant"] = axis.pop("torque_constant")
    return document


def _axis_numbers(section: Json, axis: str, file: ModelFile, where: str) -> dict[tuple[str, str], Quantity]:
    given = dict(_leaves(section, ""))
    found: dict[tuple[str, str], Quantity] = {}
    refusals = Refusals()
    for path, raw in given.items():
        place = f"{where}: axes.{axis}.{path}"
        with refusals.kept():
            if path not in NUMBER_AT:
                near = difflib.get_close_matches(path, NUMBER_AT, 1)
                expected = f"{near[0]!r} perhaps" if near else "a number of the model schema"
                raise BadInputError(place, "unknown key", expected)
            number = NUMBER_AT[path]
            unit = number.unit_for(file.kind is ModelKind.LINEAR)
            found[axis, path] = _quantity(raw, place, unit, number.low, number.high)
    refusals.settle()
    for number in AXIS_NUMBERS:
        if (axis, number.path) not in found:
            value = number.default_beside(lambda path: found[axis, path].value)
            unit = number.unit_for(file.kind is ModelKind.LINEAR)
            found[axis, number.path] = Quantity(value=value, unit=unit, source=DEFAULT_SOURCE)
    return found


def _leaves(section: object, prefix: str) -> list[tuple[str, object]]:
    if isinstance(section, dict) and "value" not in section:
        return [
            leaf for key, value in section.items() for leaf in _leaves(value, f"{prefix}.{key}" if prefix else str(key))
        ]
    return [(prefix, section)]


def _quantity(raw: object, place: str, unit: str, low: float, high: float) -> Quantity:
    if isinstance(raw, int | float) and not isinstance(raw, bool):
        raw = {"value": raw}
    if not isinstance(raw, dict):
        raise BadInputError(
            place, f"{raw!r} is no number", f"a number in {unit}, or {{value, unit, source, uncertainty}}"
        )
    try:
        quantity = Quantity.model_validate(raw)
    except ValidationError as error:
        raise BadInputError(place, error.errors()[0]["msg"], f"{{value, unit: {unit}, source, uncertainty}}") from None
    if quantity.unit is not None and _plain(quantity.unit) != _plain(unit):
        raise BadInputError(place, f"unit {quantity.unit!r}", unit)
    if not low <= quantity.value <= high:
        raise BadInputError(place, f"{quantity.value:g} is out of bounds", f"{low:g} to {high:g} {unit}")
    return quantity


def _written(value: float, unit: str, source: str | None, uncertainty: float | str | None) -> Json:
    """A number as it stands in a file."""
    kept = {"source": source, "uncertainty": uncertainty}
    return {"value": float(value), "unit": unit} | {key: item for key, item in kept.items() if item is not None}


def _plain(unit: str) -> str:
    return unit.replace("^", "").replace("*", " ").replace("²", "2")


def _law_entry(entry: EffectSection, index: int, file: ModelFile, where: str) -> EffectEntry:
    place = f"{where}: effects.{index}"
    _require_axis(entry.axis, place, file)
    document = {"kind": entry.kind, "axis": entry.axis, **entry.amounts()}
    read = curve_of if entry.kind is LawKind.CURVE else formula_of
    law = read(document, place, file.kind is ModelKind.LINEAR)
    return EffectEntry(LAWS[law.acts_on.value], entry.axis, (0.0,) * 3, (0.0,) * 3, law)


def _require_axis(axis: str, place: str, file: ModelFile) -> None:
    if axis not in file.axes:
        raise BadInputError(f"{place}.axis", f"no axis {axis!r}", "one of " + ", ".join(file.axes))


def _effect_entry(entry: EffectSection, index: int, file: ModelFile, where: str) -> EffectEntry:
    place = f"{where}: effects.{index}"
    effect = effect_named(entry.name, f"{place}.name")
    _require_axis(entry.axis, place, file)
    if (effect.rotary_only and file.kind is ModelKind.LINEAR) or (
        effect.two_axis_only and file.kind is not ModelKind.GIMBAL
    ):
        raise BadInputError(f"{place}.name", f"{entry.name} cannot be on a {file.kind.value} axis")
    amounts = entry.amounts()
    names = [parameter.name for parameter in effect.parameters]
    for key in amounts:
        if key not in names:
            raise BadInputError(f"{place}.{key}", "unknown key", f"parameters of {entry.name}: {', '.join(names)}")
    values, spreads = [], []
    for parameter in effect.parameters:
        unit = parameter.linear_unit if file.kind is ModelKind.LINEAR and parameter.linear_unit else parameter.unit
        raw = amounts.get(parameter.name, parameter.neutral)
        low, high = min(parameter.low, parameter.neutral), max(parameter.high, parameter.neutral)
        quantity = _quantity(raw, f"{place}.{parameter.name}", unit, low, high)
        values.append(quantity.value)
        stated = quantity.uncertainty or (file.uncertainty if parameter.name in amounts else None)
        shared = relative_by_source(quantity.source if parameter.name in amounts else DEFAULT_SOURCE)
        spreads.append((stated or Uncertainty(shared, True)).absolute(abs(quantity.value)))
    return EffectEntry(effect, entry.axis, tuple(values), tuple(spreads))
