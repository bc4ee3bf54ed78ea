"""The live page: one self-contained document that polls `/live.json` and `/scope.json`; no network, no library."""

from __future__ import annotations

from importlib.resources import files

from gimbal_hil.pages.antenna import ANTENNA_SCRIPT


def _static(name: str) -> str:
    return (files("gimbal_hil.realtime.dashboard") / "static" / name).read_text(encoding="utf-8")


# the page's content policy allows no script from elsewhere, so all of it stands in the page
PAGE = _static("live.html").replace("/*antenna.js*/\n", ANTENNA_SCRIPT).replace("/*seen.js*/\n", _static("seen.js"))
