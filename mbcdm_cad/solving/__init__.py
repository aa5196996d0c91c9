"""Find the nearest design that passes every check: what may change, how far a trial fails, search, conflicts.

``scipy`` is imported only when a search needs it; a design that already passes does not.
"""
