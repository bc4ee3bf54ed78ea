"""Request and result of a search: everything from which verdict, model file and report are made."""

from __future__ import annotations

from dataclasses import dataclass, field

from gimbal_hil.data.signals import SignalsTable
from gimbal_hil.knowledge.discrepancy.inquiry import Inquiry, Noise, Policy, State
from gimbal_hil.knowledge.discrepancy.judgement.deciding import Decision, Told
from gimbal_hil.knowledge.discrepancy.judgement.smallest import Shows
from gimbal_hil.knowledge.discrepancy.laws import Described
from gimbal_hil.knowledge.discrepancy.search import Path
from sim_backend.model import AntennaModel


@dataclass(frozen=True)
class Request:
    """What is asked: a model, logs to search in, logs of another trajectory to judge on, and how."""

    model: AntennaModel
    measured: tuple[SignalsTable, ...]
    #: empty: the last of several logs judges, or the last third of the only one
    holdout: tuple[SignalsTable, ...] = ()
    #: end of the scored band, Hz; None: what the logs can have, narrower where the encoder drowns it
    band_hz: float | None = None
    #: names of effects that alone are searched, and that are not
    only: tuple[str, ...] = ()
    without: tuple[str, ...] = ()
    policy: Policy = field(default_factory=Policy)

    @property
    def limited(self) -> bool:
        """Whether some effects alone are searched."""
        return bool(self.only or self.without)


@dataclass(frozen=True)
class Result:
    """Everything that a verdict, a model file and a report are made from."""

    request: Request
    inquiry: Inquiry
    noise: Noise
    #: the model as its file has it, and with its known numbers refitted inside their uncertainty
    stated: State
    null: State
    decision: Decision
    path: Path
    #: there was no log of another trajectory
    suspected_only: bool
    #: only the hold-out has a gap: a part of it was fitted with the other logs, and the rest judged
    only_in_hold_out: bool = False
    #: every cause that these logs would have shown, from which size on
    smallest: tuple[Shows, ...] = ()
    #: numbers (effect, axis) of which these logs would not have shown that they are half or twice what they should be
    hidden: tuple[tuple[str, str], ...] = ()
    #: where no name fits: the laws that do
    described: Described | None = None

    @property
    def model(self) -> AntennaModel:
        """The model that was asked about."""
        return self.request.model

    @property
    def best(self) -> State:
        """The explanation that is told; the refitted model where none is."""
        return self.decision.state if self.described is None else self.described.state

    @property
    def under(self) -> Inquiry:
        """The logs as `best` is evaluated on them: under a model that has the laws, if any."""
        return self.inquiry if self.described is None else self.described.inquiry

    @property
    def told(self) -> tuple[Told, ...]:
        """The causes that are told."""
        return self.decision.told


__all__ = ["Request", "Result"]
