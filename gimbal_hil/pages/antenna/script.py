"""The drawing as text for a `<script>` element, without any library."""

from __future__ import annotations

from importlib.resources import files


def _static(name: str) -> str:
    return (files("gimbal_hil.pages.antenna") / "static" / name).read_text(encoding="utf-8")


#: `antenna_view(canvas, colour, names)` and `animated(canvas, frame)`
ANTENNA_SCRIPT = _static("antenna.js")
#: `motion_player(figure)`, which needs both: the figure of a recorded motion beside models of it
MOTION_SCRIPT = _static("motion.js")
