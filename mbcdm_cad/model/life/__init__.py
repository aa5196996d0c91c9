"""Life of the cables: bendings of each zone, and how many of them a rope stands."""
