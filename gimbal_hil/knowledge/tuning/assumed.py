"""Assumed, unmeasured numbers on which tuned loops depend, as the model's sources state them."""

from __future__ import annotations

from dataclasses import dataclass

from gimbal_hil.pages.report import quantity
from sim_backend.model import NUMBER_AT, AntennaModel

_WORD = "assumed"
#: numbers of an axis that gains and margins follow from; `own` stands for its own inertia
_NUMBERS = (
    "own",
    "friction.breakaway",
    "friction.coulomb",
    "friction.sigma0",
    "actuator.limit",
    "actuator.time_constant",
    "encoder.step",
    "encoder.noise",
    "gyro.bandwidth",
    "gyro.noise",
    "gyro.step",
)
_EFFECTS = ("transport_delay", "structural_resonance")


@dataclass(frozen=True)
class AssumedNumber:
    """A number of an axis with its unit."""

    axis: str
    name: str
    value: float
    unit: str

    @property
    def text(self) -> str:
        """For people."""
        return f"{self.axis} {self.name} {quantity(self.value, self.unit)}"


def assumed_numbers(model: AntennaModel) -> tuple[AssumedNumber, ...]:
    """Those of the numbers that loops are tuned for whose source says that they are assumed, axis by axis."""
    found = []
    for axis in model.axes:
        for path in (model.own_inertia_path(axis) if one == "own" else one for one in _NUMBERS):
            number = model.numbers[axis, path]
            if is_assumed(model, axis, path):
                unit = number.unit or NUMBER_AT[path].unit_for(model.is_linear)
                found.append(AssumedNumber(axis, path, number.value, unit))
        for given, entry in zip(model.file.effects, model.effects, strict=True):
            if entry.axis != axis or entry.effect.name not in _EFFECTS:
                continue
            for name, raw in given.amounts().items():
                if isinstance(raw, dict) and str(raw.get("source", "")).startswith(_WORD):
                    called = f"{entry.effect.name}.{name}"
                    found.append(AssumedNumber(axis, called, entry.value(name), str(raw.get("unit", ""))))
    return tuple(found)


def is_assumed(model: AntennaModel, axis: str, path: str) -> bool:
    """Whether the source of a number says that it is assumed."""
    number = model.numbers.get((axis, path))
    return number is not None and (number.source or "").startswith(_WORD)


def caution(numbers: tuple[AssumedNumber, ...]) -> str:
    """What a user should know of them; empty where there are none."""
    if not numbers:
        return ""
    lines = [
        f"  {axis}: {', '.join(one.text.removeprefix(f'{axis} ') for one in numbers if one.axis == axis)}"
        for axis in dict.fromkeys(one.axis for one in numbers)
    ]
    return "\n".join(
        [
            f"caution: {len(numbers)} numbers that these loops hang on are assumed, not measured. Measure delay, gyro "
            "and modes before you trust the margins (experiment step, sweep; identify; discrepancy)",
            *lines,
        ]
    )
