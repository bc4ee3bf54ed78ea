"""The virtual antenna as an FMU (FMI 3.0 co-simulation), which needs no Python where it runs."""

from sim_backend.fmu.package import fmu_of

__all__ = ["fmu_of"]
