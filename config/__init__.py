"""Shipped configuration: models, antennas, plans (data only)."""
