"""Backlash of the reference design over the centre distance: 1000 designs, one plot."""

import matplotlib.pyplot as plt
import numpy as np

import mbcdm_cad as mc

design = mc.reference_design()  # or mc.load("my_drive.yaml")
many = mc.analyse_many(design, {"transmission.centre_distance_mm": np.linspace(34.6, 60.0, 1000)})
plt.plot(many["transmission.centre_distance_mm"], many["reversal_swing_mrad"])
plt.xlabel("centre distance L, mm")
plt.ylabel("swing at a reversal, mrad")
plt.savefig("sweep.png")
print(many)
