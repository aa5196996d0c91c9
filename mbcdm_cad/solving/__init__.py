"""Looking for the nearest design that passes every check: what may move, how far a trial fails, search, conflicts.

``scipy`` is imported where a search needs it; a design that passes as it is never does.
"""
