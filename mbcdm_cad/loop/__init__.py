"""The loop: measured run, residual, the effect that the model lacks, error before and after on held-out data."""
