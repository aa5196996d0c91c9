"""The parts, one folder each: ``dims.py`` with dimensions, ``draw.py`` with one function that draws the solid.

All threads, external and internal, are drawn as plain cylinders at the nominal diameter. Coordinates: the drum and all
parts fixed to the frame are drawn in their place in the assembly, drum centred; input pulleys about their own axis;
bought parts along +Z from their mounting face.
"""
