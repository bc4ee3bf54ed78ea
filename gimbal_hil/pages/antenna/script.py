"""The drawing as text for a `<script>` element: `antenna_view` and `animated` of static/antenna.js; no library."""

from __future__ import annotations

from importlib.resources import files

ANTENNA_SCRIPT = (files("gimbal_hil.pages.antenna") / "static" / "antenna.js").read_text(encoding="utf-8")
