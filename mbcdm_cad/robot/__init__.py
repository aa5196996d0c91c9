"""The drive as a mechanism for robot simulators: links with mass and inertia, joints with ratios; URDF and MJCF."""
