"""The page on the configuration file, made from the classes that validate it.

`docs/reference/configuration.md` is what `python -m gimbal_hil.loop.settings.configuration_page` prints; a test holds
the two to each other, and the examples to the loader.
"""

from __future__ import annotations

from collections.abc import Callable

from pydantic import BaseModel

from firmware_protocol.documents import key_table
from firmware_protocol.links import (
    AdapterLinkConfig,
    CanLinkConfig,
    Cut,
    DirectionFaults,
    DriveSection,
    FaultsConfig,
    SerialLinkConfig,
    UnixLinkConfig,
)
from gimbal_hil.loop.settings.axis import (
    AxisSettings,
    Expectation,
    Feedforward,
    JointObserver,
    Limits,
    PositionLoop,
    Prefilter,
    RateLoop,
)
from gimbal_hil.loop.settings.daemon import (
    DaemonSettings,
    Deadman,
    ExpectedAntenna,
    Observer,
    Operator,
    Recording,
    Supervisor,
)
from gimbal_hil.loop.settings.learning import FrictionLevels, LearnedTorque, ModelControl
from gimbal_hil.loop.settings.link import Embedded
from gimbal_hil.loop.settings.pointing import Pointing
from gimbal_hil.loop.settings.shipped import shipped_settings

#: kind of link, what it is, and its section of a file
LINK_EXAMPLES = (
    (
        "embedded",
        "The virtual antenna in the daemon's own process: no hardware, no second terminal. The default.",
        "link:\n  embedded: {model: thesis, seed: 1}      # or the path of your model file",
    ),
    (
        "can",
        "Your own firmware ([how to write it](../how-to/write-your-firmware.md)) on a CAN bus, through python-can. "
        "With\n"
        "SocketCAN set the bus up first: `sudo ip link set can0 up type can bitrate 1000000`.",
        "link: {kind: can, interface: socketcan, channel: can0, bitrate: 1000000}",
    ),
    (
        "serial",
        "A serial port, the pseudo-terminal of `gimbal-hil plant`, or a TCP socket (`socket://host:port`).",
        "link: {kind: serial, port: /dev/ttyACM0, baudrate: 921600}",
    ),
    (
        "unix",
        "A Unix socket, for an antenna in another process of this machine. The daemon and `gimbal-hil plant` read the\n"
        "same file; `plant` makes the socket.",
        "link: {kind: unix, path: /tmp/antenna}",
    ),
    (
        "adapter",
        "Two drives of another make ([adapters](adapters.md)).",
        "link:\n"
        "  kind: adapter\n"
        "  drive: moteus              # odrive, cia402, dbc, or a plug-in's name\n"
        "  interface: socketcan\n"
        "  channel: can0\n"
        "  bitrate: 1000000\n"
        "  data_bitrate: 5000000      # CAN FD; leave it out for classic CAN\n"
        "  drives:                    # the carrying axis first\n"
        "    - {id: 1, torque_nm: 16.0}\n"
        "    - {id: 2, torque_nm: 7.0, sign: -1, gear: 6.0}",
    ),
)
_HEAD = """# Configuration file

Made from `gimbal_hil/loop/settings` by `python -m gimbal_hil.loop.settings.configuration_page`; do not edit.

`antenna.yaml`, the file for `--config`: where the antenna is, how fast the loops run, gains, limits, recording.
`gimbal-hil init mine` writes one for your antenna, with gains that suit its inertia; `gimbal-hil check antenna.yaml`
checks one and names file, key and what was expected. With the output of `gimbal-hil check --schema configuration` an
editor completes the keys. Only `schema` and `axes` are needed; an unknown key is refused. Where the column *default* is
empty, nothing holds unless you give the key.

## Where the antenna is

There are five kinds of link; the file has one of them.
"""
_SECTIONS: tuple[tuple[str, str, type[BaseModel]], ...] = (
    (
        "`axes.NAME`",
        "There are two axes. The one that is carried names the one that carries it: `parent: azimuth`. The names are\n"
        "those of your [model file](model-file.md); `outer` and `inner` fit any antenna. The column *shipped* has\n"
        "the values of `config/virtual_antenna.yaml`, outer and inner axis.",
        AxisSettings,
    ),
    (
        "`axes.NAME.position_loop`",
        "Encoder error to rate reference ([control](../explanation/control.md)).",
        PositionLoop,
    ),
    ("`axes.NAME.rate_loop`", "Rate error to torque.", RateLoop),
    (
        "`axes.NAME.prefilter`",
        "First-order filter of the position reference, `num / (den[0] s + den[1])`.",
        Prefilter,
    ),
    ("`axes.NAME.feedforward`", "Feed-forward of the loops.", Feedforward),
    ("`axes.NAME.limits`", "Limits of the supervisor's [guards](guards.md).", Limits),
    (
        "`axes.NAME.expectation`",
        "How the axis responds to torque, for the guard `RUNAWAY` and the first test; 50 % accuracy is enough.",
        Expectation,
    ),
    (
        "`axes.NAME.observer`",
        "Position, rate and disturbance of the joint ([control](../explanation/control.md)).",
        JointObserver,
    ),
    (
        "`axes.NAME.friction_levels`",
        "Friction levels, estimated ([control](../explanation/control.md#what-no-model-has)); `{}`: the defaults.",
        FrictionLevels,
    ),
    (
        "`axes.NAME.learned`",
        "Learned torque ([control](../explanation/control.md#what-no-model-has)); `{}`: the defaults.",
        LearnedTorque,
    ),
    ("`model_control`", "What the loops use of a model ([control](../explanation/control.md)).", ModelControl),
    ("`supervisor`", "", Supervisor),
    ("`supervisor.deadman`", "", Deadman),
    ("`pointing`", "Mode `pointing` and its mute signal ([pointing](pointing.md)).", Pointing),
    ("`recording`", "The [run folder](run-folder.md).", Recording),
    ("`operator`", "", Operator),
    (
        "`observer`",
        "The [model beside the antenna](daemon.md#the-model-beside-the-antenna): what it lacks, while it runs.",
        Observer,
    ),
    ("`antenna`", "An antenna that says it is another one is refused ([wire](wire.md), `identity`).", ExpectedAntenna),
    ("`link.embedded`", "", Embedded),
    ("`link` of kind `can`", "", CanLinkConfig),
    ("`link` of kind `serial`", "", SerialLinkConfig),
    ("`link` of kind `unix`", "", UnixLinkConfig),
    ("`link` of kind `adapter`", "", AdapterLinkConfig),
    ("`link.drives`", "Of kind `adapter`: two of these.", DriveSection),
    (
        "`link.faults`",
        "Faults on purpose, for tests and demonstrations, the same for the same seed; every kind of link but "
        "`embedded`\ntakes them. Not for a real antenna.",
        FaultsConfig,
    ),
    ("`link.faults.send`, `link.faults.receive`", "Probabilities for each frame.", DirectionFaults),
    ("`link.faults.cuts`", "Times at which nothing passes.", Cut),
)


