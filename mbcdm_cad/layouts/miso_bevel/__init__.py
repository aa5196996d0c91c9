"""Two inputs, a guide, and a bevel transfer to the drum: Fig. 1 (d)."""
