"""The model beside the antenna while it runs: what it lacks, in the service process, never in the loop."""

from gimbal_hil.observing.change import AxisWatch, WatchState
from gimbal_hil.observing.live_observer import LiveObserver, observed_model

__all__ = ["AxisWatch", "LiveObserver", "WatchState", "observed_model"]
