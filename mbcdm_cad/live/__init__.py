"""One warm process that follows a design file: new checks, parts and page after every save."""
