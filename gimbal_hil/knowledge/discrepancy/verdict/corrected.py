"""The model file with the named causes: effects appended, numbers corrected."""

from __future__ import annotations

from dataclasses import replace

from gimbal_hil.knowledge.discrepancy.hypotheses import Hypothesis, has_no_bump, parameters_of, values_of
from gimbal_hil.knowledge.discrepancy.judgement import Result
from gimbal_hil.knowledge.discrepancy.twin import Twin, read_number
from sim_backend.effects import CATALOGUE
from sim_backend.model import AntennaModel

#: of a number that a search moved
SOURCE = "identified by gimbal-hil"


def corrected_model(result: Result) -> AntennaModel | None:
    """The input model with the told causes or laws appended or corrected; None where none is told."""
    if result.described is not None:
        return moved_model(result.described.model, result.under.twin, result.best.hypothesis)
    return explained_by(result.model, result.inquiry.twin, result.best.hypothesis) if result.told else None


def explained_by(model: AntennaModel, twin: Twin, hypothesis: Hypothesis) -> AntennaModel:
    """A model as a hypothesis has it: effects appended, numbers corrected."""
    changed = moved_model(model, twin, hypothesis)
    numbers: dict[tuple[str, str], float] = {}
    for index, (effect, axis) in enumerate(hypothesis.labels):
        values = {name: value for name, (value, _) in values_of(model, twin, hypothesis, index).items()}
        if not CATALOGUE[effect].is_number:
            changed = changed.with_strengths(effect, axis, values)
        for parameter in CATALOGUE[effect].parameters:
            if parameter.path is not None and parameter.name in values:
                numbers[axis, model.number_path(axis, parameter.path)] = values[parameter.name]
        for path in {knob.along for knob in hypothesis.causes[index].family.knobs if knob.along is not None}:
            numbers[axis, model.number_path(axis, path)] = read_number(
                model, parameters_of(twin, hypothesis)[1], axis, path
            )
    return with_numbers(changed, numbers)


def recalibrated_model(result: Result) -> AntennaModel:
    """The input model with the known numbers where they came to rest inside their uncertainty."""
    return moved_model(result.model, result.under.twin, replace(result.best.hypothesis, causes=()))


def moved_model(model: AntennaModel, twin: Twin, hypothesis: Hypothesis) -> AntennaModel:
    """A model with its known numbers where a hypothesis has them, held to an antenna that can be."""
    moved = moved_numbers(model, twin, hypothesis)
    for axis in model.axes:
        if (axis, "friction.coulomb") in moved and has_no_bump(model, axis):
            moved[axis, "friction.breakaway"] = moved[axis, "friction.coulomb"]
    return with_numbers(model, moved)


def moved_numbers(model: AntennaModel, twin: Twin, hypothesis: Hypothesis) -> dict[tuple[str, str], float]:
    """Known numbers by (axis, path) where a hypothesis has them."""
    _, P = parameters_of(twin, hypothesis)
    return {(k.axis, k.path): read_number(model, P, k.axis, k.path) for k in hypothesis.floating}


def with_numbers(model: AntennaModel, numbers: dict[tuple[str, str], float]) -> AntennaModel:
    """Several numbers at once; with bristles in an order in which break-away never falls below Coulomb, where the twin
    too holds it.
    """
    numbers = dict(numbers)
    for axis in {axis for axis, _ in numbers}:
        low, high = "friction.coulomb", "friction.breakaway"
        coulomb = numbers.get((axis, low), model.number(axis, low))
        has_bristles = numbers.get((axis, "friction.sigma0"), model.number(axis, "friction.sigma0")) > 0.0
        if has_bristles and numbers.get((axis, high), model.number(axis, high)) < coulomb:
            numbers[axis, high] = coulomb

    def order(item: tuple[tuple[str, str], float]) -> int:
        (axis, path), value = item
        rising = value >= model.number(axis, path)
        return {"friction.breakaway": 0 if rising else 3, "friction.coulomb": 1 if rising else 2}.get(path, 1)

    for (axis, path), value in sorted(numbers.items(), key=order):
        if value != model.number(axis, path):
            model = model.with_number(axis, path, value, SOURCE)
    return model
