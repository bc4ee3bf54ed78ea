"""Puts identified numbers into a model file's model, each with where it comes from and how well it is known."""

from __future__ import annotations

from collections.abc import Sequence

from gimbal_hil.knowledge.identification.axis_identification import AxisIdentification
from gimbal_hil.knowledge.identification.estimate import Determination, Estimate
from gimbal_hil.knowledge.identification.stribeck import LUGRE_NAMES
from sim_backend.model import AntennaModel


def updated_model(model: AntennaModel, results: Sequence[AxisIdentification]) -> AntennaModel:
    """The model with every identified and weakly identified number replaced; what is not identified keeps value and
    source.

    A model with bristles cannot hold a break-away below Coulomb: then both are the Coulomb level, and the source says
    so. Without bristles (sigma0 is zero) a dip that was found stays. A break-away that was not identified follows
    Coulomb where it stood there.
    """
    for result in results:
        by_name = {e.name: e for e in result.estimates if e.verdict is not Determination.NOT_IDENTIFIED}
        axis = result.axis
        values = {name: (by_name[name].value, *_stated(by_name[name])) for name in LUGRE_NAMES if name in by_name}
        spread = (
            by_name["coulomb"].interval.half_width
            if "coulomb" in by_name
            else model.uncertainty(axis, "friction.coulomb")
        )
        coulomb = values["coulomb"][0] if "coulomb" in values else model.number(axis, "friction.coulomb")
        breakaway = values["breakaway"][0] if "breakaway" in values else model.number(axis, "friction.breakaway")
        has_bristles = "sigma0" in values or model.number(axis, "friction.sigma0") > 0.0
        has_no_bump = model.number(axis, "friction.breakaway") == model.number(axis, "friction.coulomb")
        if "breakaway" not in values and (has_no_bump or breakaway < coulomb):
            # a level that moved makes neither a bump nor a dip that nobody has seen
            values["breakaway"] = (coulomb, "at Coulomb, not identified by itself", spread)
        elif breakaway < coulomb and has_bristles:
            values["breakaway"] = (coulomb, f"set to Coulomb: the data gave {breakaway:.6g}, below it", spread)
        # Coulomb first only where it falls: at no moment may break-away stand below it
        order = (
            ("coulomb", "breakaway")
            if coulomb <= model.number(axis, "friction.breakaway")
            else ("breakaway", "coulomb")
        )
        for name in (*order, *(n for n in LUGRE_NAMES if n not in order)):
            if name in values:
                model = model.with_number(axis, f"friction.{name}", *values[name])
        if "inertia" in by_name:
            model = model.with_number(axis, "body.own_inertia", by_name["inertia"].value, *_stated(by_name["inertia"]))
        if "offset" in by_name:
            # the regression explains torque with the model's own offset in it; what it finds takes from that
            known, found = model.number(axis, "actuator.offset"), by_name["offset"]
            model = model.with_number(axis, "actuator.offset", known - found.value, *_stated(found, known))
    return model


def _stated(estimate: Estimate, taken_from: float | None = None) -> tuple[str, float]:
    """Source and uncertainty of an estimate, as a model file states them; of a number that it is taken from."""
    word = "identified" if estimate.verdict is Determination.IDENTIFIED else "weakly identified"
    low, high = estimate.interval.low, estimate.interval.high
    if taken_from is not None:
        low, high = taken_from - high, taken_from - low
    source = f"{word}, 95 % interval {low:.6g} to {high:.6g}"
    return source, estimate.interval.half_width
