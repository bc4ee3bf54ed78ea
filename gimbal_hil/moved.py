"""Old names of moved folders: `gimbal_hil.runs` is `gimbal_hil.data.runs` since 0.2.0. Scripts that say the old name
get the same modules, not copies.
"""

from __future__ import annotations

import importlib
import warnings
from collections.abc import Sequence
from importlib.abc import Loader
from importlib.machinery import ModuleSpec
from types import ModuleType

_DISTRICTS = {
    "loop": ("control", "host", "settings", "timing"),
    "pages": ("plots", "report"),
    "data": ("runs", "signals", "exports", "catalogue", "preflight"),
    "realtime": ("telemetry", "operator", "observing", "dashboard", "service", "daemon", "lockstep"),
    "knowledge": ("executor", "estimation", "identification", "experiments", "tuning", "discrepancy", "improvement"),
    "proof": ("bench", "campaign", "conformance", "thesis"),
    "pointing": ("arena",),
    "surface": ("library", "testing", "checking", "starting", "demo", "deployment", "warming", "cli"),
}
#: old top-level folder to the district that it lies in now
DISTRICT_OF = {folder: district for district, folders in _DISTRICTS.items() for folder in folders}


class MovedFolders:
    """Finder of the old names, asked after all others: it loads the module of the new name and warns once a caller."""

    @staticmethod
    def find_spec(name: str, path: Sequence[str] | None = None, target: ModuleType | None = None) -> ModuleSpec | None:
        """Spec of an old name, None of any other."""
        package, _, rest = name.partition(".")
        folder, _, inner = rest.partition(".")
        if package != "gimbal_hil" or folder not in DISTRICT_OF:
            return None
        new = f"{package}.{DISTRICT_OF[folder]}.{rest}"
        if not inner:
            warnings.warn(f"{name} is {new} now", DeprecationWarning, stacklevel=2)
        return ModuleSpec(name, _Forward(new))


class _Forward(Loader):
    """Hands out the module that lies at another name, as it is."""

    def __init__(self, new: str) -> None:
        self._new = new

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        module = importlib.import_module(self._new)
        self._own_spec = module.__spec__
        return module

    def exec_module(self, module: ModuleType) -> None:
        # the import system has just written the old name's spec into the module
        module.__spec__ = self._own_spec
