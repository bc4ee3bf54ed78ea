"""A JSON object as Python holds it before anything is known of it: words as keys, any values."""

from __future__ import annotations

from typing import Any, TypeAlias

Json: TypeAlias = dict[str, Any]
