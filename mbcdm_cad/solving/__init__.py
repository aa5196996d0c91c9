"""Find the nearest design that passes every check: free fields, evaluation of a trial, search, conflicts.

``scipy`` is imported only when a search needs it; a design that already passes does not.
"""
