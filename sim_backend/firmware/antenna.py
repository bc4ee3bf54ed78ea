"""The virtual antenna with the C device in place of the Python one: the same face, the same plant, the same frames."""

from __future__ import annotations

import ctypes
from abc import abstractmethod
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from firmware_protocol.schema import RECORD_SIZE, TORQUE_STEP_NM
from sim_backend.device import Device, Drive, FirmwareSettings, Spoilt
from sim_backend.firmware.electronics import BASE_SIZE, SENSED_SIZE, WANTED_SIZE, pass_tick
from sim_backend.firmware.library import BenchLibrary
from sim_backend.firmware.structures import AXES, CSettings, HostBench
from sim_backend.model import AntennaModel

_INT32_LOW, _INT32_HIGH = -(1 << 31), (1 << 31) - 1
#: bytes of a block that are handed over at most; of a longer one the newest frames count, as in `Device`
_RECEIVED_SIZE = 65536


def fill_settings(settings: CSettings, drive: Drive, axes: int) -> None:
    """Settings of the C device from a record of the drive that has just got its supply; a limit that is never reached
    is the end of 32 bits.
    """
    for own, source, count in [(settings, drive, 0), *((settings.joints[k], drive.joints[k], k) for k in range(AXES))]:
        for name, kind in type(own)._fields_:
            if name not in ("axes", "joints", "deadman_window", "deadman_reaction"):
                value = int(getattr(source, name))
                narrow = kind is ctypes.c_int32
                setattr(own, name, min(max(value, _INT32_LOW), _INT32_HIGH) if narrow else value)
        if count == 0 and own is settings:
            settings.axes = axes
            settings.deadman_window, settings.deadman_reaction = int(drive.window), int(drive.reaction)


class FirmwareAntenna(Device):
    """A virtual antenna whose frames come from firmware; how that is run, a class below says.

    `firmware` is the memory of the C device and `drive` the state in it, `electronics` the record that its sensors and
    motors are in.
    """

    firmware: Any

    def __init__(
        self, model: AntennaModel, settings: FirmwareSettings | None = None, rate_hz: float = 1000.0, seed: int = 0
    ) -> None:
        super().__init__(model, settings, rate_hz, seed)
        self.electronics = self.drive
        self._wanted = np.zeros(AXES * WANTED_SIZE, dtype=np.int64)
        self._sensed = np.zeros(AXES * SENSED_SIZE + BASE_SIZE, dtype=np.int64)
        self._compile()

    def tick(self, received: bytes = b"") -> bytes:
        """Take a block of frames, whatever is in it, go on by one tick, answer the block of this tick."""
        if len(received) > _RECEIVED_SIZE:
            end = len(received) - len(received) % RECORD_SIZE
            received = received[max(0, end - (_RECEIVED_SIZE - _RECEIVED_SIZE % RECORD_SIZE)) : end]
        return self._firmware_tick(received)

    @abstractmethod
    def _firmware_tick(self, received: bytes) -> bytes:
        """One tick of the firmware, in the midst of which it calls `_pass`."""

    def _look_into(self, firmware: Any, settings: CSettings) -> None:
        """Take these as the memory of the C device and of its settings."""
        self.firmware, self.drive, self._own_settings = firmware, firmware.drive, settings
        # before it are two pointers, which are never the same
        self._kept = np.frombuffer(firmware, np.uint8)[type(firmware).drive.offset :]

    @property
    def arrays(self) -> dict[str, np.ndarray]:
        """See `Device`; those of the C device with it."""
        return super().arrays | {"firmware": self._kept}

    def take_over(self, before: Device) -> None:
        """See `Device`; `before` runs the same firmware in the same way."""
        assert isinstance(before, FirmwareAntenna)
        super().take_over(before)
        self._kept[:] = before._kept
        ctypes.memmove(ctypes.addressof(self._own_settings), bytes(before._own_settings), ctypes.sizeof(CSettings))

    def _advance_plant(self) -> None:
        """One tick from `_wanted` to `_sensed`."""
        pass_tick(self.P, self.K, self.X, self.drive_words, self.mail, self._wanted, self._sensed)

    def _compile(self) -> None:
        """Load what is compiled before anybody waits; nothing has happened yet."""
        states = (self.X, self.drive_words, self.mail)
        before = [state.copy() for state in states]
        self._advance_plant()
        for state, kept in zip(states, before, strict=True):
            state[:] = kept
        self._sensed[:] = 0

    def close(self) -> None:
        """Give back what the firmware runs on."""

    @property
    def torques_nm(self) -> tuple[float, ...]:
        """Torque that the drive applied in the last tick, N m (N on a linear axis)."""
        return tuple(
            float(self.drive.joints[axis].applied_torque << self.electronics.joints[axis].exponent) * TORQUE_STEP_NM
            for axis in range(len(self.model.axes))
        )

    @property
    def set_points(self) -> tuple[int, int]:
        """Set-points that fed the deadman, and repeats or stale ones that did not."""
        return int(self.drive.taken), int(self.drive.refused)

    @property
    def bad_frames(self) -> int:
        """Frames dropped so far because of their CRC, a field's range or a strange identifier."""
        device = self.firmware
        return int(device.stray_frames) + sum(int(one.crc_errors + one.out_of_range) for one in device.receivers)

    @property
    def repeated_frames(self) -> int:
        """Frames dropped so far because their alive counter repeats or comes late."""
        return sum(int(one.duplicates) for one in self.firmware.receivers)

    def set_supply(self, supply_v: float) -> None:
        """Let the supply have another voltage, as on a bench: below the firmware's least one the drive faults."""
        with self._electronics_as_drive():
            super().set_supply(supply_v)

    def spoil(self, axis: int, part: str, kind: Spoilt, amount: int = 0) -> None:
        """Give an axis a fault of its `encoder`, `gyro` or `motor` from the next tick on, as on a bench."""
        with self._electronics_as_drive():
            super().spoil(axis, part, kind, amount)

    @contextmanager
    def _electronics_as_drive(self) -> Iterator[None]:
        """What is done to the drive on a bench is done to its electronics, not to the state of the C device."""
        state, self.drive = self.drive, self.electronics
        try:
            yield
        finally:
            self.drive = state


