"""The certificate as people read it: requirement, verdict, shares with intervals, worst flights, what was assumed."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from gimbal_hil.pages.report import Block, Callout, Heading, Plot, Table, Text, Tiles
from gimbal_hil.pointing.certifying.certificate import CONFIDENCE, Certificate, ShareInterval, of_time
from gimbal_hil.pointing.certifying.flight import ERROR_STEP_RAD, FlownFlight

if TYPE_CHECKING:
    from gimbal_hil.pages.plots import Drawing

_SHARES = (0.5, 0.95, 0.99, 0.999)
_LISTED = 12
#: of the drawn shares, per cent
_TICKS = [100.0, 10.0, 1.0, 0.1, 0.01, 0.001, 0.0001]
#: last words of a key of the navigation that are its unit
_UNITS = {"deg_s": "deg/s", "deg": "deg", "s": "s"}
#: what is told apart: words, and who belongs to it
_GROUPS: tuple[tuple[str, Callable[[FlownFlight], bool]], ...] = (
    ("gusts below 2 m/s", lambda one: one.gust_m_s < 2.0),
    ("gusts 2 to 4 m/s", lambda one: 2.0 <= one.gust_m_s < 4.0),
    ("gusts above 4 m/s", lambda one: one.gust_m_s >= 4.0),
    ("turning", lambda one: one.bank_rad != 0.0),
    ("elevation below 30 degrees", lambda one: one.elevation_rad < math.radians(30.0)),
    ("elevation 30 to 60 degrees", lambda one: math.radians(30.0) <= one.elevation_rad < math.radians(60.0)),
    ("elevation above 60 degrees", lambda one: one.elevation_rad >= math.radians(60.0)),
    ("without silence of navigation", lambda one: one.silences == 0),
    ("with silence of navigation", lambda one: one.silences > 0),
)


def certificate_document(found: Certificate, where: str) -> dict[str, object]:
    """For machines; angles in degrees, times in s."""
    need, times = found.task.requirement, [one.computed_s for one in found.flights]

    def share(interval: ShareInterval) -> dict[str, float]:
        return {"value": interval.value, "low": interval.low, "high": interval.high}

    return {
        "schema": 1,
        "antenna": where,
        "requirement": {
            "source": "47 CFR 25.228",
            "pointing_error_deg": math.degrees(need.within_rad),
            "cease_emission_beyond_deg": math.degrees(need.mute_beyond_rad),
            "cease_emission_within_s": need.mute_within_s,
        },
        "keeps": found.keeps,
        "confidence": CONFIDENCE,
        "flights": len(found.flights),
        "flight_s": found.task.duration_s,
        "first_seed": found.flights[0].seed,
        "acquired": share(found.acquired),
        "pointing_error_within_requirement": share(found.within),
        "emission_available": share(found.transmitting),
        "cease_emission_in_time": share(found.muted_in_time),
        "excursions": sum(one.excursions for one in found.flights),
        "slowest_cease_emission_s": max(one.slowest_mute_s for one in found.flights),
        "pointing_error_deg": {
            f"{100.0 * share_:g} %": _plain(math.degrees(found.quantile_rad(share_))) for share_ in _SHARES
        }
        | {"largest": math.degrees(max(one.worst_rad for one in found.flights))},
        "navigation_errors": found.task.navigation.model_dump(mode="json", by_alias=True),
        "computing": {"workers": found.workers, "took_s": found.took_s, "flight_s": float(np.median(times))},
        "each": found.rows(),
    }


def _plain(value: float) -> float | None:
    return value if math.isfinite(value) else None


def summary(found: Certificate) -> str:
    """Whether it keeps the requirement, and its figures, in two sentences."""
    need, flights, late = found.task.requirement, len(found.flights), found.late
    beyond = f"beyond {math.degrees(need.mute_beyond_rad):g} degrees"
    in_time = f"muted within {1e3 * need.mute_within_s:g} ms"
    excursions = sum(one.excursions for one in found.flights)
    count = "the one excursion" if excursions == 1 else f"all {excursions} excursions"
    muted = f"{count} {beyond} in {flights} flights {'was' if excursions == 1 else 'were'} {in_time}"
    if not excursions:
        muted = f"no excursion {beyond} in {flights} flights"
    if late:
        muted = f"in {len(late)} of {flights} flights an excursion {beyond} was not {in_time}"
        muted += f", the slowest {late[0].slowest_mute_s:.2f} s (seed {late[0].seed})"
    missed = flights - round(flights * found.acquired.value)
    if missed:
        muted += f"; {missed} of {flights} flights never acquired"
    if found.keeps and not found.is_shown:
        low = math.floor(100.0 * found.muted_in_time.low)
        muted += f"; so few flights only show that at least {low} % of flights keep it"
    verdict = "Kept" if found.is_shown else "Kept so far" if found.keeps else "Not kept"
    return (
        f"{verdict}: {muted}. Within {math.degrees(need.within_rad):g} degrees in {_share(found.within)} of the time "
        f"of transmission; it transmitted in {_share(found.transmitting)} of the time since the acquisition."
    )


def _share(interval: ShareInterval) -> str:
    value, between = _cells(interval)
    return f"{value} ({between})" if interval.high > interval.low else value


def certificate_blocks(found: Certificate) -> list[Block]:
    """The page."""
    need, flights = found.task.requirement, found.flights
    limits = f"{math.degrees(need.within_rad):g}°"
    largest = math.degrees(max(one.worst_rad for one in flights))
    return [
        Callout(summary(found), "good" if found.is_shown else "warning" if found.keeps else "bad"),
        Tiles(
            [
                (_cells(found.within)[0], f"of transmission within {limits}"),
                (_cells(found.transmitting)[0], "of the time since the acquisition transmitting"),
                (f"{1e3 * max(one.slowest_mute_s for one in flights):.0f} ms", "longest unmuted beyond the limit"),
                (f"{largest:.3f}°", "largest error while transmitting"),
                (str(len(flights)), f"flights of {found.task.duration_s:g} s"),
            ]
        ),
        Heading("Against the requirement"),
        Table(
            ("Requirement (47 CFR 25.228)", "Result", f"{100.0 * CONFIDENCE:g} % interval"),
            [
                (f"pointing error within {limits} while transmitting", *_cells(found.within)),
                (
                    f"silent within {1e3 * need.mute_within_s:g} ms of {math.degrees(need.mute_beyond_rad):g}°, "
                    "share of the flights",
                    *_cells(found.muted_in_time),
                ),
                ("acquired, share of the flights", *_cells(found.acquired)),
                ("transmitting, share of the time since the acquisition", *_cells(found.transmitting)),
            ],
            "Intervals of shares of time: whole flights are resampled, which needs flights that differ. Of shares of "
            "flights: Clopper and Pearson. The error is the true one: true joints on the true base against the "
            "target, not what the host sees.",
        ),
        Heading("Pointing error while transmitting"),
        Plot(_distribution(found), "Share of the time of transmission in which the error was larger than that."),
        Table(
            ("Share of the time", "Error not exceeded [deg]"),
            [(f"{100.0 * share:g} %", f"{math.degrees(found.quantile_rad(share)):.3f}") for share in _SHARES],
        ),
        Heading("Where it is worse"),
        Table(
            ("Flights", "Number", f"Within {limits}", f"{100.0 * CONFIDENCE:g} % interval", "Largest error [deg]"),
            [_group(words, [one for one in flights if belongs(one)]) for words, belongs in _GROUPS],
        ),
        Heading("Worst flights"),
        Table(
            ("Seed", "Gusts [m/s]", "Bank [deg]", "Elevation [deg]", "Largest [deg]", "Unmuted beyond [ms]", "Stops"),
            [
                (
                    str(one.seed),
                    f"{one.gust_m_s:.1f}",
                    f"{math.degrees(one.bank_rad):.0f}",
                    f"{math.degrees(one.elevation_rad):.0f}",
                    f"{math.degrees(one.worst_rad):.3f}",
                    f"{1e3 * one.slowest_mute_s:.0f}",
                    ", ".join(stop.replace("_", " ") for stop in one.stops) or "-",
                )
                for one in sorted(flights, key=lambda one: (-one.slowest_mute_s, -one.worst_rad))[:_LISTED]
            ],
        ),
        Heading("What was drawn"),
        Text(
            "Gusts uniform from 0 to 6.1 m/s rms (Dryden, MIL-F-8785C) on any heading; a turn of up to 30 degrees of "
            "bank with a pull-up in three flights of ten; directions uniform over the sky between 10 and 75 degrees of "
            "elevation. Errors of navigation, one standard deviation each, constant in a flight or as their names say:"
        ),
        Table(
            ("Navigation", "Value"),
            [
                (_words(key), " to ".join(f"{one:g}" for one in np.atleast_1d(value)))
                for key, value in found.task.navigation.model_dump(mode="json", exclude={"schema_"}).items()
            ],
            "Not in it: alignment of the antenna's beam, flexing of the airframe, refraction, errors of the orbit.",
        ),
        Text(
            f"Computing took {sum(one.computed_s for one in flights):.3g} s of a processor, "
            f"{np.median([one.computed_s for one in flights]):.2g} s a flight."
        ),
    ]


def _words(key: str) -> str:
    """A key of the navigation with its unit in brackets."""
    unit = next((one for one in _UNITS if key.endswith(f"_{one}")), None)
    return (
        key.replace("_", " ") if unit is None else f"{key.removesuffix(f'_{unit}').replace('_', ' ')} [{_UNITS[unit]}]"
    )


def _cells(interval: ShareInterval) -> tuple[str, str]:
    """A share and its interval, with two digits of the interval's width."""
    width = 100.0 * (interval.high - interval.low)
    if not width > 0.0:
        return _percent(interval.value, 3), "-"
    digits = min(max(1 - math.floor(math.log10(width)), 0), 3)
    low, high = (_percent(one, digits) for one in (interval.low, interval.high))
    return _percent(interval.value, digits), f"{low.removesuffix(' %')} to {high}"


