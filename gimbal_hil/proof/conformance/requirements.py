"""The requirements on an antenna's firmware as `requirements.yaml` has them, checked like every document."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from firmware_protocol.documents import Strict, read_yaml, validated
from firmware_protocol.enumerations import DriveRequest, DriveState

REQUIREMENTS_FILE = Path(__file__).with_name("requirements.yaml")

#: groups in the order of the file, by the letter of their numbers
GROUPS = {
    "W": "The wire",
    "F": "Feedback",
    "I": "Identity",
    "S": "Drive states",
    "D": "Deadman",
    "T": "Torque",
}


class Requirement(Strict):
    """One thing that firmware must do, with the limits that its check holds it to."""

    id: Annotated[str, Field(pattern=r"^[A-Z]-\d\d$")] = Field(description="number, which never changes its meaning")
    check: str = Field(description="function that checks it")
    title: str = Field(description="what must be, in one sentence")
    why: str = Field(description="what goes wrong otherwise")
    limits: dict[str, float] = Field(default_factory=dict, description="numbers that the check compares with")
    moves: bool = Field(default=False, description="the check applies torque for some ticks")
    optional: bool = Field(default=False, description="firmware may leave it out")
    transitions: dict[str, dict[str, str]] = Field(
        default_factory=dict, description="of the table of states: state, request, where that leads"
    )

    @property
    def group(self) -> str:
        """Heading under which it stands."""
        return GROUPS[self.id[0]]

    def destination(self, state: DriveState, request: DriveRequest) -> DriveState:
        """Where a request leads from a state; the state itself where the table has no line."""
        name = self.transitions.get(state.name, {}).get(request.name)
        return state if name is None else DriveState[name]


class _File(Strict):
    schema_: Literal[1] = Field(alias="schema")
    requirements: tuple[Requirement, ...]


@cache
def shipped_requirements() -> tuple[Requirement, ...]:
    """All requirements in the order of their file; BadInputError names the key that is wrong."""
    document = read_yaml(REQUIREMENTS_FILE, "requirements")
    return validated(_File, document, str(REQUIREMENTS_FILE)).requirements
