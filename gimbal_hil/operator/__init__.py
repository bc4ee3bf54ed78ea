"""An operator's way to a running daemon: the client, and the socket behind the door that it knocks at."""

from gimbal_hil.operator.client import Json, NotReadyError, OperatorClient, RequestRefusedError
from gimbal_hil.operator.socket import Client, Door, OperatorSocket

__all__ = [
    "Client",
    "Door",
    "Json",
    "NotReadyError",
    "OperatorClient",
    "OperatorSocket",
    "RequestRefusedError",
]
