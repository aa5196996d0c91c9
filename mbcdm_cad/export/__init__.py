"""From solids to files: STEP, STL, GLB, pictures, mass properties, and the folder they are put into at one stroke.

Knows nothing of any mechanism. What needs the kernel is imported by module, so that the folder, the manifest and the
mass sums cost no kernel import.
"""
