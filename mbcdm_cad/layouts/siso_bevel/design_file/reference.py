"""The reference design of siso_bevel: motor, gearhead, rope, preload, mean drum radius and travel as in miso_bevel.

"Table", "section" and "Fig." are those of the paper that describes the mechanism.
"""

from __future__ import annotations

from mbcdm_cad.design.design_file import Given
from mbcdm_cad.design.fields import ESTIMATE

LIKE_D = "as the reference of miso_bevel"

INPUTS = [{"name": "main"}]
CABLES = [
    {"name": "cable_1", "input": "main", "step": 1, "drum_side": "+x"},
    {"name": "cable_2", "input": "main", "step": 2, "drum_side": "-x"},
]

SHARED = {
    "schema_version": Given(1),
    "name": Given("siso_bevel"),
    "travel.half_angle_deg": Given(35.0, LIKE_D),
    "travel.stop_clearance_deg": Given(0.25, LIKE_D),
    "rope.type": Given("FF-081", "Table 1"),
    "rope.modulus_GPa": Given(54.0, LIKE_D),
    "rope.modulus_area": Given("metallic", "goes with modulus_GPa"),
    "rope.friction_coefficient": Given(0.15, "section 4.2"),
    "rope.preload_N": Given(70.0, "section 5.3"),
    "rope.cut_tolerance_mm": Given(0.5, "estimate: both ends swaged by hand against a jig"),
    "clearances.transfer_gap_mm": Given(0.155, LIKE_D),
    "clearances.land_edge_mm": Given(0.15, LIKE_D),
    "clearances.running_mm": Given(0.25, ESTIMATE),
    "drive.motor": Given("motor-2.9mNm-15", "section 4.1"),
    "drive.gearhead": Given("gearhead-76-16", "section 4.1"),
    "drive.encoder": Given("encoder-17", "section 5"),
    "drive.drum_encoder": Given("encoder-24-ring", "section 4.1"),
    "drum.material": Given("aluminium-7075", ESTIMATE),
    "drum.sector_half_angle_deg": Given(82.5, "terminals clear the input at the ends of the travel"),
    "drum.rim_inner_radius_mm": Given(51.0, ESTIMATE),
    "drum.outer_face_y_mm": Given(15.7, "behind it are the nuts of the terminals"),
    "drum.web_thickness_mm": Given(2.0, ESTIMATE),
    "drum.hub_diameter_mm": Given(20.0, ESTIMATE),
    "drum.hub_face_y_mm": Given(24.7, "space for set screws and payload threads before the web"),
    "drum.bearing": Given("618/8", ESTIMATE),
    "drum.shaft_bore_mm": Given(4.0, ESTIMATE),
    "drum.shaft_material": Given("steel", ESTIMATE),
    "drum.tensioner": Given("M1.6", "section 4.1: turnbuckles"),
    "input_pulleys.material": Given("steel", ESTIMATE),
    "input_pulleys.lower_bearing": Given("618/5", ESTIMATE),
    "input_pulleys.upper_bearing": Given("618/4", ESTIMATE),
    "loads.test_torque_Nm": Given(0.28, "0.29 of the peak torque, as in miso_bevel"),
    "loads.peak_torque_Nm": Given(0.98, "motor with gearhead: 0.992"),
    "limits.bend_ratio_min": Given(28.0, "the rope's own minimum"),
    "limits.tension_safety_factor": Given(5.0, "rope makers: 5 to 10"),
    "limits.preload_share_max": Given(0.5, "rope makers: under half"),
    "limits.frame_windup_max_mrad": Given(0.0095, "a choice: below the windup of the cables, 0.012 to 0.045 mrad"),
    "limits.losses": Given("paper", "the paper counts none"),
    "making.rope_diameter_share": Given(0.03, LIKE_D),
    "making.run_out_mm": Given(0.02, LIKE_D),
    "making.bearing_play_mm": Given(0.008, LIKE_D),
    "making.position_mm": Given(0.02, LIKE_D),
    "printing.hole_allowance_mm": Given(0.2, LIKE_D),
    "printing.nozzle_mm": Given(0.4, LIKE_D),
    "printing.threads": Given("cut", LIKE_D),
    "targets.mass_g": Given(251.0, "as drawn"),
    "targets.mass_tolerance_g": Given(10.0, "project goal"),
    "targets.envelope_mm": Given([119.5, 135.2, 42.0], "as drawn"),
    "targets.envelope_tolerance_mm": Given(0.5, "project goal"),
    "export.mesh_tolerance_mm": Given(0.01, "project goal"),
}
