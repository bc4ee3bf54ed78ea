"""Data: what was recorded or measured, whoever measured it.

runs       run folders: write while running, read in any state, seal, replay
tables     tables of text, Parquet and numpy as they stand: separators, headers, marks in numbers, units
containers  formats of others: bags, MCAP, ULog, MF4, MATLAB, CAN recordings, workbooks, JSON
signals    the signals table: of run folders, tables and containers, checked when read
arms       one joint of an arm: what the others do to it, by a URDF
exports    a run in other formats, with the same signal names in all
catalogue  recorded runs: list, show, compare
preflight  questions to a log before it is believed

Needs no running antenna and no effect; knowledge begins where a log has been questioned.
"""
