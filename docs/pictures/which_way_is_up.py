"""Draws `which-way-is-up.svg`: what azimuth, elevation and the signs of the joints are, for both boresights.

    python docs/pictures/which_way_is_up.py

Angles and labels are those that `gimbal-hil point` computes for its target.
"""

from __future__ import annotations

import math
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from gimbal_hil.pointing.following import joints_seen, target_of
from sim_backend.boresight import Boresight

AZIMUTH, ELEVATION = 60.0, 30.0
WIDE, HIGH, REACH = 900, 640, 140.0
INK, SOFT, BLUE, RED, GREEN = "#222222", "#888888", "#1f6feb", "#d1443c", "#2e8b57"
Point = tuple[float, float]


def line(a: Point, b: Point, colour: str, wide: float = 2.0, head: bool = False, dash: str = "") -> str:
    """A straight line, with an arrow at its end or without."""
    extra = (f' marker-end="url(#{colour[1:]})"' if head else "") + (f' stroke-dasharray="{dash}"' if dash else "")
    return (
        f'<line x1="{a[0]:.1f}" y1="{a[1]:.1f}" x2="{b[0]:.1f}" y2="{b[1]:.1f}" stroke="{colour}" '
        f'stroke-width="{wide}"{extra}/>'
    )


def text(at: Point, words: str, colour: str = INK, size: int = 15, anchor: str = "middle") -> str:
    """Words at a place."""
    style = f'fill="{colour}" font-size="{size}" text-anchor="{anchor}"'
    return f'<text x="{at[0]:.1f}" y="{at[1]:.1f}" {style}>{words}</text>'


def polar(centre: Point, degrees: float, length: float) -> Point:
    """A point on a circle, degrees counted from the right towards the top."""
    angle = math.radians(degrees)
    return centre[0] + length * math.cos(angle), centre[1] - length * math.sin(angle)


def arc(centre: Point, radius: float, start: float, end: float, colour: str) -> str:
    """An arc with an arrow at its end, degrees as in `polar`."""
    (x0, y0), (x1, y1) = polar(centre, start, radius), polar(centre, end, radius)
    large, sweep = int(abs(end - start) > 180.0), int(end < start)
    return (
        f'<path d="M {x0:.1f} {y0:.1f} A {radius} {radius} 0 {large} {sweep} {x1:.1f} {y1:.1f}" fill="none" '
        f'stroke="{colour}" stroke-width="2" marker-end="url(#{colour[1:]})"/>'
    )


def from_above(centre: Point, looks: Boresight, outer: float) -> list[str]:
    """North up: the azimuth clockwise, the outer joint the other way from where boresight and base begin."""
    sky = 90.0 - AZIMUTH
    # x of the base looks north; the joint turns counter-clockwise from there, and -x is half a turn further
    found = [
        line(centre, polar(centre, 90.0, REACH), SOFT, head=True),
        text(polar(centre, 90.0, REACH + 16), "north = x of the base", SOFT),
        line(centre, polar(centre, 180.0, 0.8 * REACH), SOFT, head=True),
        text(polar(centre, 180.0, 0.8 * REACH + 20), "y", SOFT),
        line(centre, polar(centre, sky, REACH), BLUE, 3.0, head=True),
        text(
            (polar(centre, sky, REACH)[0] + 8, polar(centre, sky, REACH)[1] - 8), "to the target", BLUE, anchor="start"
        ),
        arc(centre, 0.62 * REACH, 90.0, sky + 3.0, GREEN),
        text(polar(centre, 62.0, 0.62 * REACH + 20), f"azimuth {AZIMUTH:.0f}°", GREEN, anchor="start"),
    ]
    x_of_body = 90.0 + outer
    if looks is Boresight.ASTERN:
        found += [
            line(centre, polar(centre, x_of_body, 0.8 * REACH), RED, head=True, dash="6 4"),
            text(polar(centre, x_of_body, 0.8 * REACH + 26), "x of the bodies", RED),
        ]
    turn = 3.0 if outer < 0.0 else -3.0
    found += [
        arc(centre, 0.4 * REACH, 90.0, x_of_body + turn, RED),
        text((centre[0] + 12, centre[1] + 26), f"outer {outer:+.0f}°", RED, anchor="start"),
        f'<circle cx="{centre[0]}" cy="{centre[1]}" r="5" fill="{INK}"/>',
    ]
    return found


