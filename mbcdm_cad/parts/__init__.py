"""The parts, one folder each: ``dims.py`` with dimensions, ``draw.py`` with one function that draws the solid.

Threads follow one convention everywhere: outside and inside threads are plain cylinders at the nominal diameter.
Frames: the drum and all that is fixed to the frame are drawn where they stand with the drum centred; input pulleys
about their own axis; bought parts along +Z from the face they are mounted by.
"""
