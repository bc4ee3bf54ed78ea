"""The report of an identification: one self-contained page, and the same as plain records for `identification.json`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from gimbal_hil.knowledge.identification.axis_identification import AxisIdentification, friction_of
from gimbal_hil.knowledge.identification.correlations import of_all_axes
from gimbal_hil.knowledge.identification.estimate import Determination, Estimate, number_text, said
from gimbal_hil.knowledge.identification.figures import (
    correlation_figure,
    hysteresis_figure,
    interval_figure,
    output_error_figure,
    residual_figure,
    velocity_map_figure,
)
from gimbal_hil.knowledge.identification.output_error import OutputErrorFit
from gimbal_hil.knowledge.identification.sliding import MapHalf
from gimbal_hil.knowledge.identification.stribeck import LUGRE_NAMES
from gimbal_hil.knowledge.identification.units import LINEAR, ROTARY, Units
from gimbal_hil.knowledge.identification.velocity_map import VelocityMap
from gimbal_hil.pages.report import Block, Callout, Details, Heading, Page, Plot, Table, Text, Tiles, counted, quantity
from sim_backend.model import AntennaModel, shipped_model_path

_DIRECTIONS = {
    MapHalf.BOTH: "Both directions",
    MapHalf.POSITIVE: "Positive direction",
    MapHalf.NEGATIVE: "Negative direction",
}
_WORDS = {
    Determination.IDENTIFIED: "identified",
    Determination.WEAKLY_IDENTIFIED: "weakly identified",
    Determination.NOT_IDENTIFIED: "not identified",
}


def identification_page(model: AntennaModel, results: Sequence[AxisIdentification], sources: Sequence[str]) -> Page:
    """Everything that was found, axis by axis; `sources` are the logs that were read."""
    cautions = [(result.axis, finding.text) for result in results for finding in result.findings]
    blocks: list[Block] = [Callout(_answer(results), _tone(results))]
    # on a page of one axis everything is of that one
    said = [f"{axis}: {text}" if len(results) > 1 else text for axis, text in _capital(cautions)]
    blocks += [Callout("\n".join(f"{one}." for one in said), "warning")] if said else []
    blocks += [block for result in results for block in _axis_blocks(model, result)]
    blocks.append(Text(f"From {', '.join(sources)}, with {_said(model)} as prior. Intervals are 95 %."))
    return Page(
        "Identified friction", f"model {model.name}, {len(results)} {'axis' if len(results) == 1 else 'axes'}", blocks
    )


def _said(model: AntennaModel) -> str:
    """The model as a person would name it: a shipped one by its name, wherever this machine keeps it."""
    path = Path(model.where)
    return f"the shipped model {path.stem}" if path == shipped_model_path(path.stem) else model.where


def identification_record(results: Sequence[AxisIdentification], sources: Sequence[str]) -> dict[str, object]:
    """Plain types for `identification.json`."""
    return {
        "schema": 1,
        "sources": list(sources),
        "axes": [_axis_record(result) for result in results],
        "correlations": of_all_axes({result.axis: result.correlations for result in results}),
    }


def _axis_blocks(model: AntennaModel, result: AxisIdentification) -> list[Block]:
    prior = friction_of(model, result.axis)
    units = LINEAR if model.is_linear else ROTARY
    priors = [e for e in result.estimates if e.verdict is Determination.NOT_IDENTIFIED]
    blocks: list[Block] = [Heading(result.axis)]
    if len(priors) < len(result.estimates):
        measured = [e for e in result.estimates if e not in priors]
        blocks.append(Tiles([(quantity(e.value, e.unit), _tile_text(e)) for e in measured]))
    if priors:
        stand = ", ".join(f"{said(e.name)} {quantity(e.value, e.unit)}" for e in priors if e.prior is not None)
        none = ", ".join(said(e.name) for e in priors if e.prior is None)
        text = f"Not identified from these logs, so the model's own numbers stand: {stand}." if stand else ""
        blocks.append(Text(f"{text} Not identified, and no number of the model: {none}.".strip() if none else text))
    folded: list[Block] = []
    fits = tuple(fit for fit in (result.both, result.positive, result.negative) if fit is not None)
    if result.velocity_map is not None and result.velocity_map.points:
        blocks.append(
            Plot(
                velocity_map_figure(result.velocity_map, fits, prior.static, units),
                _map_caption(result.velocity_map, units),
            )
        )
        folded += [
            Plot(
                residual_figure(fit, units),
                f"{_DIRECTIONS[fit.direction]}: {_scaled(fit.rms, units.torque)} rms; bars are the points' own 95 %.",
            )
            for fit in fits[:1]
        ]
        folded += _per_direction(result, units.torque)
        folded += _rejected(result)
    drawn = interval_figure(result.estimates, prior, LUGRE_NAMES)
    if drawn.data:
        text = (
            "Dot: the value; bar: its 95 % interval, hidden by the dot where it is narrow. Violet, an open dot: weakly "
            "identified."
        )
        blocks.append(Plot(drawn, text))
    blocks.append(_estimate_table(model, result))
    if len(result.correlations.names) > 1:
        blocks.append(Plot(correlation_figure(result.correlations), _correlation_caption(result)))
    if result.presliding is not None and np.isfinite(result.presliding.rms):
        p = result.presliding
        folded.append(
            Plot(
                hysteresis_figure(p, units),
                f"{p.travel_steps:.0f} encoder steps of travel; stiffness {p.sigma0.fitted:.5g} by the exact curve, "
                f"{p.secant:.5g} by the secant of thesis eq. 4.11.",
            )
        )
    if result.rigid is not None:
        timing = result.rigid.timing
        folded.append(Text(timing.text[:1].upper() + timing.text[1:] + "."))
    if result.dynamic is not None:
        folded.append(
            Plot(
                output_error_figure(result.dynamic, _liveliest(result.dynamic), units),
                f"Output error: rms {result.dynamic.rms:.3g} {units.angle} per 10 ms; "
                f"{result.dynamic.agreeing_starts} starts agree; "
                f"{units.word} offset {result.dynamic.offset:.3g} {units.torque}.",
            )
        )
        folded.append(_sensitivity_table(result.dynamic))
    return [*blocks, Details(f"How {result.axis} was fitted", folded)] if folded else blocks


def _tile_text(estimate: Estimate) -> str:
    """Name of a number that stands in a tile, and how well it is known."""
    share = _share(estimate)
    return said(estimate.name) + (f", ±\u00a0{100.0 * share:.2g}\u00a0% (95\u00a0%)" if np.isfinite(share) else "")


def _share(estimate: Estimate) -> float:
    """Half of the interval as a share of the value; not finite where there is none."""
    half = estimate.interval.half_width
    return half / abs(estimate.value) if estimate.value != 0.0 else np.inf


def _answer(results: Sequence[AxisIdentification]) -> str:
    """How many numbers of all axes were identified, and the one with the widest interval for its size."""
    every = [(result.axis, e) for result in results for e in result.estimates]
    found = [(axis, e) for axis, e in every if e.verdict is Determination.IDENTIFIED]
    axes = " and ".join(result.axis for result in results)
    if all(e.verdict is Determination.NOT_IDENTIFIED for _, e in every):
        return f"No number of {axes} can be had from these logs: the model keeps its own."
    return f"{axes[:1].upper()}{axes[1:]}: {len(found)} of {len(every)} numbers identified{_least_sure(found, axes)}."


def _tone(results: Sequence[AxisIdentification]) -> str:
    """Good where every number is identified and nothing speaks against log or model."""
    if any(result.findings for result in results):
        return "warning"
    every = [e.verdict for result in results for e in result.estimates]
    return "good" if all(verdict is Determination.IDENTIFIED for verdict in every) else "neutral"


def _capital(cautions: Sequence[tuple[str, str]]) -> list[tuple[str, str]]:
    return [(axis[:1].upper() + axis[1:], text[:1].upper() + text[1:]) for axis, text in cautions]


def _least_sure(found: Sequence[tuple[str, Estimate]], axes: str) -> str:
    sized = [(_share(e), axis, e) for axis, e in found if np.isfinite(_share(e))]
    if not sized:
        return ""
    share, axis, least = max(sized, key=lambda one: one[0])
    of = "" if axis == axes else f" of {axis}"
    which = f"{said(least.name)}{of}" if len(sized) == 1 else f"the least sure, {said(least.name)}{of},"
    return f", {which} to ±\u00a0{100.0 * share:.2g}\u00a0%"


def _scaled(value: float, unit: str) -> str:
    """A size with the prefix that puts it at 1 or above."""
    factor, prefix = next(((f, p) for f, p in ((1.0, ""), (1e3, "m")) if value * f >= 1.0), (1e6, "µ"))
    return f"{value * factor:.3g} {prefix}{unit}"


def _liveliest(fit: OutputErrorFit) -> int:
    """The record whose torque changes fastest: there the bristles' damping shows, and the joint is faster than its
    encoder's step.
    """
    return int(np.argmax([float(np.max(np.abs(np.diff(record.torque)))) for record in fit.records]))


def _map_caption(found: VelocityMap, units: Units) -> str:
    jitter = max(point.jitter for point in found.points)
    text = f"Mean friction {units.word} in steady windows, what depends on position taken out; bars are 95 %."
    if jitter > 0.0:
        text += f" The rate fluctuated by up to {quantity(jitter, units.rate)} rms, which the fit allows for."
    return text


def _correlation_caption(result: AxisIdentification) -> str:
    worst = result.correlations.worst(result.axis)
    return (
        f"{worst[:1].upper()}{worst[1:]}. Condition {result.correlations.condition:.3g}. Numbers from different motion "
        "are not correlated."
    )


def _estimate_table(model: AntennaModel, result: AxisIdentification) -> Table:
    sources = {e.name: _source_of(model, result.axis, e.name) for e in result.estimates}
    header = ["parameter", "value", "low", "high", "unit", "verdict", "model given"]
    header += ["where the model has it from"] if any(sources.values()) else []
    parts = [[part[0].upper() + part[1:] for part in (e.reason, e.experiment) if part] for e in result.estimates]
    reasons = [". ".join(part) for part in parts]
    header += ["why, and what would settle it"] if any(reasons) else []
    rows = []
    for e, reason in zip(result.estimates, reasons, strict=True):
        ends = e.end_texts if e.fitted_ends else ("", "")
        name = f"{said(e.name)} ({e.name})" if said(e.name) != e.name else e.name
        row = [
            name,
            e.value_text,
            *ends,
            e.unit,
            _WORDS[e.verdict],
            number_text(e.prior),
        ]
        row += [sources[e.name]] if any(sources.values()) else []
        rows.append([*row, reason] if any(reasons) else row)
    return Table(header, rows)


def _source_of(model: AntennaModel, axis: str, name: str) -> str:
    """What the model file says about where a number comes from; empty where it says nothing."""
    found = model.numbers.get((axis, f"friction.{name}"))
    return found.source or "" if found is not None and found.source != "default" else ""


def _per_direction(result: AxisIdentification, unit: str) -> list[Block]:
    sides = [fit for fit in (result.positive, result.negative) if fit is not None]
    if not sides:
        return []
    rows = []
    for e in sides[0].estimates:
        found = [next(one for one in fit.estimates if one.name == e.name) for fit in sides]
        rows.append([e.name, *(f"{one.fitted_text} ({one.interval_text})" for one in found)])
    rows.append([f"rms [{unit}]", *(number_text(fit.rms) for fit in sides)])
    return [
        Table(
            ["per direction", *(fit.direction.value for fit in sides)], rows, "Each half of the map fitted by itself."
        )
    ]


def _rejected(result: AxisIdentification) -> list[Block]:
    rejected = result.velocity_map.rejected if result.velocity_map else ()
    if not rejected:
        return []
    rows = [[one.label, one.reason] for one in rejected]
    return [
        Details(f"{counted(len(rejected), 'stretch', 'stretches')} gave no point", [Table(["stretch", "why"], rows)])
    ]


def _sensitivity_table(fit: OutputErrorFit) -> Table:
    rows = [[e.name, f"{s:.3g}"] for e, s in zip(fit.estimates, fit.sensitivities, strict=True)]
    return Table(
        ["parameter", "sensitivity"],
        rows,
        "Rms change of the simulated displacement for 1 % of the parameter, in units of its error.",
    )


def _axis_record(result: AxisIdentification) -> dict[str, object]:
    record: dict[str, object] = {
        "axis": result.axis,
        "estimates": [_finite(e.as_record()) for e in result.estimates],
        "correlations": result.correlations.as_record(result.axis),
        "findings": [{"rule": f.rule, "text": f.text} for f in result.findings],
        "break_away": [{"run": b.label, "torque": b.torque} for b in result.break_aways],
    }
    if result.velocity_map is not None:
        record["velocity_map"] = {
            "points": [
                {
                    "rate": p.rate,
                    "torque": p.torque,
                    "standard_error": p.standard_error,
                    "jitter": p.jitter,
                    "passes": p.passes,
                }
                for p in result.velocity_map.points
            ],
            "rejected": [{"stretch": r.label, "reason": r.reason} for r in result.velocity_map.rejected],
        }
    for fit in (result.both, result.positive, result.negative):
        if fit is not None:
            record[f"static_{fit.direction.value}"] = {
                "estimates": [_finite(e.as_record()) for e in fit.estimates], "offset": fit.offset,
                "rms": fit.rms, "outliers": list(fit.outliers),
            }  # fmt: skip
    if result.presliding is not None:
        steps = result.presliding.travel_steps
        record["presliding"] = _finite(
            {"travel_encoder_steps": steps, "secant": result.presliding.secant, **result.presliding.sigma0.as_record()}
        )
    if result.dynamic is not None:
        record["output_error"] = {
            "estimates": [_finite(e.as_record()) for e in result.dynamic.estimates], "offset": result.dynamic.offset,
            "rms_rad": result.dynamic.rms,
            "agreeing_starts": result.dynamic.agreeing_starts,
        }  # fmt: skip
    if result.rigid is not None:
        record["torque_against_position"] = _finite(result.rigid.timing.as_record())
    for name, rigid in (("regression", result.rigid), ("regression_per_direction", result.rigid_per_direction)):
        if rigid is not None:
            record[name] = {
                "estimates": [_finite(e.as_record()) for e in rigid.estimates],
                "rms": rigid.rms,
                "relative": rigid.relative,
                "smoothed": [one.as_record() for one in rigid.smoothed],
            }
    return record


def _finite(record: dict[str, object]) -> dict[str, object]:
    """JSON knows no infinities: they become null."""
    return {
        key: None if isinstance(value, float) and not np.isfinite(value) else value for key, value in record.items()
    }
