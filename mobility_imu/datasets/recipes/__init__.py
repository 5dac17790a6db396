"""Recipes: one module per data set, from the origin's files to canonical CSV.

Each has ``wanted(path)``, which tells what is needed of the origin, and ``convert(files, out)``,
which writes the data set and returns what was done.
"""
