"""One input beside the drum, and one cable round it with crossed spans to the drum: Fig. 1 (a)."""
