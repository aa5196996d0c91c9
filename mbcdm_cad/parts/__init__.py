"""The parts, one a file, one public function each: dimensions in, one valid solid out. Only here is geometry drawn.

Threads follow one convention everywhere: outside and inside threads are plain cylinders at the nominal diameter.
Frames: the drum and all that is fixed to the frame are drawn where they stand with the drum centred; input pulleys
about their own axis; bought parts along +Z from the face they are mounted by.
"""
