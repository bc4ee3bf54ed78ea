"""The model beside the running antenna: estimates the torque that the model lacks, in the service process."""

from gimbal_hil.realtime.observing.change import AxisWatch, WatchState
from gimbal_hil.realtime.observing.live_observer import LiveObserver, observed_model
from gimbal_hil.realtime.observing.suspicion import CONFIRMED_BY, Suspected

__all__ = ["CONFIRMED_BY", "AxisWatch", "LiveObserver", "Suspected", "WatchState", "observed_model"]
