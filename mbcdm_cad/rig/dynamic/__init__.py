"""The dynamic rig: motors under position loops, gearheads, cables and a load, integrated over time."""
