"""The docs as a site that needs no network: ``make docs-site`` writes it to out/site."""

project = "mbcdm_cad"
extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
html_theme = "furo"
html_title = "mbcdm_cad"
html_copy_source = False
html_show_sphinx = False
# Headings can be linked to as on the web pages of code hosts.
myst_heading_anchors = 3
# Notebooks are shown as they stand; a test runs them.
nb_execution_mode = "off"
autodoc_member_order = "bysource"
autodoc_typehints = "description"
# Types that the API imports for type checkers only are shown by their names.
nitpicky = False
