"""The frame of this configuration: a plate with the drum's boss and a yoke over the input."""
