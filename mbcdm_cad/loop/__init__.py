"""The loop: find the effects that the declared model lacks, by fitting candidates to the residual of measured runs."""
