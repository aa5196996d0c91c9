"""Run many: independent work on the cores of this machine, by forks, or on other machines, by a cluster."""
