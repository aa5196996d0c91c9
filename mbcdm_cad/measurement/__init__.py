"""Read a measurement file and its data into a run in SI units, and examine the run for mistakes."""
