"""The virtual antenna as an FMU (FMI 3.0 co-simulation), which needs no Python where it runs."""

from sim_backend.fmu.package import fmu_of
from sim_backend.fmu.tick import library_is_kept

__all__ = ["fmu_of", "library_is_kept"]
