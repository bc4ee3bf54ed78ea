"""From a diagnosis to the verdict (docs/verdict.md): named, ambiguous, unexplained, no discrepancy."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from gimbal_hil.discrepancy.completeness import COMPLETE_FLOORS
from gimbal_hil.discrepancy.contradictions import contradictions
from gimbal_hil.discrepancy.corrected import corrected_model, recalibrated_model
from gimbal_hil.discrepancy.families import Family
from gimbal_hil.discrepancy.fit import residual_of
from gimbal_hil.discrepancy.forms import undetermined_form
from gimbal_hil.discrepancy.hypothesis import values_of
from gimbal_hil.discrepancy.intervals import parameter_intervals
from gimbal_hil.discrepancy.record import RATE_ERROR, Channel
from gimbal_hil.discrepancy.rivals import compare
from gimbal_hil.discrepancy.screening import responses
from gimbal_hil.discrepancy.separating import CHANCE, separating_run, why_not_testable
from gimbal_hil.discrepancy.smoothing import Floats
from gimbal_hil.discrepancy.where import Regime, most_telling, regimes
from gimbal_hil.discrepancy.wording import contradiction_of, told, told_against
from gimbal_hil.discrepancy.workflow import Diagnosis
from gimbal_hil.signals import SignalsTable
from sim_backend.effects import CATALOGUE
from sim_backend.model import AntennaModel

#: length of the blocks that a closed share is drawn from, s
_BLOCK_S = 1.0
#: a response below this many floors at a generous size leaves no trace
_NO_TRACE = 0.15
#: floors above which a second channel is worth a place
_HAS_A_GAP = 1.3


def verdict_of(diagnosis: Diagnosis, logs: Sequence[SignalsTable] = ()) -> dict[str, Any]:
    """The content of verdict.json; with the `logs` themselves it also says where they contradict one another."""
    best, null = diagnosis.best, diagnosis.null
    gaps = gap_entries(diagnosis)
    worst = int(np.argmax([g["before"] / g["noise_floor"] for g in gaps]))
    causes = best.hypothesis.causes if diagnosis.complete else ()
    effects, alternatives, next_run = [], [], None
    for index in range(len(causes)):
        entry, others, run = _effect_entry(diagnosis, index)
        effects.append(entry)
        alternatives += others
        next_run = next_run or run
    effects.sort(key=lambda e: -e["held_out_gain"])
    if causes:
        verdict = "named" if all(e["status"] == "named" for e in effects) else "ambiguous"
    elif (
        float(np.max(diagnosis.search.gaps(null))) <= COMPLETE_FLOORS
        or diagnosis.only_noise
        or (diagnosis.complete and diagnosis.floated is not None)
    ):
        verdict = "no_discrepancy"
    else:
        verdict = "unexplained"
    if not causes:
        effects, alternatives = [], []
    where = [_where_entry(r) for r in where_of(diagnosis, worst)] if verdict != "no_discrepancy" else []
    gap = gaps[worst]
    against = contradictions(corrected_model(diagnosis) or recalibrated_model(diagnosis), logs)
    return {
        "schema": 1,
        "verdict": verdict,
        "text": told(diagnosis, verdict, effects, alternatives, gaps) + "".join(told_against(found) for found in against),
        "where": where,
        "effects": effects,
        "alternatives": alternatives,
        "next_experiment": next_run,
        "not_testable": not_testable(diagnosis),
        "gap": gap,
        "gaps": gaps,
        "recalibrated": recalibrated(diagnosis),
        "contradictions": against,
    }


def gap_entries(diagnosis: Diagnosis) -> list[dict[str, Any]]:
    """One gap per channel, on rows that neither selected nor tuned anything."""
    keep = diagnosis.complete and (diagnosis.best.hypothesis.causes or diagnosis.floated is not None)
    search, after = diagnosis.search, diagnosis.best if keep else diagnosis.null
    null_rows, after_rows = diagnosis.null.untouched, after.untouched
    # hypotheses are compared in the same units, whatever the floors were when they were fitted
    null_rows = residual_of(search.holdout, diagnosis.null.hypothesis, search.floor)[diagnosis.untouched]
    after_rows = residual_of(search.holdout, after.hypothesis, search.floor)[diagnosis.untouched]
    found = []
    for j, channel in enumerate(search.twin.channels):
        floor, unit = float(search.floor[j]), _unit(diagnosis.model, channel)
        before, left = (float(np.sqrt(np.mean(rows[:, j] ** 2))) * floor for rows in (null_rows, after_rows))
        closed = low = high = None
        if before > 1.1 * floor:
            closed, low, high = _closed(null_rows[:, j] ** 2, after_rows[:, j] ** 2, _row_s(diagnosis))
        found.append({
            "axis": channel.axis, "signal": channel.signal, "unit": unit, "band_hz": [0.0, search.twin.records[0].bands.scored_hz],
            "before": before, "after": left, "noise_floor": floor, "noise_floor_from": _floor_source(diagnosis, j),
            "processing_floor": float(diagnosis.processing[j]), "closed_fraction": closed, "closed_low": low, "closed_high": high,
            "on": "held-out",
        })  # fmt: skip
    return found


def _closed(before: Floats, after: Floats, row_s: float) -> tuple[float, float, float]:
    """Closed share of the gap and its block-bootstrap interval; squares in floors."""
    length = max(2, int(_BLOCK_S / row_s))
    n = len(before) // length * length
    b, a = before[:n].reshape(-1, length).mean(axis=1), after[:n].reshape(-1, length).mean(axis=1)
    draws = np.random.default_rng(2).integers(0, len(b), (300, len(b)))

    def share(x: Floats, y: Floats) -> Floats:
        return np.asarray(1.0 - (y - 1.0) / np.maximum(x - 1.0, 1e-9))

    low, high = np.quantile(share(b[draws].mean(axis=1), a[draws].mean(axis=1)), [0.05, 0.95])
    return float(min(1.0, float(share(np.asarray(before.mean()), np.asarray(after.mean()))))), float(min(1.0, low)), float(min(1.0, high))


def _row_s(diagnosis: Diagnosis) -> float:
    bands = diagnosis.search.twin.records[0].bands
    return bands.stride * bands.period_s


def _unit(model: AntennaModel, channel: Channel) -> str:
    if channel.signal == RATE_ERROR:
        return "m/s" if model.is_linear else "rad/s"
    return "N" if model.is_linear else "N m"


def _floor_source(diagnosis: Diagnosis, j: int) -> str:
    floor = diagnosis.floors[j]
    return "repeats" if floor.from_repeats is not None and floor.rms == floor.from_repeats else "spectrum above the band (upper bound)"


def _effect_entry(diagnosis: Diagnosis, index: int) -> tuple[dict[str, Any], list[dict[str, Any]], dict[str, Any] | None]:
    model, best, search = diagnosis.model, diagnosis.best, diagnosis.search
    effect, axis = best.hypothesis.labels[index]
    comparisons = sorted((compare(diagnosis.search, diagnosis.best, rival) for rival in diagnosis.rivals[index]), key=lambda c: c.extra)
    close = [c for c in comparisons if c.close and search.complete(c.rival, diagnosis.null)]
    # commanded torque alone cannot tell the two apart: either name is right
    twins = {c.rival.hypothesis.labels[-1][0] for c in close} == {CATALOGUE[effect].same_by_command}
    silent = search.exact and not search.heard_on_holdout(best, index)
    status = "named" if (not close or twins) and not diagnosis.suspected_only and not silent else "ambiguous"
    linear = model.is_linear
    intervals = parameter_intervals(search, best, index)
    parameters = {}
    for name, (value, nominal) in values_of(model, search.twin, best.hypothesis, index).items():
        parameter = next(p for p in CATALOGUE[effect].parameters if p.name == name)
        low, high = intervals.get(name, (value, value))
        unit = parameter.linear_unit if linear and parameter.linear_unit else parameter.unit
        parameters[name] = {"value": value, "low": low, "high": high, "unit": unit, "nominal": nominal}
    gain, control = _gains(diagnosis, index)
    nearest = min((c.told_apart for c in comparisons if c not in close), default=10.0)
    confidence = 0.5 * (1.0 + math.erf(min(nearest, 8.0) / 2.83)) if not close else 1.0 / (1.0 + len(close))
    entry = {"name": effect, "axis": axis, "status": status, "parameters": parameters, "held_out_gain": gain, "best_control_gain": control,
             "confidence": round(min(confidence, 0.999), 3)}  # fmt: skip
    contradiction = contradiction_of(entry)
    if contradiction:
        entry["contradiction"] = contradiction
    form = undetermined_form(search, best.fit, index)
    if form is not None:
        entry["form_undetermined"] = form
    others, run = [], None
    for c in close[:3]:
        other, other_axis = c.rival.hypothesis.labels[-1]
        reason = f"on this data it explains the hold-out as well: {c.extra:+.1%} squares, {c.told_apart:.1f} standard errors"
        others.append({"name": other, "axis": other_axis, "instead_of": effect, "reason": reason})
    if close and not twins:
        other = close[0].rival.hypothesis.labels[-1][0]
        run = {"plan": separating_run(effect, other, {n: e.excited_by for n, e in CATALOGUE.items()}), "separates": [effect, other]}
    elif silent:
        run = {"plan": f"the hold-out has no trace of it; as a hold-out, {CATALOGUE[effect].excited_by}", "separates": [effect, CHANCE]}
    elif diagnosis.suspected_only:
        run = {"plan": "the same causes on another trajectory, given as --holdout", "separates": [effect, CHANCE]}
    return entry, others, run


def _gains(diagnosis: Diagnosis, index: int) -> tuple[float, float]:
    """Share of the gap that a cause takes on the hold-out, and what the best matched nonsense takes of it on the fitted data."""
    search, best = diagnosis.search, diagnosis.best
    without = search.refitted(best.hypothesis.minus(index))
    base = max(float(np.sum(np.mean(diagnosis.null.holdout**2, axis=0) - 1.0)), 1e-9)
    gain = float(np.sum(np.mean(without.holdout**2, axis=0) - np.mean(best.holdout**2, axis=0))) / base
    fitted = max(float(np.sum(diagnosis.null.fit.residual**2)) - diagnosis.null.fit.residual.size, 1e-9)
    return min(gain, 1.0), search.nonsense(without, best.hypothesis.causes[index]) / fitted


def where_of(diagnosis: Diagnosis, worst: int) -> list[Regime]:
    """The most telling regimes of the channel `worst`, which the verdict speaks of, and of the next one that has a gap.

    Judged on the fitted data of the model as it stands.
    """
    rms = np.sqrt(np.mean(diagnosis.null.fit.residual**2, axis=0))
    others = [int(j) for j in np.argsort(-rms) if j != worst and rms[j] > _HAS_A_GAP]
    found = []
    for j in (worst, *others[:1]):
        channel = diagnosis.search.twin.channels[j]
        found += most_telling(regimes(diagnosis.search.twin, diagnosis.null.fit.residual, channel, j), 3)
    return found


def _where_entry(regime: Regime) -> dict[str, Any]:
    return {"axis": regime.axis, "signal": regime.signal, "regime": regime.regime, "share_of_gap": round(regime.share_of_gap, 4),
            "low": round(regime.low, 4), "high": round(regime.high, 4), "share_of_time": round(regime.share_of_time, 4)}  # fmt: skip


def not_testable(diagnosis: Diagnosis) -> list[dict[str, str]]:
    """Effects of the catalogue that leave no trace in this data, with the reason."""
    search, model = diagnosis.search, diagnosis.model
    found = []
    moving = any(r.moving_base for r in search.twin.records)
    warm = any(r.has_temperature for r in search.twin.records)
    tested = {family.label: family for family in search.families}
    for axis in model.axes:
        gyro = diagnosis.has_gyro[model.axes.index(axis)]
        for name, effect in CATALOGUE.items():
            if (effect.rotary_only and model.is_linear) or (effect.two_axis_only and len(model.axes) < 2):
                continue
            family = tested.get((name, axis))
            if family is None or (not family.ripple and _traceless(diagnosis, family)):
                found.append({"name": name, "axis": axis, "reason": why_not_testable(name, moving, gyro, warm)})
    return found


def _traceless(diagnosis: Diagnosis, family: Family) -> bool:
    search = diagnosis.search
    # tried as finite changes from several places: none of them says what it could do
    if len(family.starts) > 2:
        return False
    heard = search.heard(family.label) or _listened(diagnosis, family)
    return not any(float(np.sqrt(np.mean(columns**2))) > _NO_TRACE for columns in heard)


def _listened(diagnosis: Diagnosis, family: Family) -> list[Floats]:
    search, fit = diagnosis.search, diagnosis.null.fit
    columns = (responses(search.twin, fit, search.floor, family, start) for start in family.starts)
    return [found for found in columns if found is not None]


def recalibrated(diagnosis: Diagnosis) -> list[dict[str, Any]]:
    """Known numbers that moved when they had to float."""
    chosen = diagnosis.best.hypothesis
    return [
        {"axis": k.axis, "path": k.path, "value": k.moved(nominal, y), "nominal": nominal}
        for k, y in zip(chosen.floating, chosen.y, strict=True)
        for nominal in (diagnosis.model.number(k.axis, k.path),) if abs(y) > 1e-3
    ]  # fmt: skip
