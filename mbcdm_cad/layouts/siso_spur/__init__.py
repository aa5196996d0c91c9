"""One input beside the drum, and one cable round it with crossed or open spans to the drum: Fig. 1 (a)."""
