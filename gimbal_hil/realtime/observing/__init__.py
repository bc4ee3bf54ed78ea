"""The model beside the running antenna: estimates the torque that the model lacks, in the service process."""

from gimbal_hil.realtime.observing.change import AxisWatch, WatchState
from gimbal_hil.realtime.observing.live_observer import LiveObserver, observed_model

__all__ = ["AxisWatch", "LiveObserver", "WatchState", "observed_model"]
