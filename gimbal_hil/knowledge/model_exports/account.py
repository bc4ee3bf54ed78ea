"""What becomes of each number and effect of a model in another format: held, held nearly, or left out, and why.

Every number and effect that does something in the model is on exactly one of the three lists, so that nothing is
dropped in silence.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from sim_backend.effects import Parameter
from sim_backend.model import NUMBER_AT, AntennaModel, EffectEntry

#: numbers that are no part of the motion: where it starts
_NOT_OF_THE_MODEL = ("start.",)
#: tells what a number is when it does nothing
_NUMBERS_OF = {
    "friction.coulomb": ("coulomb",),
    "friction.breakaway": ("coulomb", "stribeck"),
    "friction.stribeck_velocity": ("stribeck",),
    "friction.shape": ("stribeck",),
    "friction.sigma0": ("presliding",),
    "friction.sigma1": ("presliding",),
    "friction.viscous": ("viscous",),
    "actuator.gain_error": ("torque_gain",),
    "actuator.offset": ("torque_offset",),
    "actuator.limit": ("saturation",),
    "actuator.time_constant": ("actuator_lag",),
    "gyro.bias": ("gyro_bias",),
    "gyro.scale_error": ("gyro_scale",),
}


@dataclass(frozen=True)
class Item:
    """A number (`friction.coulomb`) or an effect (`cogging`) of one axis; `value` with its unit, for people."""

    axis: str
    name: str
    value: str


@dataclass(frozen=True)
class Remark:
    """An item, and how it is held nearly or why it is left out."""

    item: Item
    reason: str

    @property
    def effects(self) -> tuple[str, ...]:
        """Names of the catalogue under which a comparison with the model would find what is missing."""
        return _NUMBERS_OF.get(self.item.name, () if "." in self.item.name else (self.item.name,))


@dataclass(frozen=True)
class ExportedModel:
    """A file in another format, and what became of every item of the model."""

    content: bytes
    held: tuple[Item, ...]
    approximated: tuple[Remark, ...]
    left_out: tuple[Remark, ...]

    @property
    def text(self) -> str:
        """The file as text, of the formats that are."""
        return self.content.decode()


@dataclass(frozen=True)
class Account:
    """What a format does with items, by (axis, name): those it holds, those it holds nearly and how, and why it leaves
    out others; a name that has no reason of its own gets `otherwise`.
    """

    held: frozenset[tuple[str, str]]
    approximated: Mapping[tuple[str, str], str]
    reasons: Mapping[str, str]
    otherwise: str

    def settle(self, model: AntennaModel, text: str) -> ExportedModel:
        """Every item of the model on its list."""
        items = items_of(model)
        place = {(item.axis, item.name): item for item in items}
        nearly = tuple(Remark(place[key], how) for key, how in self.approximated.items() if key in place)
        taken = self.held | self.approximated.keys()
        left = (item for key, item in place.items() if key not in taken)
        return ExportedModel(
            text.encode(),
            tuple(item for key, item in place.items() if key in self.held - self.approximated.keys()),
            nearly,
            tuple(Remark(item, self.reasons.get(item.name, self.otherwise)) for item in left),
        )


def items_of(model: AntennaModel) -> tuple[Item, ...]:
    """All numbers of a model that are not what they are by default, and all its effects."""
    given = model.file.axes

    def is_default(axis: str, path: str, value: float) -> bool:
        return value == NUMBER_AT[path].default_beside(lambda other: model.number(axis, other))

    numbers = (
        Item(axis, path, f"{quantity.value:.6g} {quantity.unit or NUMBER_AT[path].unit_for(model.is_linear)}")
        for (axis, path), quantity in model.numbers.items()
        if axis in given and not is_default(axis, path, quantity.value) and not path.startswith(_NOT_OF_THE_MODEL)
    )
    effects = (
        Item(entry.axis, entry.effect.name, _numbers_of(entry)) for entry in model.effects if not entry.effect.is_number
    )
    tables = (
        Item(axis, "friction.over_temperature", f"{len(rows)} temperatures")
        for axis, rows in model.friction_over_temperature.items()
        if rows
    )
    slips = (Item(model.axes[0], "thesis_slips", slip) for slip in model.file.thesis_slips)
    return (*numbers, *effects, *tables, *slips)


def _numbers_of(entry: EffectEntry) -> str:
    if entry.law is not None:
        return "a curve or formula of the model file"
    return ", ".join(_parameters(entry.effect.parameters, entry.parameters))


def _parameters(parameters: Iterable[Parameter], values: Iterable[float]) -> Iterable[str]:
    return (f"{one.name} {value:.6g}" for one, value in zip(parameters, values, strict=True))
