"""Classes that describe the drawing of a part, and the search for the sheet of a part."""
