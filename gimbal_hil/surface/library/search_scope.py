"""What a search looks for, as one value."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class SearchScope:
    """Effects that alone are searched (all of the catalogue without them), effects to leave out, and the end of the
    scored band (Hz); without it what the logs carry.
    """

    only: tuple[str, ...] = ()
    without: tuple[str, ...] = ()
    band_hz: float | None = None
