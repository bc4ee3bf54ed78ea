"""A measured curve: its shape, and as many knots and values as the data support; and its entry in a model file."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from firmware_protocol.json_object import Json
from gimbal_hil.knowledge.discrepancy.inquiry import INTERVAL, Inquiry
from gimbal_hil.knowledge.discrepancy.laws.knots import (
    Factor,
    Knots,
    RangeSeen,
    basis,
    bends_of,
    columns_of,
    knots_of,
    knots_where_it_bends,
)
from gimbal_hil.knowledge.discrepancy.laws.linear import Straight, softest
from gimbal_hil.knowledge.discrepancy.laws.shape import WITH_MEMORY, LawShape
from gimbal_hil.knowledge.discrepancy.twin import TORQUE, Floats
from sim_backend.model import MOST_ACROSS, UNIT_OF, LawKind

#: how many knots are tried, and of either of two variables
COUNTS, ACROSS = (3, 4, 5, 7, 9, 12, 16, 22, 30, 42, 60, 85), ((4, 4), (7, 5), (12, 7))
#: and of the second where the first is known
BESIDE = (4, 7, 12, 22)
#: knots by which shapes are compared first: with fewer the search for their number does not end
FEW = 12
#: those that draw nearly whatever there is
_MANY = 42
#: and those of a straight line
STRAIGHT = (2,)
#: more knots must leave less by this share, or by so many squared floors
_LESS, _FLOORS = 0.05, 0.1
#: how often knots are put where it bends; factors by which a memory is first and last moved, fewest knots meanwhile
_SHARPER, _FIRST_STEP, _LAST_STEP, _FEWEST = 2, 1.6, 1.02, 7
#: rows that a value at a knot must have
_ROWS_PER_VALUE = 8
#: draws of the blocks for a band
_DRAWS = 60
#: places at which a line is drawn
_DRAWN_AT = 240
#: digits of a number in a model file
DIGITS = 6
SOURCE = "described by gimbal-hil discrepancy"


class CurveLine(NamedTuple):
    """A line of a figure with its band."""

    name: str
    x: Floats
    y: Floats
    low: Floats
    high: Floats


@dataclass(frozen=True)
class Curve:
    """A law with numbers."""

    shape: LawShape
    knots: Knots
    values: Floats
    low: Floats
    high: Floats

    @property
    def rows(self) -> tuple[Floats, ...]:
        """Values of one curve, of those forward and backward, or of a surface, (knots of the first, of the second)."""
        return _arranged(self, self.values)

    def lines(self) -> tuple[CurveLine, ...]:
        """As it is drawn over its first variable: one line, one for each direction, or three of a surface."""
        parts = (_arranged(self, self.values), _arranged(self, self.low), _arranged(self, self.high))
        if len(self.shape.over) == 2:
            across, second = self.knots[1], self.shape.over[1].value.replace("_", " ")
            cuts = sorted({0, len(across) // 2, len(across) - 1})
            return tuple(
                CurveLine(f"{second} {across[k]:.3g}", np.array(self.knots[0]), *(part[0][:, k] for part in parts))
                for k in cuts
            )
        names = ("forward", "backward") if self.shape.by_direction else ("the law and its 90 % band",)
        x = np.linspace(self.knots[0][0], self.knots[0][-1], _DRAWN_AT)
        through = basis(x, self.knots[0])
        return tuple(CurveLine(name, x, *(through @ part[k] for part in parts)) for k, name in enumerate(names))

    def plus(self, more: Floats) -> Curve:
        """With so much more at each knot."""
        return replace(self, values=self.values + more, low=self.low + more, high=self.high + more)

    def entry(self, is_linear: bool) -> Json:
        """As it stands in `effects:` of a model file."""
        shape = self.shape
        over = [one.value for one in shape.over]
        found: dict[str, object] = {
            "kind": LawKind.CURVE.value,
            "axis": shape.axis,
            "acts_on": shape.acts_on.value,
            "over": over if len(over) == 2 else over[0],
            "unit": UNIT_OF[shape.acts_on][is_linear],
            "knots": [_rounded(part) for part in self.knots] if len(over) == 2 else _rounded(self.knots[0]),
        }
        if shape.by_direction:
            found |= {"forward": _rounded(self.rows[0]), "backward": _rounded(self.rows[1])}
            found["direction_travel"] = shape.direction_travel
        else:
            found["values"] = _listed(self, self.values)
        found |= {"low": _listed(self, self.low), "high": _listed(self, self.high)}
        found |= {
            key: value
            for key, value in (("slack", shape.slack), ("softness", shape.softness), ("memory_s", shape.memory_s))
            if value
        }
        return found | {"source": SOURCE}


def _arranged(curve: Curve, values: Floats) -> tuple[Floats, ...]:
    if len(curve.shape.over) == 2:
        return (values.reshape(len(curve.knots[0]), len(curve.knots[1])),)
    return tuple(np.split(values, 2)) if curve.shape.by_direction else (values,)


def _listed(curve: Curve, values: Floats) -> list[float] | list[list[float]]:
    if len(curve.shape.over) == 2:
        return [_rounded(row) for row in _arranged(curve, values)[0]]
    return _rounded(values)


def _rounded(values: Iterable[float]) -> list[float]:
    return [float(f"{value:.{DIGITS}g}") for value in values]


@dataclass(frozen=True)
class Tried:
    """A shape with as many knots as pay on stretches that did not give its values."""

    seen: RangeSeen
    knots: Knots
    columns: Floats
    #: squares a row that it leaves of its channel there, in squared floors
    leaves: float
    #: by how much it bends, of those values, and what that costs
    bends: Floats
    #: of a product of two curves the one that is given
    factor: Factor | None = None

    @classmethod
    def at(
        cls, inquiry: Inquiry, straight: Straight, seen: RangeSeen, knots: Knots, factor: Factor | None = None
    ) -> Tried:
        """With these knots, as stiff as foretells best."""
        columns = columns_on(inquiry, seen, knots, factor)
        bends, channel = bends_of(seen.shape, knots, factor), channel_of(inquiry, seen.shape.axis)
        return cls(seen, knots, columns, *straight.foretold(columns, channel, bends), factor)

    def spread(self, solved: Floats) -> Floats:
        """Values at all knots, of those of its columns."""
        return solved if self.factor is None else self.factor.spread(solved)


def channel_of(inquiry: Inquiry, axis: str) -> int:
    """The channel of an axis' torque."""
    channels = inquiry.twin.channels
    return next(j for j, channel in enumerate(channels) if (channel.axis, channel.signal) == (axis, TORQUE))


