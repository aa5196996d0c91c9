"""Workshop drawings: DXF with real dimensions, and SVG and PDF of the same document.

The engine is independent of the parts: the content of a sheet is plain data in the part's folder
(``parts/<part>/sheet.py``).
"""
