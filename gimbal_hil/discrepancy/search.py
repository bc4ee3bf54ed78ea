"""The search: screen every family, refine the best together with what is there, judge on the hold-out, add, try every slot again, prune."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from gimbal_hil.discrepancy.completeness import CALM_FLOORS, COMPLETE_FLOORS, Half, explains, rms, throughout
from gimbal_hil.discrepancy.families import Family
from gimbal_hil.discrepancy.fit import Fit, refit, residual_of
from gimbal_hil.discrepancy.hypothesis import Cause, Hypothesis
from gimbal_hil.discrepancy.screening import (
    Proposal,
    Response,
    basis_of,
    control_gain,
    family_table,
    propose,
    responses,
)
from gimbal_hil.discrepancy.smoothing import Floats
from gimbal_hil.discrepancy.twin import Twin
from sim_backend.effects import Start

#: most steps of a refit; nearly linear causes need two or three of them, a rattling gap more
_ROUNDS = 6
#: families refined per round, after screening
_REFINED = 6
#: a family of more coordinates than this is refined from more than two of its starts
_VALLEYS = 3
#: and how many of the refined may be taken, each beside its negative control
_IN_QUESTION = 4
#: most effects that one verdict may name
MOST_CAUSES = 4
#: change of a sensitive coordinate (a gap, log) by which a rattling twin is asked how well it repeats itself
_NUDGE = 2e-3
#: what matched nonsense may take of what a cause takes
_NONSENSE = 0.5
#: length of the blocks whose signs nonsense draws, s
_SIGN_S = 0.7
#: an addition must take this share of the gap on the hold-out, and this many squared floors a row on some channel
_LEAST_SHARE, _LEAST_SQUARES = 0.02, 0.12
#: the share where the model carries no bristle and is never followed to the noise
_COARSE_LEAST_SHARE = 0.06
#: an addition that changes the hold-out by fewer floors than this is not heard there; it must then take this share of the fitted gap
_NO_CHANGE, _NEARLY_ALL = 0.1, 0.85


@dataclass(frozen=True)
class Scored:
    """A refined hypothesis with its residuals on the data it was fitted to and on the hold-out."""

    fit: Fit
    #: rows of the hold-out that may select
    holdout: Floats
    #: rows that neither select nor tune
    untouched: Floats

    @property
    def hypothesis(self) -> Hypothesis:
        """The hypothesis at its fitted coordinates."""
        return self.fit.hypothesis

    @property
    def held_out_cost(self) -> float:
        """Mean square per row on the hold-out, summed over channels, in squared floors."""
        return float(np.sum(np.mean(self.holdout**2, axis=0)))

    @property
    def cost(self) -> float:
        """The same with the fitted rows beside it: a hold-out that hardly excites a cause ranks by noise what the other log decides."""
        return self.held_out_cost + float(np.sum(np.mean(self.fit.residual**2, axis=0)))


@dataclass(frozen=True)
class Round:
    """What one round tried beside the hypothesis that it started from."""

    before: Scored
    tried: tuple[Scored, ...]
    #: (effect, axis) -> screening gain per row
    screened: dict[tuple[str, str], float]
    #: (effect, axis) -> what matched nonsense of that candidate takes, squared floors over the fitted rows
    controls: dict[tuple[str, str], float] = field(default_factory=dict)

    def taken(self, tried: Scored) -> float:
        """Squared floors over the fitted rows that a candidate takes."""
        return self.before.fit.cost - tried.fit.cost

    def beats_nonsense(self, tried: Scored) -> bool:
        """Whether a candidate takes twice what its own response takes when it is reversed and shifted in time."""
        taken = self.taken(tried)
        return taken > 0.0 and self.controls[tried.hypothesis.labels[-1]] < _NONSENSE * taken


Progress = Callable[[str], None]


@dataclass
class Search:
    """State of a search: fitted data, hold-out, floors, families, and how work is spread."""

    twin: Twin
    holdout: Twin
    #: the fitted logs and the rows of the hold-out that may select, as one
    selectable: Twin
    floor: Floats
    families: list[Family]
    #: run `respond` for families and `refit` for hypotheses, in parallel where it can
    listen: Callable[[Fit, list[Family]], list[Response]]
    refine: Callable[[list[Hypothesis], Floats | None], list[Fit]]
    spread: float
    #: rows of the hold-out's residual that may select; the others are only looked at
    selecting: NDArray[np.bool_]
    progress: Progress = lambda text: None
    #: a twin's logs with other draws of the encoder's error
    read_again: Callable[[Twin], tuple[Twin, ...]] = lambda twin: ()
    #: the model carries a bristle on every axis, so that its twin can be followed to the noise; without one no twin is exact
    exact: bool = True
    #: Jacobian of the known numbers where they first floated; responses of the families that do not depend on the residual, heard once
    #: beside the model as it stands; each with its floors
    _floating: tuple[Floats, Floats] | None = None
    _heard: tuple[list[Response], Floats] | None = None

    def scored(self, fit: Fit) -> Scored:
        """Put a fit on the hold-out."""
        rows = np.nan_to_num(residual_of(self.holdout, fit.hypothesis, self.floor), nan=1e6, posinf=1e6, neginf=-1e6)
        return Scored(fit, rows[self.selecting], rows[~self.selecting])

    def refitted(self, hypothesis: Hypothesis, rounds: int = _ROUNDS, enough: float = 1e-4) -> Scored:
        """A hypothesis at its best coordinates, put on the hold-out."""
        return self.scored(self._fitted(hypothesis, rounds, enough))

    def _fitted(self, hypothesis: Hypothesis, rounds: int, enough: float = 1e-4) -> Fit:
        known = self._known_columns(hypothesis)
        return self.cut(refit(self.home(hypothesis), hypothesis, self.floor, rounds, known, self.spread, enough))

    def home(self, hypothesis: Hypothesis) -> Twin:
        """The logs that a hypothesis is fitted to: a gap also to the rows of the hold-out that may select.

        What one log hardly says of its numbers another may say clearly.
        """
        gap = any(cause.family.valley for cause in hypothesis.causes) and not hypothesis.floating
        return self.selectable if gap else self.twin

    def cut(self, fit: Fit) -> Fit:
        """The part of a fit that stands for the fitted logs."""
        rows = sum(int(record.keep.sum()) for record in self.twin.records)
        return Fit(fit.hypothesis, fit.residual[:rows], fit.jacobian[: rows * fit.residual.shape[1]])

    def again(self, state: Scored) -> Scored:
        """The same under the present floors."""
        return self.refitted(state.hypothesis)

    def gaps(self, state: Scored) -> Floats:
        """Rms per channel in floors, the larger of fitted data and hold-out."""
        return np.maximum(rms(state.fit.residual), rms(state.holdout))

    def null(self, hypothesis: Hypothesis | None = None) -> Scored:
        """The model as it stands (or with known numbers refitted)."""
        state = self.scored(refit(self.twin, hypothesis or Hypothesis(), self.floor, rounds=4, spread=self.spread))
        if state.hypothesis.floating:
            self._floating = state.fit.jacobian, self.floor.copy()
        return state

    def one_round(self, state: Scored, least: int = _REFINED) -> Round:
        """Screen all families beside a state, refine the best, put them on the hold-out."""
        allowed = family_table(state.hypothesis, self.families)
        proposals = propose(state.fit, self._responses(state, allowed), self.spread)
        best: dict[tuple[str, str], list[Proposal]] = {}
        for proposal in sorted(proposals, key=lambda p: -p.gain):
            best.setdefault(proposal.family.label, []).append(proposal)
        ranked = sorted(best.values(), key=lambda found: -found[0].gain)
        chosen = [p for found in ranked[:least] for p in found[: _starts_refined(found[0].family)]]
        fits = self.refine([state.hypothesis.plus(Cause(p.family, p.x)) for p in chosen], self._known_columns(state.hypothesis))
        best_fit: dict[tuple[str, str], Fit] = {}
        for fit in fits:
            label = fit.hypothesis.labels[-1]
            if label not in best_fit or fit.cost < best_fit[label].cost:
                best_fit[label] = fit
        tried = sorted((self.scored(fit) for fit in best_fit.values()), key=lambda s: s.cost)
        rows = len(state.fit.residual)
        return Round(state, tuple(tried), {label: found[0].gain / rows for label, found in best.items()})

    def _responses(self, state: Scored, allowed: list[Family]) -> list[Response]:
        """Ripples anew, since their orders come from the residual; all others from the first hearing, in the present floors."""
        if self._heard is None:
            self._heard = self.listen(state.fit, [f for f in self.families if not f.ripple]), self.floor.copy()
        labels = {f.label for f in allowed}
        heard, floor = self._heard
        scale = np.tile(floor / self.floor, len(state.fit.residual))[:, None]
        kept = [replace(r, columns=r.columns * scale) for r in heard if r.family.label in labels]
        return kept + self.listen(state.fit, [f for f in allowed if f.ripple])

    def heard(self, label: tuple[str, str]) -> list[Floats]:
        """Columns of a family's responses beside the model as it stands, as far as they have been heard."""
        return [r.columns for r in self._heard[0] if r.family.label == label] if self._heard is not None else []

    def _known_columns(self, hypothesis: Hypothesis) -> Floats | None:
        """Jacobian of the known numbers as it was when they first floated, in the present floors; None where none float."""
        if not hypothesis.floating or self._floating is None:
            return None
        columns, floor = self._floating
        return np.asarray(columns * np.tile(floor / self.floor, len(columns) // len(floor))[:, None])

    def complete(self, state: Scored, null: Scored) -> bool:
        """Whether every channel is explained: near its floor, or nearly all of its gap closed, on both halves of the data."""
        bands = self.twin.records[0].bands
        halves = (
            Half(null.holdout, state.holdout, partial(self._unsteadiness, self.holdout, state.hypothesis)),
            Half(null.fit.residual, state.fit.residual, partial(self._unsteadiness, self.twin, state.hypothesis)),
        )
        return explains(halves, bool(state.hypothesis.causes), self.exact, bands)

    def _unsteadiness(self, twin: Twin, hypothesis: Hypothesis) -> Floats:
        """Rms per channel, in floors, by which a twin with a gap changes when the gap hardly does, or when the encoder errs otherwise.

        Impacts forget where they came from: what a rattling twin does not repeat it cannot be asked to explain.
        """
        nudged = tuple(
            replace(cause, x=tuple(x + (_NUDGE if j == cause.family.sensitive_knob else 0.0) for j, x in enumerate(cause.x)))
            for cause in hypothesis.causes
        )
        if nudged == hypothesis.causes:
            return np.zeros(len(twin.channels))
        here = residual_of(twin, hypothesis, self.floor)
        nudge = residual_of(twin, replace(hypothesis, causes=nudged), self.floor) - here
        others = [residual_of(other, hypothesis, self.floor) - here for other in self.read_again(twin)]
        if not all(np.all(np.isfinite(change)) for change in (nudge, *others)):
            return np.zeros(len(twin.channels))
        return np.maximum(rms(nudge), rms(np.concatenate(others)) if others else 0.0)

    def unrepeated(self, state: Scored) -> float:
        """Squared floors a row that the twins of fitted data and hold-out together do not repeat: no more tells two states apart."""
        return float(sum(np.sum(self._unsteadiness(twin, state.hypothesis) ** 2) for twin in (self.twin, self.holdout)))

    def worth(self, before: Scored, after: Scored) -> bool:
        """Whether an addition earns its place on the hold-out: a share of what is left without it; small causes follow huge ones.

        One that the hold-out has no trace of earns it where it takes nearly all of what is left of the fitted data. Beside a rattling gap
        it must take more than the twin does not repeat.
        """
        if not self.exact and not throughout([(before.fit.residual, after.fit.residual)], self.twin.records[0].bands):
            return False
        if self.exact and not _differ(before.holdout, after.holdout):
            taken, gap = _taken(before.fit.residual, after.fit.residual)
            return float(taken.sum()) > _NEARLY_ALL * max(gap, 0.0) and float(taken.max()) > _LEAST_SQUARES
        taken, gap = _taken(before.holdout, after.holdout)
        least = _LEAST_SHARE if self.exact else _COARSE_LEAST_SHARE
        if float(taken.max()) <= _LEAST_SQUARES or float(taken.sum()) <= least * max(gap, 0.0):
            return False
        return float(taken.sum()) > float(np.sum(self._unsteadiness(self.holdout, before.hypothesis) ** 2))

    def heard_on_holdout(self, state: Scored, index: int) -> bool:
        """Whether the hold-out has a trace of one cause of a state, everything else left as it is.

        Rows that select nothing bear witness too, where the cause takes nearly all that is there without it.
        """
        without = self.scored(refit(self.twin, state.hypothesis.minus(index), self.floor, 0))
        if _differ(without.holdout, state.holdout):
            return True
        taken, gap = _taken(without.untouched, state.untouched)
        return float(taken.max()) > _LEAST_SQUARES and float(taken.sum()) > _NEARLY_ALL * max(gap, 0.0)

    def nonsense(self, without: Scored, cause: Cause) -> float:
        """Squares that matched nonsense of one cause takes beside a state, in squared floors over the fitted rows."""
        columns = responses(self.twin, without.fit, self.floor, cause.family, Start((cause.x,), cause.x))
        if columns is None:
            return 0.0
        basis, residual = basis_of(without.fit, self.spread)
        residual = (residual - basis @ (basis.T @ residual))[: len(columns)]
        bands = self.twin.records[0].bands
        block = 0 if cause.family.ripple else max(2, int(_SIGN_S / (bands.stride * bands.period_s)))
        return control_gain(columns, residual, [int(r.keep.sum()) for r in self.twin.records], len(self.twin.channels), block, seed=3)

    def closed(self, state: Scored, null: Scored) -> float:
        """Share of the gap, over all channels, that a state closes on the hold-out."""
        before, after = float(np.sum(np.mean(null.holdout**2, axis=0) - 1.0)), float(np.sum(np.mean(state.holdout**2, axis=0) - 1.0))
        return 1.0 - after / before if before > 0.0 else 0.0

    def forward(self, state: Scored, most: int = MOST_CAUSES, until: float = 1.1, null: Scored | None = None) -> tuple[Scored, list[Round]]:
        """Add the best cause while it is worth it; from the second on, search every slot again given the others."""
        null, rounds = null or state, []
        while len(state.hypothesis.causes) < most and float(np.max(self.gaps(state))) > until:
            self.progress(f"searching for cause {len(state.hypothesis.causes) + 1}")
            tried = self.one_round(state)
            leading = tried.tried[:_IN_QUESTION]
            controls = {s.hypothesis.labels[-1]: self.nonsense(state, s.hypothesis.causes[-1]) for s in leading}
            tried = replace(tried, controls=controls)
            rounds.append(tried)
            found = next((s for s in leading if self.worth(state, s) and tried.beats_nonsense(s)), None)
            if found is None:
                break
            state = found
            if self.exact and len(state.hypothesis.causes) > 1 and not self.complete(state, null):
                state = self.slots_again(state, rounds)
            left = float(np.max(self.gaps(state)))
            if left <= COMPLETE_FLOORS or (left <= CALM_FLOORS and self.complete(state, null)):
                break
        return self.prune(state), rounds

    def slots_again(self, state: Scored, rounds: list[Round]) -> Scored:
        """Replace each cause by a better one given the others, until nothing improves."""
        for index in range(len(state.hypothesis.causes) - 1):
            without = self.refitted(state.hypothesis.minus(index))
            tried = self.one_round(without)
            rounds.append(tried)
            if tried.tried and tried.tried[0].held_out_cost < 0.97 * state.held_out_cost:
                return self.slots_again(tried.tried[0], rounds) if len(rounds) < 7 else tried.tried[0]
        return state

    def prune(self, state: Scored) -> Scored:
        """Drop every cause without which the hold-out does not suffer."""
        for index in reversed(range(len(state.hypothesis.causes))):
            if len(state.hypothesis.causes) == 1:
                break
            without = self.refitted(state.hypothesis.minus(index))
            if not self.worth(without, state):
                state = without
        return state


def selectable(twin: Twin, holdout: Twin, selecting: NDArray[np.bool_]) -> Twin:
    """The fitted logs and the rows of the hold-out that may select, as one."""
    records, scales, first = list(twin.records), list(twin.scales or ()), 0
    for which, record in enumerate(holdout.records):
        keep = record.keep.copy()
        mine = selecting[first : first + int(keep.sum())]
        first += len(mine)
        keep[keep] = mine
        records.append(replace(record, keep=keep))
        if holdout.scales is not None:
            scales.append(holdout.scales[which][mine])
    return replace(twin, records=tuple(records), scales=tuple(scales) if scales else None)


def _starts_refined(family: Family) -> int:
    """From how many of its starts a family is refined: one number has one valley, a gap and its rotor have several."""
    return 2 if family.ripple or 1 < len(family.knobs) <= _VALLEYS else len(family.knobs) // 2 + 1


def _differ(one: Floats, other: Floats) -> bool:
    """Whether residuals differ by more than nothing, in floors."""
    return bool(np.any(rms(one - other) > _NO_CHANGE))


def _taken(before: Floats, after: Floats) -> tuple[Floats, float]:
    """Squares per row that an addition takes, by channel, and how much there was above the floors."""
    squares = np.mean(before**2, axis=0)
    return np.asarray(squares - np.mean(after**2, axis=0)), float(np.sum(squares - 1.0))
