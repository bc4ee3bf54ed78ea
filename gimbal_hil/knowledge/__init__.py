"""Knowledge: from experiments to a model that is right.

executor        independent work in processes or on a cluster
estimation      bounded fits, blocks, paired comparison of correlated rows
identification  friction from measured motion, with intervals
experiments     plans as data, the sequences that are shipped, the runner
model_exports   a model for other people's simulators
drive_tables    ripple and friction as tables for drives of other makes
tuning          gains for a model, with margins
discrepancy     where a model is wrong and what it lacks
change          what differs between two sets of logs
improvement     experiment, diagnose, correct, repeat

Sees signals tables, run folders and model files; never the antenna that made the data.
"""
