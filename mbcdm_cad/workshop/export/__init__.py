"""Write solids and meshes as files and pictures (STEP, STL, GLB, PNG), independent of any mechanism."""
