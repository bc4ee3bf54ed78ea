"""The service process beside the control process: recorder, operator's desk, live page; nothing that it does can delay
a tick.
"""

from gimbal_hil.realtime.service.process import ServiceProcess, ServiceSettings

__all__ = [
    "ServiceProcess",
    "ServiceSettings",
]
