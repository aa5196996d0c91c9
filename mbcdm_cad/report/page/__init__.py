"""``report.html``: one self-contained page with the drive in 3D, its checks, figures, plots and lists."""

PAGE = "report.html"
