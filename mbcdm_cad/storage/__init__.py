"""Storage: cache and its keys, files and folders that are written completely or not at all; work on all cores."""
