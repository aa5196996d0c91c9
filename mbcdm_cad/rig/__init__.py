"""The test rig in software: physics of the drive that shares with the analytic model the design file, nothing else."""
