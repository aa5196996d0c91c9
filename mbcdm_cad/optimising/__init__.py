"""The best designs for two or more wishes: free fields, figures, a search that can be interrupted, the front.

``pymoo`` proposes points, this package sizes and checks them and keeps each in a file. A search that goes on repeats
the proposals from the start and takes the results from this file, so that it ends with the same bytes.
"""
