"""Solids and meshes to files and pictures: STEP, STL, GLB, PNG. Knows nothing of any mechanism."""
