"""Search the effects that explain the residual: fit, select, exchange, judge, describe what is left."""
