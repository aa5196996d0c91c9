"""The page of the loop: one HTML file with the finding in plain words, charts and pictures."""
