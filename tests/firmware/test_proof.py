"""What an analyser proves of the C device, for every session of any length: any frames, any sensors, any supply.

Abstract interpretation (Frama-C, plug-in Eva) covers every run of `any_session.c` at once; what it does not complain of
cannot happen. It keeps intervals, so it cannot see that a momentum fades: those sums are listed.
"""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from sim_backend.firmware import DEVICE_SOURCES
from sim_backend.firmware.handing_over import device_files
from sim_backend.model import shipped_model

#: sums whose bound follows from more than one number; the sessions of test_parity.py run them
SUMS = {
    "joint->momentum = gimbal_floor_scaled(joint->momentum * kept) + gained;",
    "joint->effort = gimbal_floor_scaled(joint->effort * kept) + gimbal_scaled(gimbal_abs(torque));",
    "return scaled >= 0 ? scaled / one : -((-scaled + one - 1) / one);",
}


@pytest.mark.heavy
@pytest.mark.skipif(shutil.which("frama-c") is None, reason="needs frama-c (apt install frama-c-base)")
def test_no_session_of_any_length_asks_for_a_torque_beyond_the_limit_or_overflows_but_in_listed_sums(
    tmp_path: Path,
) -> None:
    for name, text in device_files(shipped_model("thesis"), 1000.0).items():
        (tmp_path / name).write_text(text)
    driver = Path(__file__).with_name("any_session.c")
    sources = [tmp_path / name for name in DEVICE_SOURCES if name != "gimbal_stream.c"]
    words = ["-eva", "-eva-precision", "2", "-machdep", "gcc_x86_64", f"-cpp-extra-args=-I{tmp_path}"]
    done = subprocess.run(
        ["frama-c", *words, str(driver), *map(str, sources)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert re.search(r"Assertions +1 valid +0 unknown +0 invalid", done.stdout), done.stdout[-2000:]
    alarms = re.findall(r"\[eva:alarm\] (\S+):(\d+): Warning:\s+([^.]*)\.", done.stdout)
    assert alarms, "the sums below are out of date"
    for file, line, what in alarms:
        source = (tmp_path / Path(file).name).read_text().splitlines()[int(line) - 1].strip()
        assert what == "signed overflow" and source in SUMS, f"{file}:{line}: {what}: {source}"
