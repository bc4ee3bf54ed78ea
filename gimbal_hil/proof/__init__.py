"""Proof: what shows that the rest is true.

bench        speed figures and the fault matrix, each beside a reference
campaign     one experiment on many virtual antennas
conformance  numbered requirements on an antenna's firmware
thesis       the thesis' tables and figures, computed again

Stands on all of the above; the tests' own benches lie in tests/.
"""
