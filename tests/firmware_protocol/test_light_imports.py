"""Tools that only read frames start fast: the Python codec, the stream and the links need neither numpy nor numba."""

from __future__ import annotations

import subprocess
import sys


def test_codec_stream_and_links_import_nothing_heavy():
    program = (
        "import sys, firmware_protocol.codec, firmware_protocol.stream, firmware_protocol.links;"
        "print([name for name in ('numba', 'numpy', 'can', 'serial') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
