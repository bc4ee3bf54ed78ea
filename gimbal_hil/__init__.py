"""The controller service: control, daemon, runs, experiments, identification, discrepancy."""

__version__ = "0.1.0"
