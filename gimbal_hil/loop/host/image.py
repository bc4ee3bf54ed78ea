"""Where a host stands before a tick, as text for a log: a run that begins in the middle of another replays.

Of the memory only the words that are not zero are kept, as (place, value), little-endian, in base 64.
"""

from __future__ import annotations

import base64
import binascii

import numpy as np

from firmware_protocol.errors import BadInputError
from gimbal_hil.loop.host.host import Host
from gimbal_hil.loop.host.memory import OCTETS_AT

_WORD = np.dtype([("place", "<u2"), ("value", "<i8")])
#: what the text was made of: another number of words is another layout
IMAGE_WORDS = OCTETS_AT


def image_of(host: Host) -> str:
    """Everything that decides what the host does next, but for the program that it follows."""
    words = host.memory.words[:OCTETS_AT]
    places = np.flatnonzero(words)
    kept = np.zeros(len(places), _WORD)
    kept["place"], kept["value"] = places, words[places]
    return base64.b64encode(kept.tobytes()).decode()


def stand_as(host: Host, image: object, words: object, where: str) -> None:
    """Put a host where an image says; BadInputError for text that is no image of this layout."""
    if words != IMAGE_WORDS:
        raise BadInputError(
            where, f"is of a host with {words} words", f"{IMAGE_WORDS}: the software that recorded the run"
        )
    try:
        data = base64.b64decode(image if isinstance(image, str) else "", validate=True)
        kept = np.frombuffer(data, _WORD)
    except (binascii.Error, ValueError):
        raise BadInputError(where, "is no image of a host", "the event as it was recorded") from None
    if len(kept) and int(kept["place"].max()) >= OCTETS_AT:
        raise BadInputError(where, "names words that a host does not have", "the event as it was recorded")
    host.memory.words[:OCTETS_AT] = 0
    host.memory.words[kept["place"]] = kept["value"]
    host.forget_log()
