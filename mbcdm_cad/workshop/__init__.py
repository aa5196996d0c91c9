"""The work of ``mbcdm build``: draw parts, test interference, write files; unchanged results come from the cache."""
