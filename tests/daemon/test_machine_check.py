from __future__ import annotations

import json
import os
import subprocess
import sys

import pytest

from gimbal_hil.loop.timing.clock import Duration
from gimbal_hil.loop.timing.reference_loop import ReferenceLoop, compiler

pytestmark = pytest.mark.realtime

PERIOD = Duration(1_000_000)

#: in a process of its own, because a check changes the policy and the collector of its process
CHECK = """
import json
from gimbal_hil.loop.timing.clock import Duration
from gimbal_hil.loop.timing.machine_check import check_machine
print(json.dumps(check_machine(Duration(1_000_000), 0.4).as_dict()))
"""


@pytest.mark.skipif(compiler() is None, reason="no C compiler")
def test_the_c_loop_counts_every_period_once() -> None:
    with ReferenceLoop() as loop:
        result = loop.run(PERIOD, 200, None, None)
    assert 0 < result.latency.count <= 200
    assert result.latency.count + result.missed >= 200


@pytest.mark.skipif(compiler() is None, reason="no C compiler")
def test_the_c_loop_at_work_counts_what_its_work_cost() -> None:
    with ReferenceLoop() as loop:
        too_much = loop.run(PERIOD, 200, None, None, Duration(4 * PERIOD.ns))
        late_only = loop.run(PERIOD, 200, None, None, Duration(round(0.3 * PERIOD.ns)))
        idle = loop.run(PERIOD, 50, None, None)
    # work that lasts four periods loses at least two ticks (calibration leaves some of the fourth) each time; less than
    # one period, none
    assert too_much.stretched >= 2 * (too_much.latency.count - 1)
    assert idle.stretched == 0
    assert late_only.stretched < 0.2 * late_only.latency.count


def test_the_check_gives_a_verdict_with_reasons_and_measures_both_loops() -> None:
    output = subprocess.run([sys.executable, "-c", CHECK], check=True, capture_output=True, text=True).stdout
    report = json.loads(output)
    assert report["holds"] is (not report["reasons"])
    loop = report["tick_loop"]
    assert loop["ticks"] + loop["missed"] >= 396
    assert sum(loop["missed_by_cause"].values()) == loop["missed"]
    if compiler():
        assert report["c_loop"] is not None and report["p99_ratio_to_c"] > 0
    else:
        assert any("no C compiler" in remark for remark in report["remarks"])


def test_what_is_not_permitted_is_said_and_done_without() -> None:
    if os.geteuid() != 0:
        pytest.skip("needs root to give privileges up")
    program = """
import os, resource
from gimbal_hil.loop.timing.scheduling import claim_real_time
resource.setrlimit(resource.RLIMIT_MEMLOCK, (0, 0))
os.setgroups([]); os.setgid(65534); os.setuid(65534)
granted = claim_real_time(core=10_000)
assert granted.real_time_priority is None and not granted.memory_locked and granted.core is None, granted
assert {line.split(":")[0] for line in granted.refused} == {"SCHED_FIFO", "mlockall", "core 10000"}, granted
assert granted.timer_slack_ns == 1
"""
    process = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert process.returncode == 0, process.stderr


def test_children_do_not_inherit_the_real_time_policy() -> None:
    program = """
import os, subprocess, sys
from gimbal_hil.loop.timing.scheduling import claim_real_time
granted = claim_real_time()
subprocess.run([sys.executable, "-c", "import os; assert os.sched_getscheduler(0) == os.SCHED_OTHER"], check=True)
"""
    subprocess.run([sys.executable, "-c", program], check=True)
