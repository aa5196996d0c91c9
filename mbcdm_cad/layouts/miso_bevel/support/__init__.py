"""Frame and top plate: dimensions, drawing, deflection."""
