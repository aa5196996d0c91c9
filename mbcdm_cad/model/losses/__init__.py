"""Friction between motor and payload: losses of each part, efficiency both ways, back-driving."""
