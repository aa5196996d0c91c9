"""Plan a run before it is made: what it could find, the best run of a bench, the next run after a loop."""
