"""Does a log fit its model at all? Wrong units, signs and columns are refused by name before anything is judged."""

from gimbal_hil.preflight.preflight import preflight

__all__ = ["preflight"]