def tried(inquiry: Inquiry, straight: Straight, seen: RangeSeen, counts: tuple[int, ...]) -> Tried | None:
    """The fewest knots of a shape that leave hardly more than any other number of them."""
    shape = seen.shape
    ends = [seen.range_of(which, len(inquiry.twin.records)) for which in range(len(shape.over))]
    if any(high - low <= 1e-9 * max(abs(low), abs(high), 1e-300) for low, high in ends):
        return None
    found: list[Tried] = []
    for count in ACROSS if len(shape.over) == 2 else [(count,) for count in counts]:
        knots = tuple(
            knots_of(over, low, high, each) for over, (low, high), each in zip(shape.over, ends, count, strict=True)
        )
        values = (2 if shape.by_direction else 1) * int(np.prod(count))
        if _ROWS_PER_VALUE * values > int(np.sum(~straight.judging)):
            break
        found.append(Tried.at(inquiry, straight, seen, knots))
        # a narrow bump shows only with knots enough to draw it
        least, drawn = min(one.leaves for one in found), len(knots) == 1 and len(knots[0]) > FEW
        if drawn and all(one.leaves > _enough(least) for one in found[-3:]):
            break
    if not found:
        return None
    least = min(one.leaves for one in found)
    return next(one for one in found if one.leaves <= _enough(least))


def leaves_of_its_own(inquiry: Inquiry, straight: Straight, seen: RangeSeen) -> float:
    """Squares a row that a curve of many knots leaves of the very rows that gave it: more than the variable says."""
    channel, most = channel_of(inquiry, seen.shape.axis), len(inquiry.twin.records)
    knots = (knots_of(seen.shape.over[0], *seen.range_of(0, most), _MANY),)
    columns = columns_on(inquiry, seen, knots)
    found = straight.solved(straight.normals(columns, channel, softest(bends_of(seen.shape, knots))))
    return float(np.mean(straight.after(columns, channel, found)[~straight.judging] ** 2))


