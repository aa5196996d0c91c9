"""Workshop drawings: DXF with real dimensions, and SVG and PDF of the same document.

The engine knows no part. What a sheet shows is plain data beside the part's dimensions (``parts/<part>/sheet.py``).
"""
