"""A small layout for the tests: one input and a drum on parallel axes, two crossed cables.

It shows what a layout must supply, and that no other file has to change; its parts are boxes and cylinders. Frame: the
drum's axis is Y, the input is at x = +L with its axis along -Y, so that both turn in the same sense.
"""
