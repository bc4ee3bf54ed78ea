"""The operator's socket of a running daemon: the daemon's side and the client."""

from firmware_protocol.json_object import Json
from gimbal_hil.realtime.operator.client import NotReadyError, OperatorClient, RequestRefusedError
from gimbal_hil.realtime.operator.socket import Client, Door, OperatorSocket

__all__ = [
    "Client",
    "Door",
    "Json",
    "NotReadyError",
    "OperatorClient",
    "OperatorSocket",
    "RequestRefusedError",
]