def sharpened(inquiry: Inquiry, straight: Straight, one: Tried) -> Tried:
    """The same with the memory that fits best, and with knots where the curve bends."""
    one = _remembered(inquiry, straight, one)
    if len(one.seen.shape.over) == 2:
        return one
    if one.seen.shape.has_memory:
        # memory and curve make up for each other: where a straight line will do, the memory is the law
        line = tried(inquiry, straight, one.seen, STRAIGHT)
        line = None if line is None else _remembered(inquiry, straight, line)
        if line is not None and line.leaves <= _enough(one.leaves):
            return line
    for _ in range(_SHARPER):
        curve = curve_from(inquiry, straight, one)
        found = [one]
        for count in (count for count in COUNTS if count <= 2 * len(one.knots[0])):
            knots = (knots_where_it_bends(curve.knots[0], list(curve.rows), count),)
            found.append(Tried.at(inquiry, straight, one.seen, knots))
        least = min(other.leaves for other in found)
        enough = [other for other in found if other.leaves <= _enough(least)]
        best = min(enough, key=lambda other: len(other.knots[0]))
        if best is one:
            break
        one = best
    return one


def _remembered(inquiry: Inquiry, straight: Straight, one: Tried) -> Tried:
    """Slack and softness, or time, that foretell best, by steps that become smaller."""
    step = _FIRST_STEP
    # what a log does not hear the end of is no other memory
    longest_s = max(record.seconds for record in inquiry.twin.records)
    while one.seen.shape.has_memory and step > _LAST_STEP:
        others = []
        for shape in _around(one.seen.shape, step, longest_s):
            found = _the_same(inquiry, straight, one, seen_of(inquiry, shape))
            others += [] if found is None else [found]
        best = min((one, *others), key=lambda each: each.leaves)
        step = step if best is not one else float(np.sqrt(step))
        one = best
    return one


def _the_same(inquiry: Inquiry, straight: Straight, one: Tried, seen: RangeSeen) -> Tried | None:
    """A curve, surface or product once more, over another memory."""
    if one.factor is None:
        count = len(one.knots[0])
        return tried(inquiry, straight, seen, STRAIGHT if (count,) == STRAIGHT else (max(_FEWEST, count),))
    mine = next(k for k, over in enumerate(seen.shape.over) if over not in WITH_MEMORY)
    given = one.factor if one.factor.which == mine else _turned(inquiry, straight, one)
    return _times_another(inquiry, straight, seen, one.knots[mine], given, len(one.knots[1 - mine]))


def _around(shape: LawShape, step: float, longest_s: float) -> Iterator[LawShape]:
    """Shapes with a memory that is so many times as long or short, no longer than a log lasts, or softer or harder by
    as much.
    """
    for factor in (step, 1.0 / step):
        yield replace(
            shape,
            slack=None if shape.slack is None else shape.slack * factor,
            memory_s=None if shape.memory_s is None else min(shape.memory_s * factor, longest_s),
        )
    if shape.slack is not None:
        change = step - 1.0
        for softness in (min(shape.softness + change, 1.0), max(shape.softness - change, 0.0)):
            if softness != shape.softness:
                yield replace(shape, softness=softness)


def multiplied(inquiry: Inquiry, straight: Straight, one: Tried, shape: LawShape) -> Tried | None:
    """A curve times another over the second variable of a shape: each in turn is what the other leaves to it."""
    curve, seen = curve_from(inquiry, straight, one), seen_of(inquiry, shape)
    mine = shape.over.index(one.seen.shape.over[0])
    fine = knots_where_it_bends(curve.knots[0], list(curve.rows), min(2 * len(curve.knots[0]), MOST_ACROSS))
    # of both directions what they have in common: the rate says the rest
    common = np.linalg.svd(np.array(curve.rows), full_matrices=False)[2][0]
    given = Factor(mine, basis(np.array(fine), curve.knots[0]) @ common)
    low, high = seen.range_of(1 - mine, len(inquiry.twin.records))
    if high - low <= 1e-9 * max(abs(low), abs(high)):
        return None
    found = [_times_another(inquiry, straight, seen, fine, given, count) for count in BESIDE]
    least = min(two.leaves for two in found)
    return next(two for two in found if two.leaves <= _enough(least))


