"""What scripts/measure runs: one module a measurement, and what they share. Python's standard library only."""
