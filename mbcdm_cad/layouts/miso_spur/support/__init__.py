"""The frame of this configuration: the drum's boss, and an arm with a yoke for each input."""
