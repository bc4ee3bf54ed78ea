"""Whether drives do as told: an order stands, and is repeated, until each of them has said so itself. Sans-IO."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from enum import Enum

from firmware_protocol.adapters.drive import (
    AxisSample,
    ForeignDrive,
    Power,
    answer_time_s,
    starved,
    stopped_blindly,
)
from firmware_protocol.enumerations import StopReaction
from firmware_protocol.links import CanFrame

#: a drive that answers at once has so many ticks to do as told
_LEAST_TICKS = 20


class Order(Enum):
    """What the drives were last told; the value says what one that does not obey was told."""

    #: nothing: no host has asked for anything
    NONE = "asked"
    #: set-points, or the way to them
    FOLLOW = "told to follow"
    STOP = "told to stop"
    #: a stop that uses no sensor, because one is in doubt
    STOP_BLINDLY = "told to stop without a sensor"
    RELEASE = "told to let go"


#: no drive here stops by a gyro: then what uses no sensor is left
_STOPS = {
    StopReaction.COAST: Order.RELEASE,
    StopReaction.BRAKE: Order.STOP_BLINDLY,
    StopReaction.DECELERATE_AND_HOLD: Order.STOP,
    StopReaction.GYRO_STOP: Order.STOP_BLINDLY,
}


class Obedience:
    """One order for all drives.

    A word counts as an answer where it is newer than the order. Drives that say otherwise are told again with every
    tick; one that still does after its time is left to its own watchdog, with all others: what feeds it (a heartbeat)
    is heard by everybody.
    """

    def __init__(self, drives: Sequence[ForeignDrive], period_s: float) -> None:
        self._drives = tuple(drives)
        self._patience = [max(_LEAST_TICKS, round(answer_time_s(drive) / period_s)) for drive in drives]
        self._period_s = period_s
        self.order = Order.NONE
        self._words, self._places = [0] * len(self._drives), [0] * len(self._drives)
        self._unheeded = [0] * len(self._drives)
        #: whether drives are left to their own watchdogs
        self.starving = False

    def give(self, order: Order) -> None:
        """A new order; the one that stands already goes on."""
        if order is self.order:
            return
        self.order = order
        self._words = [drive.sample.words for drive in self._drives]
        self._places = [drive.sample.updates for drive in self._drives]
        self._unheeded = [0] * len(self._drives)
        self.starving = self.starving and order is not Order.FOLLOW

    def stop(self, how: StopReaction) -> None:
        """A stop that uses no sensor stands until the host leads back: no other takes its place."""
        if self.order is not Order.STOP_BLINDLY:
            self.give(_STOPS[how])

    def let_go(self) -> None:
        """No torque any more; a winding that is shorted applies none of the drive's, and stays so."""
        if self.order is not Order.STOP_BLINDLY:
            self.give(Order.RELEASE)

    def frames(self) -> list[CanFrame]:
        """What the drives are sent in this tick, while they are not to follow."""
        told: list[CanFrame] = []
        for place, drive in enumerate(self._drives):
            heeds = self._heeds(place)
            self._unheeded[place] = 0 if heeds else self._unheeded[place] + 1
            if self.starving:
                told += starved(drive)
                continue
            if self._is_told_again(place):
                told += _TOLD[self.order](drive)
            told += drive.ask()
        return told

    def gave_up(self) -> bool:
        """Whether a drive has had its time; from now on none is fed."""
        late = any(ticks > most for ticks, most in zip(self._unheeded, self._patience, strict=True))
        if late and not self.starving:
            self.starving = True
            return True
        return False

    def is_silent(self) -> bool:
        """Whether a drive has said nothing at all since the order."""
        return any(drive.sample.updates == place for drive, place in zip(self._drives, self._places, strict=True))

    def is_done(self) -> bool:
        """Whether every drive has said, since the order, that it does as told."""
        return all(self._heeds(place) for place in range(len(self._drives)))

    def without_torque(self) -> bool:
        """Whether every drive has said, since the order, that it has none."""
        return all(
            drive.sample.words > words and not drive.sample.power.is_powered
            for drive, words in zip(self._drives, self._words, strict=True)
        )

    def feed_again(self) -> None:
        """Every drive has let go: their watchdogs are fed from here on."""
        self.starving = False

    def complaint(self, place: int) -> str:
        """What is to be said of a drive that does not obey."""
        if self._unheeded[place] <= self._patience[place]:
            return ""
        sample = self._drives[place].sample
        says = "says nothing" if sample.words == self._words[place] else f"says {sample.power.value}"
        waited = self._patience[place] * self._period_s
        return f"{self.order.value}, {says} after {1e3 * waited:g} ms; its watchdog is fed no more"

    def _heeds(self, place: int) -> bool:
        if self.order in (Order.NONE, Order.FOLLOW):
            return True
        sample = self._drives[place].sample
        return sample.words > self._words[place] and does(self.order, sample)

    def _is_told_again(self, place: int) -> bool:
        """Until its newest word is one of obedience; the order does no harm to one that reacts to a fault."""
        return self.order is not Order.NONE and (
            not self._heeds(place) or self._drives[place].sample.power is Power.REACTING
        )


_TOLD: dict[Order, Callable[[ForeignDrive], list[CanFrame]]] = {
    Order.STOP: lambda drive: drive.stop(),
    Order.STOP_BLINDLY: stopped_blindly,
    Order.RELEASE: lambda drive: drive.release(),
}


def does(order: Order, sample: AxisSample) -> bool:
    """Whether a sample is that of a drive which does as told; one that reacts to a fault has a way of its own."""
    if order is Order.STOP:
        return sample.power is not Power.ON
    return sample.power not in (Power.ON, Power.STOPPING)
