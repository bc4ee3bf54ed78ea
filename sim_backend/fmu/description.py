"""What an FMU says of itself: modelDescription.xml, the bus terminal, and the manifest of FMI-LS-BUS.

Sources: FMI 3.0.2, FMI-LS-BUS 1.0.0. Value references are those of shell.c.
"""

from __future__ import annotations

from dataclasses import dataclass
from xml.sax.saxutils import quoteattr

from sim_backend.model import AntennaModel

IDENTIFIER = "gimbal_antenna"
BUS = "Can"
_MIME = "application/org.fmi-standard.fmi-ls-bus.can; version=&quot;1.0.0&quot;"
_FIRST_AXIS, _PER_AXIS = 16, 4
#: bytes of operations that one step can bring or take; an importer that asks for whole seconds gets more
_MAX_SIZE = 1 << 20
_HEAD = '<?xml version="1.0" encoding="UTF-8"?>\n'


@dataclass(frozen=True)
class FmuVariable:
    """A variable of the model description: XML element, name, value reference, attributes."""

    element: str
    name: str
    reference: int
    attributes: str

    @property
    def is_output(self) -> bool:
        """Whether it stands in the model structure too."""
        return 'causality="output"' in self.attributes

    def xml(self) -> str:
        """Its element; a binary input has a start, which is empty."""
        begin = f'    <{self.element} name={quoteattr(self.name)} valueReference="{self.reference}" {self.attributes}'
        with_start = self.element == "Binary" and not self.is_output
        return f'{begin}><Start value=""/></Binary>\n' if with_start else f"{begin}/>\n"


def variables_of(model: AntennaModel) -> tuple[FmuVariable, ...]:
    """Every variable of a model's FMU, in the order of its value references."""
    binary = f'variability="discrete" maxSize="{_MAX_SIZE}" mimeType="{_MIME}"'
    whole = 'causality="output" variability="discrete" initial="calculated"'
    found = [
        FmuVariable("Float64", "time", 0, 'causality="independent" variability="continuous" unit="s"'),
        FmuVariable("Binary", f"{BUS}.Rx_Data", 1, f'causality="input" clocks="3" {binary}'),
        FmuVariable("Binary", f"{BUS}.Tx_Data", 2, f'causality="output" initial="calculated" clocks="4" {binary}'),
        FmuVariable("Clock", f"{BUS}.Rx_Clock", 3, 'causality="input" intervalVariability="triggered"'),
        FmuVariable("Clock", f"{BUS}.Tx_Clock", 4, 'causality="output" intervalVariability="triggered"'),
        FmuVariable("Int64", "seed", 5, 'causality="parameter" variability="fixed" start="0"'),
        FmuVariable("Int64", "drive.state", 6, whole),
        FmuVariable("Int64", "drive.fault", 7, whole),
        FmuVariable("Int64", "drive.bad_frames", 8, whole),
    ]
    length, force = ("m", "N") if model.is_linear else ("rad", "N.m")
    units = {"position": length, "rate": f"{length}/s", "torque": force, "temperature": "degC"}
    for index, axis in enumerate(model.axes):
        for place, (name, unit) in enumerate(units.items()):
            kind = f'causality="output" variability="continuous" initial="calculated" unit="{unit}"'
            found.append(FmuVariable("Float64", f"{axis}.{name}", _FIRST_AXIS + _PER_AXIS * index + place, kind))
    return tuple(found)


def model_description(model: AntennaModel, token: str, rate_hz: float, made_by: str) -> str:
    """modelDescription.xml."""
    variables = variables_of(model)
    outputs = "".join(f'    <Output valueReference="{one.reference}"/>\n' for one in variables if one.is_output)
    # what a clock brings is unknown only when it ticks
    unknown = "".join(
        f'    <InitialUnknown valueReference="{one.reference}"/>\n'
        for one in variables
        if one.is_output and "clocks=" not in one.attributes
    )
    return (
        f'{_HEAD}<fmiModelDescription fmiVersion="3.0" modelName={quoteattr(model.name)} '
        f'instantiationToken="{token}" variableNamingConvention="flat"\n'
        f"    description={quoteattr(_DESCRIPTION)}\n    generationTool={quoteattr(made_by)}>\n"
        f'  <CoSimulation modelIdentifier="{IDENTIFIER}" hasEventMode="true" canGetAndSetFMUState="true"\n'
        f'      canSerializeFMUState="true" canHandleVariableCommunicationStepSize="true"/>\n'
        f"  <UnitDefinitions>\n{_UNITS}  </UnitDefinitions>\n"
        f'  <DefaultExperiment startTime="0" stopTime="10" stepSize="{1.0 / rate_hz:.12g}"/>\n'
        f"  <ModelVariables>\n{''.join(one.xml() for one in variables)}  </ModelVariables>\n"
        f"  <ModelStructure>\n{outputs}{unknown}  </ModelStructure>\n</fmiModelDescription>\n"
    )


_DESCRIPTION = (
    "Virtual antenna with the firmware of its drives: CAN frames in, CAN frames out, one set a tick. Positions, rates "
    "and torques are the true ones, for plots."
)
_UNITS = "".join(
    f'    <Unit name="{name}"><BaseUnit{parts}/></Unit>\n'
    for name, parts in (
        ("s", ' s="1"'),
        ("rad", ' rad="1"'),
        ("rad/s", ' rad="1" s="-1"'),
        ("N.m", ' kg="1" m="2" s="-2"'),
        ("m", ' m="1"'),
        ("m/s", ' m="1" s="-1"'),
        ("N", ' kg="1" m="1" s="-2"'),
        ("degC", ' K="1" offset="273.15"'),
    )
)


def terminals() -> str:
    """terminalsAndIcons/terminalsAndIcons.xml: the bus, as a plug that importers connect by its members."""
    members = "".join(
        f'      <TerminalMemberVariable variableKind="signal" variableName="{BUS}.{name}" memberName="{name}"/>\n'
        for name in ("Tx_Data", "Tx_Clock", "Rx_Data", "Rx_Clock")
    )
    return (
        f'{_HEAD}<fmiTerminalsAndIcons fmiVersion="3.0">\n  <Terminals>\n'
        f'    <Terminal name="{BUS}" terminalKind="org.fmi-ls-bus.network-terminal" '
        f'matchingRule="org.fmi-ls-bus.transceiver">\n{members}'
        "    </Terminal>\n  </Terminals>\n</fmiTerminalsAndIcons>\n"
    )


def manifest() -> str:
    """extra/org.fmi-standard.fmi-ls-bus/fmi-ls-manifest.xml."""
    return (
        f'{_HEAD}<fmiLayeredStandardManifest xmlns:fmi-ls="http://fmi-standard.org/fmi-ls-manifest"\n'
        '    fmi-ls:fmi-ls-name="org.fmi-standard.fmi-ls-bus" fmi-ls:fmi-ls-version="1.0.0"\n'
        '    fmi-ls:fmi-ls-description="Network abstraction (low cut) of a CAN bus" isBusSimulationFMU="false"/>\n'
    )
