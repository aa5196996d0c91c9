"""Workshop drawings: DXF with real dimensions, and the same document as SVG and PDF.

The engine is independent of the parts: the content of a sheet is plain data in the part's folder
(``parts/<part>/sheet.py``).
"""
