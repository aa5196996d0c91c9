"""What ``build`` does: draws parts, looks for interference, writes files; takes from the cache what has not changed."""
