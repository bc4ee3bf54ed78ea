"""Coverage-guided fuzzing with atheris (extra `fuzz`).

    python -m tests.fuzz.coverage_guided TARGET [--runs N | --seconds S] [--corpus DIR]

Targets: wire (stream parsers and codec), log (every file of a run folder), loaders (configuration, plan, model), door
(the operator's lines, pieces and all). An input is read or refused with the project's own error; anything else ends the
fuzzing with the input that did it. libFuzzer's last lines give inputs, covered edges (`cov`) and the corpus.
"""

from __future__ import annotations

import argparse
import os
import random
import sys
import tempfile
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import atheris

#: instrumented: what reads, not what is compiled to machine code
READING = (
    "firmware_protocol.stream",
    "firmware_protocol.codec",
    "firmware_protocol.links.slcan_device",
    "firmware_protocol.documents",
    "gimbal_hil.data.runs",
    "gimbal_hil.realtime.operator",
    "gimbal_hil.realtime.service.operator_commands",
    "gimbal_hil.loop.settings",
    "gimbal_hil.knowledge.experiments.plan",
    "gimbal_hil.knowledge.experiments.references",
    "gimbal_hil.loop.host.program",
    "gimbal_hil.loop.host.program_check",
    "sim_backend.model.file",
    "sim_backend.model.model",
    "sim_backend.model.uncertainty",
)
Target = Callable[[bytes], None]


def wire() -> tuple[Target, list[bytes]]:
    """Bytes from a port: COBS packets, slcan lines, single frames of every message."""
    from firmware_protocol.codec import Rejection, pack_raw, records, unpack
    from firmware_protocol.links.slcan_device import SlcanDevice
    from firmware_protocol.schema import MESSAGES
    from firmware_protocol.stream import StreamParser, encode_packets

    def target(data: bytes) -> None:
        for parser in (StreamParser(), SlcanDevice()):
            cut = data[0] % (len(data) + 1) if data else 0
            block = parser.feed(data[:cut]) + parser.feed(data[cut:])
            assert len(block) % 10 == 0
            for can_id, payload in records(block):
                unpack(can_id, payload)
        if len(data) >= 10:
            answer = unpack(int.from_bytes(data[:2], "little"), data[2:10])
            assert isinstance(answer, Rejection) or answer is not None

    frames = [m.can_id.to_bytes(2, "little") + pack_raw(m, [0] * len(m.fields), 3) for m in MESSAGES]
    return target, [
        *frames,
        *(encode_packets(frame) for frame in frames),
        b"t1008" + b"00" * 8 + b"\r",
        b"S8\rO\r",
        b"V\rN\r",
    ]


def log() -> tuple[Target, list[bytes]]:
    """One file of a run folder replaced; the first byte says which."""
    from gimbal_hil.data.runs import damage_of, open_run
    from tests.runs.synthetic import record_run

    folder = Path(tempfile.mkdtemp(prefix="gimbal-hil-fuzz-")) / "run"
    record_run(folder, 20, flush_every=5)
    names = ("run.yaml", "events.jsonl", "chain.jsonl", "ticks.arrow", "frames.arrow")
    whole = {name: (folder / name).read_bytes() for name in names}
    target_error = _own_error()

    def target(data: bytes) -> None:
        name = names[data[0] % len(names)] if data else names[0]
        (folder / name).write_bytes(data[1:])
        with suppress(target_error):
            list(damage_of(open_run(folder)))
        (folder / name).write_bytes(whole[name])

    return target, [bytes([place]) + whole[name] for place, name in enumerate(names)]


def loaders() -> tuple[Target, list[bytes]]:
    """A YAML file, read as each of the three kinds."""
    from tests.fuzz.targets import READERS, shipped

    target_error = _own_error()
    kinds = ("configuration", "plan", "model")

    def target(data: bytes) -> None:
        with suppress(target_error):
            READERS[kinds[data[0] % 3] if data else "plan"](data[1:])

    return target, [bytes([place]) + text.encode() for place, kind in enumerate(kinds) for text in shipped(kind)]


def door() -> tuple[Target, list[bytes]]:
    """What a connection sends, in pieces, first without and then with the token."""
    import json
    import socket

    from firmware_protocol.errors import BadInputError
    from gimbal_hil.realtime.operator import Client, Door, OperatorSocket
    from gimbal_hil.realtime.service.operator_commands import PlainRequest, parse_request
    from tests.fuzz.targets import REQUESTS, start_request

    here = Door.make()

    def handle(_client: Client, line: dict[str, object]) -> dict[str, object]:
        try:
            request = parse_request(line)
            if not isinstance(request, PlainRequest):
                request.program(0.001)
        except BadInputError as error:
            return {"ok": False, "error": str(error)}
        return {"ok": True}

    operator = OperatorSocket(here, handle)
    greeting = json.dumps({"token": here.token}).encode() + b"\n"

    def target(data: bytes) -> None:
        connection = socket.socket(socket.AF_UNIX)
        connection.connect(str(here.socket))
        connection.setblocking(False)
        try:
            if data[:1] > b"\x20":
                connection.send(greeting)
            cut = len(data) // 2
            for part in (data[1:cut], data[cut:], b"\n"):
                connection.send(part[:100_000])
                operator.serve(0.0)
            operator.serve(0.0)
            said = b""
            with suppress(BlockingIOError):
                said = connection.recv(1 << 20)
            assert b"the daemon failed at this request" not in said, said
        except (BrokenPipeError, ConnectionResetError, BlockingIOError):
            pass
        finally:
            connection.close()
            operator.serve(0.0)

    requests = [*REQUESTS, start_request(random.Random(1))]
    return target, [b"x" + json.dumps(request).encode() for request in requests] + [b" " + greeting]


def _own_error() -> type[Exception]:
    from firmware_protocol.errors import GimbalHilError

    return GimbalHilError


TARGETS: dict[str, Callable[[], tuple[Target, list[bytes]]]] = {
    "wire": wire,
    "log": log,
    "loaders": loaders,
    "door": door,
}


def main() -> None:
    """Fuzz one target; does not come back (libFuzzer ends the process)."""
    parser = argparse.ArgumentParser()
    parser.add_argument("target", choices=TARGETS)
    parser.add_argument("--runs", type=int, default=-1)
    parser.add_argument("--seconds", type=int, default=0)
    parser.add_argument("--corpus", type=Path)
    words = parser.parse_args()
    os.environ.setdefault("NUMBA_DISABLE_JIT", "1")
    with atheris.instrument_imports(include=list(READING), enable_loader_override=False):
        target, seeds = TARGETS[words.target]()
    corpus = words.corpus or Path(tempfile.mkdtemp(prefix="gimbal-hil-corpus-"))
    corpus.mkdir(parents=True, exist_ok=True)
    for place, seed in enumerate(seeds):
        (corpus / f"seed-{place}").write_bytes(seed)
    longest = max(20_000, max(map(len, seeds)))
    options = [
        f"-runs={words.runs}",
        f"-max_total_time={words.seconds}",
        f"-max_len={longest}",
        "-len_control=0",
        "-seed=1",
    ]
    atheris.Setup([sys.argv[0], *options, "-timeout=60", "-rss_limit_mb=3000", str(corpus)], target)
    atheris.Fuzz()


if __name__ == "__main__":
    main()
