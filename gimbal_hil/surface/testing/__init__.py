"""For tests of an antenna: signals with assertions, and the fixtures of the pytest plugin.

Nothing heavy is loaded here, because the plugin is loaded by every pytest where this package is installed.
"""

from gimbal_hil.surface.testing.assertions import Band, Judgement, MadeStep, Signal, within

__all__ = ["Band", "Judgement", "MadeStep", "Signal", "within"]
