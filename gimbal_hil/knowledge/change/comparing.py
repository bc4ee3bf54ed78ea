"""What differs between two sets of logs of one kind of machine: two units, two days, two settings.

A model of neither machine is right, so the two are not held against the model but against one another. The model is
first fitted to the logs before, its friction and inertia free, and what it lacks there is added. What this model of the
machine before lacks for the logs after is searched with the engine that names causes. Each cause that is told is then
put to the logs before: only one that makes them worse than the share of it that they like best, which may be none, is a
change. One that they like as well was missing all along, and one that they are deaf to is told by neither side.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from enum import Enum, StrEnum

import numpy as np

from firmware_protocol.json_object import Json
from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.discrepancy import (
    LEAST_GAP,
    Cause,
    Hypothesis,
    Kind,
    Request,
    Result,
    Status,
    Verdict,
    corrected_model,
    diagnose,
    explained_by,
    recalibrated_model,
    standing,
    verdict_of,
)
from sim_backend.effects import CATALOGUE, Knob, Move
from sim_backend.model import AntennaModel

Tables = tuple[SignalsTable, ...]
#: what the logs before have to lose by a cause, of what those after gain by it, in squares of floors
_LOSES = 0.05
#: and in floors at least
_LEAST_LOSS = 0.5
#: shares of a cause that the logs before may have had, far from which no parabola leads
_SHARES = (-1.0, 3.0)
#: numbers that any two machines of a kind differ in, beside the inertia: what the model states is no evidence of either
_EVERYDAY = ("friction.coulomb", "friction.breakaway", "friction.viscous")
#: to what share of itself such a number is known before any log, and once it was fitted to those before
_ANY, FITTED = 0.5, 0.02


#: verdicts on a gap that no name of the catalogue explains
_NAMELESS = (Kind.UNEXPLAINED, Kind.DESCRIBED)


class ChangeKind(StrEnum):
    """The answer to what changed."""

    CHANGED = "changed"
    AMBIGUOUS = "ambiguous"
    NO_CHANGE = "no_change"
    CANNOT_JUDGE = "cannot_judge"


class Heard(Enum):
    """What the logs before say of a cause that was found in those after."""

    AGAINST = "the logs before speak against it"
    SHARED = "the logs before have it too"
    DEAF = "the logs before would not show it"


@dataclass(frozen=True)
class AskedCause:
    """A cause told for the logs after, (effect, axis), and mean squares in floors that are left without it and with it,
    in the logs after and before.

    `share_before` is how much of it the logs before like best, 1 all of it, and `best_before` what that leaves there.
    """

    label: tuple[str, str]
    status: Status
    after: tuple[float, float]
    before: tuple[float, float]
    share_before: float
    best_before: float

    @property
    def heard(self) -> Heard:
        """Whether it is a change: the logs before lose by having all of it, be it that they want none or another
        share.
        """
        gained = self.after[0] - self.after[1]
        lost = self.before[1] - self.best_before
        if lost > max(_LOSES * gained, _LEAST_LOSS**2):
            return Heard.AGAINST
        return Heard.SHARED if self.before[1] < self.before[0] else Heard.DEAF


@dataclass(frozen=True)
class Left:
    """What the model of the machine before leaves of one channel, rms in noise floors: of the logs before, of those
    after, and of those after with the causes that were told for them.
    """

    axis: str
    signal: str
    before: float
    after: float
    told: float


@dataclass(frozen=True)
class MachineComparison:
    """The answer: `start` is the model that was given, `model` the one of the machine before; `shared` and `found` are
    the verdicts on the logs before and after.
    """

    start: AntennaModel
    model: AntennaModel
    before: Tables
    after: Tables
    shared: Verdict
    found: Verdict
    result: Result = field(repr=False)
    left: tuple[Left, ...]
    asked: tuple[AskedCause, ...] = ()

    @property
    def changes(self) -> tuple[AskedCause, ...]:
        """Causes that the logs before speak against."""
        return tuple(one for one in self.asked if one.heard is Heard.AGAINST)

    @property
    def kind(self) -> ChangeKind:
        """A change where all that changed has a name, ambiguous where something has none."""
        if self.changes:
            named = all(one.status is Status.NAMED for one in self.changes)
            return ChangeKind.CHANGED if named else ChangeKind.AMBIGUOUS
        if self.found.kind is Kind.NO_DISCREPANCY:
            return ChangeKind.AMBIGUOUS if self.moved else ChangeKind.NO_CHANGE
        if self.found.kind in _NAMELESS and self.shared.kind not in (*_NAMELESS, Kind.CANNOT_JUDGE):
            # what has no name and is not there before
            return ChangeKind.AMBIGUOUS
        return ChangeKind.NO_CHANGE if self.asked and not self._deaf else ChangeKind.CANNOT_JUDGE

    @property
    def moved(self) -> tuple[Json, ...]:
        """Numbers that moved by no more than they are known to, where the logs after are plainly not those of the
        machine before without that, and most of the difference goes with it: entries of a verdict's `recalibrated`.
        """
        if self.asked or not _plain(self.left) or not _closed(self.left):
            return ()
        return tuple(one for one in self.found.recalibrated if not one["low"] <= one["from"] <= one["high"])

    @property
    def _deaf(self) -> bool:
        return any(one.heard is Heard.DEAF for one in self.asked)


def compare(
    model: AntennaModel,
    before: Tables,
    after: Tables,
    *,
    band_hz: float | None = None,
    only: tuple[str, ...] = (),
    without: tuple[str, ...] = (),
    workers: int = 1,
    progress: Callable[[str], None] = lambda text: None,
) -> MachineComparison:
    """Compare two sets of logs at one rate. Deterministic. BadInputError for logs that cannot be used."""
    progress("fitting the model to the logs before, and searching what it lacks for them")
    start = _open_to(model, _ANY)
    first = diagnose(_request(start, before, band_hz, only, without), workers=workers, progress=progress)
    machine = _open_to(corrected_model(first) or recalibrated_model(first), FITTED)
    progress("searching what the machine before lacks for the logs after")
    request = _request(machine, after, band_hz, only, without)
    found = diagnose(request, workers=workers, progress=progress)
    progress("asking the logs before")
    asked = tuple(_asked(found, place, before, after) for place in range(len(found.told)))
    left = _channels(found, before, after)
    if not asked and _plain(left):
        # what the same model leaves of the logs before is noise: a gap is what exceeds that as plainly
        progress("looking closer, as the logs before are quieter than their floors")
        policy = replace(request.policy, least_gap=LEAST_GAP * _noise_of(left))
        closer = diagnose(replace(request, policy=policy), workers=workers, progress=progress)
        told = tuple(_asked(closer, place, before, after) for place in range(len(closer.told)))
        if any(one.heard is Heard.AGAINST for one in told):
            found, asked, left = closer, told, _channels(closer, before, after)
    return MachineComparison(model, machine, before, after, verdict_of(first), verdict_of(found), found, left, asked)


def _plain(left: tuple[Left, ...]) -> bool:
    """Whether the model of the machine before leaves plainly more of the logs after than of those before."""
    quiet = _noise_of(left)
    return any(one.after > LEAST_GAP * max(one.before, quiet) for one in left)


def _closed(left: tuple[Left, ...]) -> bool:
    """Whether what was told for the logs after takes more than half of the squares that they leave beyond those before:
    logs that are only noisier stay so.
    """
    quiet = _noise_of(left)
    more = sum(one.after**2 - max(one.before, quiet) ** 2 for one in left)
    return sum(one.after**2 - one.told**2 for one in left) > 0.5 * more


def _noise_of(left: tuple[Left, ...]) -> float:
    """What the model of the machine before leaves of the logs before where that is most, noise floors, at most one."""
    return min(1.0, max(one.before for one in left))


def _open_to(model: AntennaModel, share: float) -> AntennaModel:
    """The model with its everyday numbers known to no more than a share of themselves."""
    for axis in model.axes:
        paths = (model.own_inertia_path(axis), *_EVERYDAY)
        values = {path: model.number(axis, path) for path in paths}
        values = {path: value for path, value in values.items() if value > 0.0}
        model = model.with_numbers(axis, values, None, {path: share * value for path, value in values.items()})
    return model


def _request(
    model: AntennaModel, tables: Tables, band_hz: float | None, only: tuple[str, ...], without: tuple[str, ...]
) -> Request:
    """The last log judges; a single one is cut at two thirds. That both parts have one trajectory is no doubt here: the
    other machine's logs are what a cause is held against.
    """
    if len(tables) == 1:
        n = len(tables[0])
        tables = (tables[0].rows(0, 2 * n // 3), tables[0].rows(2 * n // 3, n))
    return Request(model, tables[:-1], tables[-1:], band_hz, only, without)


def _asked(found: Result, place: int, before: Tables, after: Tables) -> AskedCause:
    """One told cause: in the logs after beside the others, in those before alone, with the known numbers as they were
    or as the search moved them, whichever these logs like better.
    """
    entries = found.told[place].standing.entries
    whole = found.best.hypothesis

    def model_with(hypothesis: Hypothesis) -> AntennaModel:
        return explained_by(found.model, found.inquiry.twin, hypothesis)

    rest = replace(whole, causes=tuple(cause for k, cause in enumerate(whole.causes) if k not in entries))
    alone = replace(whole, causes=tuple(whole.causes[k] for k in entries))
    unmoved = replace(alone, floating=(), y=())
    with_it, liked = min(((_left(model_with(one), before), one) for one in (alone, unmoved)), key=lambda one: one[0])
    without = _left(found.model, before)
    half = replace(liked, causes=tuple(map(_halved, liked.causes)), y=tuple(0.5 * y for y in liked.y))
    share, best = _liked_best(without, _left(model_with(half), before), with_it)
    return AskedCause(
        found.told[place].standing.label,
        found.told[place].status,
        (_left(model_with(rest), after), _left(model_with(whole), after)),
        (without, with_it),
        share,
        best,
    )


def _halved(cause: Cause) -> Cause:
    """The cause at half its strength, or a number half way to where it was; its order, phase or place stay."""
    effect = CATALOGUE[cause.family.effect]
    strengths = {parameter.name for parameter in effect.strengths}

    def carries(knob: Knob) -> bool:
        return effect.is_number or (knob.move is Move.ADD and strengths.issuperset(knob.parameters))

    pairs = zip(cause.family.knobs, cause.x, strict=True)
    return replace(cause, x=tuple(0.5 * x if carries(knob) else x for knob, x in pairs))


def _liked_best(none: float, half: float, all_of_it: float) -> tuple[float, float]:
    """Share of a cause that leaves least, and what it leaves, from what none, half and all of it leave: squares of what
    is linear in the share are a parabola.
    """
    bend = 2.0 * (none - 2.0 * half + all_of_it)
    slope = all_of_it - none - bend
    if not bend > 0.0:
        return min(((0.0, none), (0.5, half), (1.0, all_of_it)), key=lambda one: one[1])
    share = min(max(-0.5 * slope / bend, _SHARES[0]), _SHARES[1])
    return share, max(0.0, none + slope * share + bend * share**2)


def _channels(found: Result, before: Tables, after: Tables) -> tuple[Left, ...]:
    """Channel by channel."""
    told = corrected_model(found) or recalibrated_model(found)
    sides = [_squares(model, tables) for model, tables in ((found.model, before), (found.model, after), (told, after))]
    return tuple(Left(*channel, *(float(np.sqrt(side[channel])) for side in sides)) for channel in sides[0])


def _left(model: AntennaModel, tables: Tables) -> float:
    """Mean squares that a model leaves of logs, in floors, over all channels."""
    return float(np.mean(list(_squares(model, tables).values())))


def _squares(model: AntennaModel, tables: Tables) -> dict[tuple[str, str], float]:
    """Mean squares in floors by channel, over all logs."""
    found: dict[tuple[str, str], list[float]] = {}
    for table in tables:
        for gap in standing(model, table):
            found.setdefault((gap["axis"], gap["signal"]), []).append((gap["before"] / gap["noise_floor"]) ** 2)
    return {channel: float(np.mean(squares)) for channel, squares in found.items()}
