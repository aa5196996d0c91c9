"""The quasi-static rig: all torques are in equilibrium at each sample."""
