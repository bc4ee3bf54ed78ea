"""Pointing: where the antenna looks, and how well it stays there.

arena      controllers compared, scenario by scenario, by the true line of sight
following  targets in the sky, following them, errors and report
certifying many drawn flights with errors of the navigation, and what they certify

The control law itself lies in loop/control, gains in knowledge/tuning.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any


def __getattr__(name: str) -> Any:
    """Public names of `following`, which was this folder until 0.2.0."""
    # "from this package import following" would ask here for following first
    following = import_module("gimbal_hil.pointing.following")
    if name in following.__all__:
        return getattr(following, name)
    raise AttributeError(f"module 'gimbal_hil.pointing' has no attribute {name!r}")
