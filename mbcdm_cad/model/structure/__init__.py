"""Compliance and strength of the parts between motor and payload, from plain dimensions."""
