"""Paths of the fields of a design file that code names: ``at.drum.bearing`` is ``"drum.bearing"``, others raise."""

from types import SimpleNamespace

_FIELDS = """
clearances: land_edge_mm running_mm transfer_gap_mm
drive: bus_voltage_V drum_encoder encoder gearhead gearhead_angle_deg motor motor_side
drum: bearing hub_diameter_mm hub_face_y_mm material outer_face_y_mm output_circle_mm output_screws
  rim_inner_radius_mm sector_half_angle_deg shaft_bore_mm shaft_end_mm shaft_material spring stop_pin_mm tensioner
  web_thickness_mm windows
guide: axle_material bearing material
input_pulleys: carried_by collar_screw lower_bearing material surface upper_bearing
limits: bend_ratio_min fleet_angle_grooved_max_deg fleet_angle_max_deg losses preload_share_max slip_margin_min
  tension_safety_factor
loads: backdrive_Nm continuous_torque_Nm duty payload peak_torque_Nm speed_deg_s stiffness_Nm_rad structure_share
  test_torque_Nm
printing: nozzle_mm threads
rope: dead_turns friction_coefficient helix_lead_mm inline modulus_area modulus_GPa preload_N termination type
support: back_plate_mm back_y_mm bearing_shelf_mm bridge_mm coupling_space_mm encoder_shelf_mm material motor_shelf_mm
  mount_screw plate_mm rib_mm side_wall_mm top_plate_mm
targets: envelope_mm life_cycles life_h
transmission: cables centre_distance_mm drum_radii_mm drum_radius_mm guide_radii_mm input_radii_mm input_radius_mm
  input_setback_mm input_to_drum parallel ratio ratios reserve_deg spans turns
travel: from_deg half_angle_deg stop_clearance_deg to_deg"""
_BLOCKS = (line.split(": ") for line in _FIELDS.replace("\n  ", " ").split("\n")[1:])
at = SimpleNamespace(
    **{block: SimpleNamespace(**{f: f"{block}.{f}" for f in names.split()}) for block, names in _BLOCKS}
)
