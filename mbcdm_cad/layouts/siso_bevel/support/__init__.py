"""Frame and motor head: dimensions, drawing, deflection."""
