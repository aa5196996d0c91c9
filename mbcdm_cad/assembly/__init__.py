"""The parts put in their places at a given drum angle, as numbers and as solids."""
