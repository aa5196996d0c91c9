"""The parts, each one class with its dimensions, solid, volume and sheet, see ``part.py``.

All threads, external and internal, are drawn as plain cylinders at the nominal diameter. Coordinates: the drum and all
parts fixed to the frame are drawn in their place in the assembly, drum centred; input pulleys about their own axis;
bought parts along +Z from their mounting face.
"""