def configuration_page() -> str:
    """Text of `docs/reference/configuration.md`."""
    parts = [_HEAD]
    for kind, text, example in LINK_EXAMPLES:
        parts.append(f"\n**{kind}**: {text}\n\n```yaml\n{example}\n```\n")
    parts.append("\n## Keys of the file\n\n" + "\n".join(key_table(DaemonSettings)) + "\n")
    for title, text, section in _SECTIONS:
        shown = ("shipped", _shipped(title)) if title.startswith("`axes.NAME.") else None
        said = f"{text}\n\n" if text else ""
        # what every link has in common has a heading of its own
        table = key_table(section, but=("faults",), column=shown)
        parts.append(f"\n## {title}\n\n{said}" + "\n".join(table) + "\n")
    return "".join(parts)


def _shipped(title: str) -> Callable[[str], str]:
    """What the shipped configuration has for a key of this section, outer and inner axis."""
    name = title.strip("`").rpartition(".")[2]
    sections = [getattr(axis, name) for axis in shipped_settings().axes.values()]

    def of(key: str) -> str:
        values: list[object] = [getattr(section, key, None) for section in sections]
        words = [_word(value) for value in values]
        return words[0] if words[0] == words[1] else " / ".join(word or "-" for word in words)

    return of


def _word(value: object) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    return ", ".join(map(str, value)) if isinstance(value, tuple) else f"{value}"


if __name__ == "__main__":
    print(configuration_page(), end="")
