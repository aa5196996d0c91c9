"""What a drive does all day, and what its motors' windings and housings heat up to by it."""
