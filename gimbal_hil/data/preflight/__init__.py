"""Does a log fit its model at all? Logs with wrong units, signs or columns are refused, with the reason."""

from gimbal_hil.data.preflight.preflight import preflight

__all__ = ["preflight"]
