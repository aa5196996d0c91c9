"""The layouts of a drive, one folder each, found by the registry. No other room names one of them."""
