"""What the host's guards cost: a host tick with and without them, in turn, on the frames of one recorded motion.

    python -m tests.benchmarks.guard_price [--pairs N] [--ticks N]

The guards cannot be switched off. The host without them is compiled from a copy of its source in which what watches and
judges the sensors, the limits and the set-points' echo does nothing; identity, link, drive states and what a segment
itself allows stay. Both hosts get the same frames and must send the same bytes. The ratio is pair by pair, in processor
time of this process; the compilation takes a minute or two.
"""

from __future__ import annotations

import argparse
import ast
import os
import statistics
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from types import ModuleType

from gimbal_hil.loop.host import Host
from gimbal_hil.loop.settings import host_configuration, shipped_settings
from gimbal_hil.proof.bench.figures import paired
from gimbal_hil.proof.bench.speed import work_program
from gimbal_hil.realtime.lockstep import FramePath
from sim_backend.model import shipped_model

#: host modules in the order of import from the first one changed on, each with the functions that then do nothing
WITHOUT: dict[str, tuple[str, ...]] = {
    "plausibility": ("watch_status", "watch_sensors"),
    "limits": ("report_beyond_limits",),
    "reception": ("_compare_gyro_and_encoder",),
    "core": ("_check_limits",),
    "frame_tick": (),
    "host": (),
}


def source_without(name: str) -> ast.Module:
    """A module of the host whose guards do nothing."""
    path = _path(name)
    tree, left = ast.parse(path.read_text()), set(WITHOUT[name])
    for node in tree.body:
        if isinstance(node, ast.FunctionDef) and node.name in left:
            node.body = [ast.Pass()]
            left.remove(node.name)
    if left:
        raise LookupError(f"{path.name} has no {', '.join(sorted(left))}: bring WITHOUT up to date")
    return ast.fix_missing_locations(tree)


def host_without_guards() -> type[Host]:
    """A Host of its own, compiled apart from the shipped one and its cache."""
    with _own_modules(), tempfile.TemporaryDirectory() as cache:
        kept, os.environ["GIMBAL_HIL_CACHE"] = os.environ.get("GIMBAL_HIL_CACHE"), cache
        try:
            for name in WITHOUT:
                module = ModuleType(f"gimbal_hil.loop.host.{name}")
                module.__file__ = str(_path(name))
                sys.modules[module.__name__] = module
                exec(compile(source_without(name), str(_path(name)), "exec"), module.__dict__)
            host: type[Host] = module.__dict__["Host"]
            # compiled now, while its cache is there
            host(host_configuration(shipped_settings())).tick(0, 0, b"")
        finally:
            os.environ.pop("GIMBAL_HIL_CACHE")
            if kept is not None:
                os.environ["GIMBAL_HIL_CACHE"] = kept
    return host


def recorded(ticks: int) -> tuple[int, list[tuple[int, bytes, bytes]]]:
    """Both axes following sines on the virtual antenna: tick, bytes received and sent; and when the motion began."""
    blocks: list[tuple[int, bytes, bytes]] = []
    path = FramePath(shipped_settings(), shipped_model(), 1, exchange=lambda *block: blocks.append(block))
    path.connect()
    began = len(blocks)
    path.host.command(work_program(shipped_settings()))
    path.advance(ticks, every=100)
    return began, blocks


def main() -> None:
    """Record, compile, compare, measure, print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--pairs", type=int, default=41)
    parser.add_argument("--ticks", type=int, default=20_000)
    wanted = parser.parse_args()
    began, blocks = recorded(wanted.ticks)
    with_guards, without = _ticking(Host, began, blocks), _ticking(host_without_guards(), began, blocks)
    ours, theirs = paired(with_guards, without, wanted.pairs)
    ratios = sorted(a / b for a, b in zip(ours, theirs, strict=True))
    low, _, high = statistics.quantiles(ratios, n=4)
    guarded, bare = (1e6 * statistics.median(times) / len(blocks) for times in (ours, theirs))
    print(f"host tick with guards {guarded:.3f} us, without {bare:.3f} us, {len(blocks)} ticks, same bytes sent")
    print(
        f"ratio {statistics.median(ratios):.3f}, half of the pairs within {low:.3f} to {high:.3f}, all within"
        f" {ratios[0]:.3f} to {ratios[-1]:.3f}, {len(ratios)} pairs"
    )


def _ticking(host: type[Host], began: int, blocks: list[tuple[int, bytes, bytes]]) -> Callable[[], None]:
    """A call that takes a fresh host through the recorded frames; the first one looks at what it sends."""
    settings = shipped_settings()
    configuration, program = host_configuration(settings), work_program(settings)

    def run(each: Callable[[bytes, bytes], None] | None = None) -> None:
        one = host(configuration)
        for number, (tick, received, sent) in enumerate(blocks):
            if number == began:
                one.command(program)
            answer = one.tick(tick, 0, received)
            if each is not None:
                each(answer, sent)

    def same(answer: bytes, sent: bytes) -> None:
        if answer != sent:
            raise ValueError("the recorded motion is not sent again: the copy without guards does something else")

    run(same)
    return run


@contextmanager
def _own_modules() -> Iterator[None]:
    shipped = {name: sys.modules[name] for name in (f"gimbal_hil.loop.host.{name}" for name in WITHOUT)}
    try:
        yield
    finally:
        sys.modules |= shipped


def _path(name: str) -> Path:
    file = import_module(f"gimbal_hil.loop.host.{name}").__file__
    assert file is not None
    return Path(file)


if __name__ == "__main__":
    main()
