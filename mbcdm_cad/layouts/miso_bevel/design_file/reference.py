"""The reference design of miso_bevel: values of the blocks that all configurations share, and their sources.

"Table", "section" and "Fig." are those of the journal paper of the mechanism.
"""

from __future__ import annotations

from mbcdm_cad.design.design_file import Given
from mbcdm_cad.design.fields import ESTIMATE

DERIVED = "derived from Tables 1 and 2"

INPUTS = [{"name": "left", "side": "-x"}, {"name": "right", "side": "+x"}]
CABLES = [
    {"name": "cable_1", "input": "left", "step": 1, "drum_side": "+x"},
    {"name": "cable_2", "input": "left", "step": 2, "drum_side": "-x"},
    {"name": "cable_3", "input": "right", "step": 3, "drum_side": "-x"},
    {"name": "cable_4", "input": "right", "step": 4, "drum_side": "+x"},
]

SHARED = {
    "schema_version": Given(1),
    "name": Given("mbcdm"),
    "travel.half_angle_deg": Given(35.0, "needed by the wrap left at both ends"),
    "travel.stop_clearance_deg": Given(0.25, "stops between 35.0 and 35.5"),
    "inputs.name": Given(source="Fig. 2"),
    "cables.name": Given(source="Fig. 2"),
    "cables.input": Given(source="Table 2"),
    "cables.preload_N": Given(source="section 5.3"),
    "rope.type": Given("FF-081", "Table 1"),
    "rope.modulus_GPa": Given(
        54.0, "calibrated: 0.33 mrad at 70 N and 0.91 N m read as the swing at a reversal; the paper prints no E"
    ),
    "rope.modulus_area": Given("metallic", "goes with modulus_GPa"),
    "rope.friction_coefficient": Given(0.15, "section 4.2"),
    "rope.preload_N": Given(70.0, "section 5.3"),
    "rope.helix_lead_mm": Given(0.87, f"{DERIVED}: 0.860 to 0.884 clears itself and keeps the fleet angle"),
    "rope.dead_turns": Given(1.0, ESTIMATE),
    "rope.cut_tolerance_mm": Given(0.5, "estimate: both ends swaged by hand against a jig"),
    "clearances.transfer_gap_mm": Given(0.155, DERIVED),
    "clearances.land_edge_mm": Given(0.15, DERIVED),
    "clearances.running_mm": Given(0.25, ESTIMATE),
    "drive.motor": Given("motor-2.9mNm-15", "section 4.1"),
    "drive.gearhead": Given("gearhead-76-16", "section 4.1"),
    "drive.encoder": Given("encoder-17", "section 5"),
    "drive.drum_encoder": Given("encoder-24-ring", "section 4.1"),
    "drum.material": Given("aluminium-7075", ESTIMATE),
    "drum.sector_half_angle_deg": Given(78.1, "derived from the 126 mm box: 77.1 to 79.2"),
    "drum.rim_inner_radius_mm": Given(47.0, ESTIMATE),
    "drum.outer_face_y_mm": Given(13.0, ESTIMATE),
    "drum.web_thickness_mm": Given(2.0, ESTIMATE),
    "drum.hub_diameter_mm": Given(20.0, ESTIMATE),
    "drum.hub_face_y_mm": Given(20.8, "derived from the 34.8 mm box"),
    "drum.bearing": Given("618/8", ESTIMATE),
    "drum.shaft_bore_mm": Given(4.0, ESTIMATE),
    "drum.shaft_material": Given("steel", ESTIMATE),
    "drum.tensioner": Given("M1.6", "section 4.1: turnbuckles"),
    "input_pulleys.material": Given("steel", ESTIMATE),
    "input_pulleys.lower_bearing": Given("618/5", ESTIMATE),
    "input_pulleys.upper_bearing": Given("618/4", ESTIMATE),
    "loads.test_torque_Nm": Given(0.91, "section 5.3"),
    "loads.peak_torque_Nm": Given(
        3.15, "with equal preloads both directions hold 3.19 at most; section 5.1 measured 3.3, perhaps in one only"
    ),
    "limits.bend_ratio_min": Given(14.8, "Table 1"),
    "limits.fleet_angle_max_deg": Given(1.5, "usual limit for smooth drums"),
    "limits.tension_safety_factor": Given(5.0, "rope makers: 5 to 10"),
    "limits.preload_share_max": Given(0.5, "rope makers: under half"),
    "limits.frame_windup_max_mrad": Given(0.0232, "a choice: a seventh of the cables' own turn there, 0.162 mrad"),
    "limits.losses": Given("paper", "the paper counts none"),
    "making.rope_diameter_share": Given(0.03, "estimate: makers of small ropes give a few per cent"),
    "making.run_out_mm": Given(0.02, "estimate: turned between centres or in one chucking"),
    "making.bearing_play_mm": Given(0.008, "ISO 5753-1, normal play of bores to 10 mm: 2 to 13 um"),
    "making.position_mm": Given(0.02, "estimate: bored and faced in one setting"),
    "printing.hole_allowance_mm": Given(
        0.2, "estimate: printers leave holes 0.1 to 0.3 narrow; print a gauge and measure it"
    ),
    "printing.nozzle_mm": Given(0.4, "the usual nozzle"),
    "printing.threads": Given("cut", "a choice: nothing of the reference is printed"),
    "targets.mass_g": Given(350.0, "section 4.1"),
    "targets.mass_tolerance_g": Given(10.0, "project goal"),
    "targets.prototype_mass_g": Given(342.0, "section 5"),
    "targets.envelope_mm": Given([126.0, 97.0, 34.8], "section 4.1"),
    "targets.envelope_tolerance_mm": Given(0.5, "project goal"),
    "export.mesh_tolerance_mm": Given(0.01, "project goal"),
    "export.threads": Given("major", "a choice: the assembly then shows screws that fit"),
}
