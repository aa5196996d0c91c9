"""``report.html``: one self-contained page with the drive in 3D, its checks, figures, plots and lists."""

from mbcdm_cad.report.page.page import report_page
from mbcdm_cad.report.page.scene import Scene, design_scene
from mbcdm_cad.report.page.studies import studies

__all__ = ["Scene", "design_scene", "report_page", "studies"]
