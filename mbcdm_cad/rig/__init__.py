"""The test rig in software: physics of the drive that shares the design file with the analytic model and nothing else."""

from __future__ import annotations