def _percent(value: float, digits: int) -> str:
    return "100 %" if value == 1.0 else f"{100.0 * value:.{digits}f} %"


def _group(words: str, flights: Sequence[FlownFlight]) -> tuple[str, ...]:
    if not sum(one.transmitting_s for one in flights):
        return words, str(len(flights)), "-", "-", "-"
    # whole flights are resampled: of one there is nothing to choose from
    within = of_time([one.within_s for one in flights], [one.transmitting_s for one in flights])
    return (
        words,
        str(len(flights)),
        *_cells(within),
        f"{math.degrees(max(one.worst_rad for one in flights)):.3f}",
    )


def _distribution(found: Certificate) -> Drawing:
    from gimbal_hil.pages.plots import ALERT, MEASURED, figure

    time_s = np.sum([one.histogram for one in found.flights], axis=0)
    whole = max(float(time_s.sum()), 1e-12)
    beyond = 1.0 - np.cumsum(time_s) / whole
    steps = np.degrees(ERROR_STEP_RAD) * np.arange(1, len(time_s) + 1)
    shown = beyond > 0.5e-3 / whole
    drawn = figure("", "error [deg]", "share of the time [%]")
    lowest = math.floor(math.log10(100.0 * float(beyond[shown].min()))) if shown.any() else -4
    drawn.add_scatter(x=steps[shown], y=100.0 * beyond[shown], name="true error", line=dict(color=MEASURED))
    need = found.task.requirement
    limits = ((need.within_rad, "requirement", "dash"), (need.mute_beyond_rad, "muted beyond", "dot"))
    for limit, words, dash in limits:
        drawn.add_scatter(
            x=[math.degrees(limit)] * 2,
            y=[10.0**lowest, 100.0],
            name=words,
            mode="lines",
            line=dict(color=ALERT, dash=dash),
        )
    drawn.update_yaxes(type="log", range=[lowest, 2], tickvals=_TICKS, ticktext=[f"{one:g}" for one in _TICKS])
    drawn.update_xaxes(range=[0.0, 1.1 * math.degrees(need.mute_beyond_rad)])
    return drawn
