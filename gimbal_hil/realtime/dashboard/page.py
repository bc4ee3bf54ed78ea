"""The live page: one self-contained document that polls `/live.json` and `/scope.json`; no network, no library."""

from __future__ import annotations

from importlib.resources import files

PAGE = (files("gimbal_hil.realtime.dashboard") / "static" / "live.html").read_text(encoding="utf-8")
