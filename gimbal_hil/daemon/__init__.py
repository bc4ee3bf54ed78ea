"""The control daemon: tick engine, control process, service process and operator commands."""

from gimbal_hil.daemon.operator_client import OperatorClient, RequestRefusedError

__all__ = ["OperatorClient", "RequestRefusedError"]
