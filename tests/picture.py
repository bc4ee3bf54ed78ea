"""The pictures at the top of the README and of the docs, for light and dark screens, from the report of the demo:

gimbal-hil demo --out demo && python -m tests.picture demo/report.html docs/pictures
"""

from __future__ import annotations

import base64
import sys
from pathlib import Path

from tests.browser import Browser

#: CSS pixels, and the second of the motion that is shown
WIDTH, HEIGHT, AT_S = 760, 900, 16.0
#: nothing is drawn in the upper part of the canvas while the antenna looks at the horizon, nor far beside it
EMPTY, SHOWN = 90, 420
#: pixels of the PNG per CSS pixel
SCALE = 2


def picture_of(report: Path, dark: bool) -> bytes:
    """PNG of the antenna and its model's ghost."""
    figure = "document.querySelector('figure.motion')"
    with Browser(WIDTH, HEIGHT, dark) as browser:
        shown = {"width": WIDTH, "height": HEIGHT, "deviceScaleFactor": SCALE, "mobile": False}
        browser.ask("Emulation.setDeviceMetricsOverride", **shown)
        browser.open(report.resolve().as_uri(), f"{figure} && {figure}.querySelector('output').textContent")
        browser.value(f"{figure}.scrollIntoView(); 1")
        browser.value(f"(s => {{ s.value = {AT_S}; s.oninput(); }})({figure}.querySelector('input')); 1")
        browser.until(f"{figure}.querySelector('output').textContent.startsWith('{AT_S:.1f} s')")
        left, top, width, height = browser.value(
            f"(r => [r.left, r.top + scrollY, r.width, r.height])"
            f"({figure}.querySelector('canvas').getBoundingClientRect())"
        )
        clip = {"x": left + (width - SHOWN) / 2, "y": top + EMPTY, "width": SHOWN, "height": height - EMPTY, "scale": 1}
        told = browser.ask("Page.captureScreenshot", captureBeyondViewport=True, clip=clip)
    return base64.b64decode(told["data"])


if __name__ == "__main__":
    for name, dark in (("antenna.png", False), ("antenna-dark.png", True)):
        (Path(sys.argv[2]) / name).write_bytes(picture_of(Path(sys.argv[1]), dark))
