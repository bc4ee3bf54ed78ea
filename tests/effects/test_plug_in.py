"""An effect from another package: one file and an entry point, nothing else."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

EFFECT = '''
import numpy as np

from firmware_protocol.compiling import compiled
from sim_backend.effects import Domain, Effect, Hook, Parameter


@compiled
def wind_torque(P: np.ndarray, o: int, X: np.ndarray, s: int, q: float, v: float, h: float) -> float:
    """A constant push, N m."""
    return P[o]


EFFECT = Effect(
    name="wind",
    domain=Domain.MASS,
    hook=Hook.TORQUE,
    law=wind_torque,
    parameters=(Parameter("push", "N m", -10.0, 10.0, 0.0, "steady torque of the wind"),),
    text="wind on the dish",
    equation="T + push",
    source="test",
    excited_by="standing still in the wind",
)
'''
USE = """
import numpy as np
from sim_backend.model import model_from_document
from sim_backend.plant import Plant

axis = {"body": {"inertia": {"zz": 0.5}}}
effects = [{"name": "wind", "axis": "axis", "push": 0.25}]
document = {"schema": 1, "name": "rig", "kind": "rotary", "axes": {"axis": axis}, "effects": effects}
print(Plant(model_from_document(document, "rig")).run(np.zeros((101, 1))).rate[-1, 0])
"""


def installed(folder: Path, name: str, source: str) -> None:
    """What an installer leaves of a package with one module and one entry point."""
    (folder / f"{name}.py").write_text(source)
    info = folder / f"{name}-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(f"[gimbal_hil.effects]\n{name} = {name}:EFFECT\n")


def python(folder: Path, code: str) -> subprocess.CompletedProcess[str]:
    path = os.pathsep.join([str(folder), os.environ.get("PYTHONPATH", "")])
    # interpreted: one run of a hundred ticks needs no kernel
    environment = {**os.environ, "PYTHONPATH": path, "NUMBA_DISABLE_JIT": "1"}
    return subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, timeout=120, check=False
    )


def test_an_effect_from_outside_the_package_joins_the_plant_and_the_catalogue(tmp_path: Path) -> None:
    installed(tmp_path, "wind_effect", EFFECT)
    used = python(tmp_path, USE)
    assert used.returncode == 0, used.stderr
    assert abs(float(used.stdout) - 0.25 / 0.5 * 0.1) < 1e-12
    listed = python(tmp_path, "from gimbal_hil.surface.cli.app import main; main(['effects', 'wind'])")
    assert "steady torque of the wind" in listed.stdout


def test_the_kernel_of_a_plug_in_is_compiled_anew_when_its_source_changes(tmp_path: Path) -> None:
    installed(tmp_path, "wind_effect", EFFECT)
    digest = (
        "from sim_backend import plant; from firmware_protocol.kernel_cache import source_digest; "
        "print(source_digest('sim_backend.plant'))"
    )
    with_it = python(tmp_path, digest).stdout
    (tmp_path / "wind_effect.py").write_text(EFFECT.replace("return P[o]", "return 2.0 * P[o]"))
    changed = python(tmp_path, digest).stdout
    without = python(tmp_path / "nowhere", digest).stdout
    assert len({with_it, changed, without}) == 3


def test_an_entry_point_that_is_no_effect_is_refused_by_name(tmp_path: Path) -> None:
    installed(tmp_path, "wind_effect", "EFFECT = 3\n")
    refused = python(tmp_path, "from gimbal_hil.surface.cli.app import main; main(['effects'])")
    assert refused.returncode == 2
    assert refused.stderr.strip() == "error: entry point gimbal_hil.effects:wind_effect: is int; expected an Effect"


def test_a_second_effect_of_the_same_name_is_refused(tmp_path: Path) -> None:
    installed(tmp_path, "wind_effect", EFFECT.replace('name="wind"', 'name="cogging"'))
    refused = python(tmp_path, "from gimbal_hil.surface.cli.app import main; main(['effects'])")
    assert refused.returncode == 2
    assert "effect 'cogging': is defined twice" in refused.stderr


def test_the_effect_that_the_docs_page_shows_works_as_it_stands(tmp_path: Path) -> None:
    page = (Path(__file__).resolve().parents[2] / "docs" / "how-to" / "add-an-effect.md").read_text()
    installed(tmp_path, "wind_effect", page.split("```python\n")[1].split("```")[0])
    used = python(tmp_path, USE.replace('"push": 0.25', '"push": -0.25, "direction": 1.5707963267948966'))
    assert used.returncode == 0, used.stderr
    assert abs(float(used.stdout) - 0.25 / 0.5 * 0.1) < 1e-5