def from_the_side(centre: Point, looks: Boresight, inner: float) -> list[str]:
    """The vertical plane through the target, seen so that the target is on the right."""
    x_of_body = ELEVATION + (180.0 if looks is Boresight.ASTERN else 0.0)
    level = 180.0 if looks is Boresight.ASTERN else 0.0
    rest = 3.0 if x_of_body < level else -3.0
    found = [
        line((centre[0] - REACH, centre[1]), (centre[0] + REACH, centre[1]), SOFT, 1.0, dash="3 4"),
        text((centre[0] + REACH + 6, centre[1] + 5), "horizon", SOFT, anchor="start"),
        line(centre, polar(centre, 90.0, 0.85 * REACH), SOFT, head=True),
        text(polar(centre, 90.0, 0.85 * REACH + 14), "z, up", SOFT),
        line(centre, polar(centre, ELEVATION, REACH), BLUE, 3.0, head=True),
        text((polar(centre, ELEVATION, REACH)[0] - 10, polar(centre, ELEVATION, REACH)[1] - 12), "to the target", BLUE),
        arc(centre, 0.6 * REACH, 0.0, ELEVATION - 2.0, GREEN),
        text((centre[0] + 0.6 * REACH + 8, centre[1] - 12), f"elevation {ELEVATION:.0f}°", GREEN, anchor="start"),
        arc(centre, 0.42 * REACH, level, x_of_body + rest, RED),
    ]
    if looks is Boresight.ASTERN:
        found += [
            line(centre, polar(centre, x_of_body, 0.8 * REACH), RED, head=True, dash="6 4"),
            text(polar(centre, x_of_body, 0.8 * REACH + 30), "x of the inner body", RED),
            text((centre[0] - 0.42 * REACH - 6, centre[1] - 10), f"inner {inner:+.0f}°", RED),
        ]
    else:
        found.append(text((centre[0] + 6, centre[1] + 24), f"inner {inner:+.0f}°", RED, anchor="start"))
    found.append(f'<circle cx="{centre[0]}" cy="{centre[1]}" r="5" fill="{INK}"/>')
    return found


def drawing() -> str:
    """The whole picture as SVG."""
    target = target_of(f"azel:{AZIMUTH:g},{ELEVATION:g}", None, datetime(2026, 1, 1, tzinfo=UTC))
    parts = [f'<rect width="{WIDE}" height="{HIGH}" fill="white"/>']
    for column, looks in enumerate(Boresight):
        outer, inner = np.degrees(joints_seen(target, np.zeros(1), looks)[0])
        middle = WIDE / 4 + column * WIDE / 2
        parts += [
            text((middle, 36), f"boresight: {looks}", INK, 20),
            text((middle, 60), f"{looks.raises} inner positions look up", INK),
            *from_above((middle, 250.0), looks, float(outer)),
            text((middle - 150, 110), "from above", SOFT),
            *from_the_side((middle, 540.0), looks, float(inner)),
            text((middle - 150, 420), "from the side", SOFT),
        ]
    parts.append(line((WIDE / 2, 20), (WIDE / 2, HIGH - 20), "#dddddd", 1.0))
    heads = "".join(
        f'<marker id="{colour[1:]}" viewBox="0 0 10 10" refX="9" refY="5" markerWidth="7" markerHeight="7" '
        f'orient="auto"><path d="M 0 0 L 10 5 L 0 10 z" fill="{colour}"/></marker>'
        for colour in (SOFT, BLUE, RED, GREEN)
    )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDE} {HIGH}" width="{WIDE}" height="{HIGH}" '
        f'font-family="sans-serif">\n<defs>{heads}</defs>\n' + "\n".join(parts) + "\n</svg>\n"
    )


if __name__ == "__main__":
    Path(__file__).with_name("which-way-is-up.svg").write_text(drawing(), encoding="utf-8")
