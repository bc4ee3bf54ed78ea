"""Questions to a log before it is believed: rows that cannot be, and wrong units, signs or columns."""

from gimbal_hil.data.preflight.impossible_rows import MOST_REPAIRED, Impossible, impossible_rows, questioned
from gimbal_hil.data.preflight.preflight import likely_units, preflight

__all__ = ["MOST_REPAIRED", "Impossible", "impossible_rows", "likely_units", "preflight", "questioned"]
