"""What the declared model lacks: measured run, residual, candidates fitted and judged, error before and after."""
