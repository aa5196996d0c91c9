"""The quasi-static rig: every torque balances at each sample."""
