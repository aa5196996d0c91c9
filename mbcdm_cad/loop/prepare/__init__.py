"""Make a measured run ready for the model: smooth, cut, hold back, simulate; find the noise floor of its residual."""