class BenchAntenna(FirmwareAntenna):
    """The C device on a bench of memory (`gimbal_bench.h`), which calls back for a tick to pass on the plant."""

    def __init__(
        self,
        bench: Any,
        model: AntennaModel,
        settings: FirmwareSettings | None = None,
        rate_hz: float = 1000.0,
        seed: int = 0,
    ) -> None:
        super().__init__(model, settings, rate_hz, seed)
        self.bench = bench
        self._failure: BaseException | None = None
        fill_settings(bench.settings, self.electronics, len(self.model.axes))
        self._power_up()
        self._look_into(bench.device, bench.settings)

    @abstractmethod
    def _power_up(self) -> None:
        """Start the device of the bench, and have it call `_called_back`."""

    @abstractmethod
    def _bench_tick(self, received: bytes) -> None:
        """One tick of the bench."""

    def _called_back(self, *_: object) -> None:
        # an exception cannot pass through C, and would be lost in an emulator
        try:
            self._pass()
        except BaseException as error:
            self._failure = error

    def _firmware_tick(self, received: bytes) -> bytes:
        self.bench.supply = int(self.electronics.supply)
        self._bench_tick(received)
        if self._failure is not None:
            failure, self._failure = self._failure, None
            raise failure
        return bytes(memoryview(self.bench.sent)[: self.bench.sent_size])

    def _pass(self) -> None:
        """Let the tick pass on the plant as the firmware's actuation says, and give it what the sensors read."""
        wanted, sensed, bench = self._wanted, self._sensed, self.bench
        for axis in range(AXES):
            asked = bench.wanted[axis]
            wanted[WANTED_SIZE * axis : WANTED_SIZE * (axis + 1)] = (
                asked.torque,
                asked.powered,
                asked.shorted,
                asked.brake_held,
            )
        self._advance_plant()
        values = sensed.tolist()
        for axis in range(AXES):
            sample, at = bench.samples[axis], SENSED_SIZE * axis
            sample.position, sample.rate, sample.torque, sample.winding = values[at : at + 4]
            sample.valid = bool(values[at + 4])
        base = bench.base
        base.roll, base.pitch, base.yaw, base.p, base.q, base.r = values[AXES * SENSED_SIZE :]


class LibraryAntenna(BenchAntenna):
    """The C device as a library of this process."""

    def __init__(
        self,
        library: BenchLibrary,
        model: AntennaModel,
        settings: FirmwareSettings | None = None,
        rate_hz: float = 1000.0,
        seed: int = 0,
    ) -> None:
        self._library = library
        super().__init__(HostBench(), model, settings, rate_hz, seed)

    def _power_up(self) -> None:
        self._library.start(self.bench)
        # kept, because the C side has only its address
        self._callback = ctypes.CFUNCTYPE(None)(self._called_back)
        self.bench.advance = ctypes.cast(self._callback, ctypes.c_void_p)

    def _bench_tick(self, received: bytes) -> None:
        self._library.tick(self.bench, received, len(received))
