"""What lies on the disk: cache and keys, files and folders that appear whole or not at all; and work on all cores."""
