"""One stepped input pulley, straight onto the drum by a bevel transfer: Fig. 1 (c)."""
