"""Two to four inputs evenly round one drum, each with its own cable: Fig. 1 (b)."""
