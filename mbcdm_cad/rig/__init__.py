"""The test rig in software: a simulated bench whose physics uses none of the analytic model's equations or code."""
