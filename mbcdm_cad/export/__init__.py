"""The folder that a build's files are put into at one stroke, and its manifest."""
