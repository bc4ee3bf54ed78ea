"""The virtual antenna for a script: a model, a configuration and a seed; experiments on it are runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from gimbal_hil.loop.settings import DaemonSettings, load_settings, shipped_settings
from gimbal_hil.surface.library.run import Run
from gimbal_hil.surface.library.sources import model_of
from sim_backend.model import AntennaModel


@dataclass(frozen=True)
class Antenna:
    """An antenna in virtual time, controlled through its frames like a real one. Without arguments the shipped one.

    `model`: a model, its file, or the name of a shipped one; without it the one that the configuration names.
    `config`: a configuration file. `seed`: of the sensors' noise.
    """

    model: AntennaModel
    settings: DaemonSettings = field(repr=False)
    seed: int = 0

    def __init__(
        self,
        model: str | Path | AntennaModel | None = None,
        config: str | Path | DaemonSettings | None = None,
        seed: int | None = None,
    ) -> None:
        from gimbal_hil.knowledge.experiments import embedded_model_of

        if isinstance(config, DaemonSettings):
            settings = config
        else:
            settings = load_settings(Path(config)) if config else shipped_settings()
        if model is None:
            named, own_seed = embedded_model_of(settings)
        else:
            named, own_seed = model_of(model), 0
        object.__setattr__(self, "model", named)
        object.__setattr__(self, "settings", settings.for_axes(named.axes, named.where))
        object.__setattr__(self, "seed", own_seed if seed is None else seed)

    @property
    def axes(self) -> tuple[str, ...]:
        """Names of the axes, the carrying one first."""
        return self.model.axes

    def with_effect(self, name: str, axis: str, **parameters: float) -> Antenna:
        """The same antenna with one more effect (`gimbal-hil effects` lists them), in the units of the catalogue."""
        return Antenna(self.model.with_effect(name, axis, parameters), self.settings, self.seed)

    def experiment(
        self, name: str, out: str | Path, *, short: bool = False, axes: Sequence[str] | None = None, force: bool = False
    ) -> Run:
        """Run a sequence (`gimbal-hil experiment --help` lists them) or a plan file, in virtual time, into a run
        folder.
        """
        from gimbal_hil.knowledge.experiments import conduct
        from gimbal_hil.knowledge.experiments.sequences import SequenceOptions, breakaway_torques, build_experiment

        names = self.settings.axis_names
        options = SequenceOptions(
            self.settings.rate_hz,
            tuple(axes or names),
            short=short,
            breakaway_nm=breakaway_torques(self.model),
            names=names,
        )
        folder = Path(out)
        conduct(build_experiment(name, options), self.settings, self.model, self.seed, folder, force=force)
        return Run(folder)
