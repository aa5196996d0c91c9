"""The kinds of drive, one folder each, found by their registry. No room outside names one of them."""
