"""``mbcdm watch``: a running process that updates checks, parts and page after every save of a design file."""
