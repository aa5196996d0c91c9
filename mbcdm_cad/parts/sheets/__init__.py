"""The words in which a part says what its drawing shows, and how the sheet of a part is found."""
