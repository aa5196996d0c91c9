"""The way of each cable through the drive: its pieces and what follows from them."""
