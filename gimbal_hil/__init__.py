"""The controller service: control, daemon, runs, experiments, identification, discrepancy."""

import os

# The last bits of a matrix product depend on how many threads share it, and on small matrices threads only wait for one
# another: one thread everywhere gives the same answers on every executor. It has to be said before numpy is loaded; the
# user's word stands.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("MKL_NUM_THREADS", "1")

__version__ = "0.1.0"

__all__ = ["__version__"]
