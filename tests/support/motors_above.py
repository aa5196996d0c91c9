"""A short design file with motors above the top plate."""

ABOVE = """
name: above
configuration: miso_bevel
travel: {half_angle_deg: 35.0}
transmission: {ratio: 9.0, drum_radius_mm: 54.0}
loads: {peak_torque_Nm: 3.15}
drive: {motor_side: above}
"""
