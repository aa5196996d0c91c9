"""The analytic model: pure numpy, SI inside, from a :class:`~mbcdm_cad.design.drive.Drive` to its figures.

``analysis.analyse`` gives all figures of the report; functions for single questions are in the module of the subject.
"""