def _times_another(
    inquiry: Inquiry, straight: Straight, seen: RangeSeen, fine: tuple[float, ...], given: Factor, count: int
) -> Tried:
    """The curve that is given, at knots `fine`, times one of so many knots over the other variable."""
    mine = given.which
    other = knots_of(seen.shape.over[1 - mine], *seen.range_of(1 - mine, len(inquiry.twin.records)), count)
    knots = (fine, other) if mine == 0 else (other, fine)
    two = Tried.at(inquiry, straight, seen, knots, given)
    for _ in range(2):
        turned = Tried.at(inquiry, straight, seen, knots, _turned(inquiry, straight, two))
        if turned.leaves >= two.leaves:
            break
        two = turned
    return two


def _turned(inquiry: Inquiry, straight: Straight, two: Tried) -> Factor:
    """Of a product the curve that was not given, as the one that is."""
    assert two.factor is not None
    normals = straight.normals(two.columns, channel_of(inquiry, two.seen.shape.axis), two.bends)
    return Factor(1 - two.factor.which, straight.solved(normals).values)


def _enough(least: float) -> float:
    return (1.0 + _LESS) * least + _FLOORS


def columns_on(inquiry: Inquiry, seen: RangeSeen, knots: Knots, factor: Factor | None = None) -> Floats:
    """What one at each knot does: rows of the fitted logs, then of the hold-out."""
    channel = channel_of(inquiry, seen.shape.axis)
    floor, count = float(inquiry.floor[channel]), len(inquiry.twin.records)
    parts = []
    for twin, first, last in ((inquiry.twin, 0, count), (inquiry.holdout, count, None)):
        part = replace(seen, columns=seen.columns[first:last], directions=seen.directions[first:last])
        parts.append(columns_of(twin, twin.records, part, knots, floor, factor))
    return np.concatenate(parts)


def seen_of(inquiry: Inquiry, shape: LawShape) -> RangeSeen:
    """A shape's variables along the fitted logs and the hold-out."""
    axis = inquiry.twin.model.axes.index(shape.axis)
    return RangeSeen.of(shape, (*inquiry.twin.records, *inquiry.holdout.records), axis)


def curve_from(inquiry: Inquiry, straight: Straight, one: Tried) -> Curve:
    """With values from all rows that may select, and the band in which other stretches would have put them."""
    channel = channel_of(inquiry, one.seen.shape.axis)
    normals = straight.normals(one.columns, channel, one.bends)
    values = one.spread(straight.solved(normals).values)
    drawn = np.array([one.spread(straight.solved(normals, times).values) for times in _drawn(len(normals))])
    low, high = np.quantile(drawn, INTERVAL, axis=0)
    return Curve(one.seen.shape, one.knots, values, np.minimum(low, values), np.maximum(high, values))


def _drawn(folds: int) -> Floats:
    """How often each fold is drawn, draw by draw."""
    which = np.random.default_rng(5).integers(0, folds, (_DRAWS, folds))
    return np.array([np.bincount(row, minlength=folds) for row in which], dtype=float)


def control_of(straight: Straight, one: Tried, channel: int, shifts: tuple[float, ...]) -> float:
    """Squares a row of the untouched half that the best of its negative controls takes: the same curve over what the
    variable was at other times, without the part that the curve itself could draw. Known numbers stay: beside nonsense
    that takes the rest of what they do they could draw the law themselves.
    """
    taken, judging = [], straight.judging
    alone = replace(straight, numbers=np.zeros_like(straight.numbers))
    own = one.columns[~judging]
    for shift in shifts:
        rolled = np.roll(one.columns, int(shift * len(one.columns)), axis=0)
        alike = np.linalg.lstsq(own, rolled[~judging], rcond=1e-6)[0]
        columns = rolled - one.columns @ alike
        left = alone.after(columns, channel, alone.solved(alone.normals(columns, channel, one.bends)))
        taken.append(float(np.mean(straight.left[judging, channel] ** 2 - left[judging] ** 2)))
    return max(taken)


__all__ = [
    "COUNTS",
    "FEW",
    "Curve",
    "Tried",
    "channel_of",
    "columns_on",
    "control_of",
    "curve_from",
    "leaves_of_its_own",
    "multiplied",
    "seen_of",
    "sharpened",
    "tried",
]
