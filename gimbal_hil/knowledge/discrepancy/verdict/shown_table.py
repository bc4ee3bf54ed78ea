"""Tables of what logs would not have shown."""

from __future__ import annotations

from collections.abc import Sequence

from firmware_protocol.json_object import Json
from gimbal_hil.pages.report import Details, Table, quantity


def smallest_shown(entries: Sequence[Json], what: str) -> list[Details]:
    """`smallest_shown` of a verdict as a folded table; `what` would have shown: errors or changes."""
    if not entries:
        return []
    rows = [
        (
            f"{one['name'].replace('_', ' ')} ({one['axis']})",
            f"{one['parameter'].replace('_', ' ')} {quantity(one['size'], one['unit'])}",
            "" if one["relative"] is None else f"{100.0 * one['relative']:.3g} %",
        )
        for one in entries
    ]
    head = ("number or effect", f"smallest {what.removesuffix('s')} that would have shown", "of the model's number")
    return [Details(f"The smallest {what} that these logs would have shown", [Table(head, rows)])]
