"""Sweeps of the basic model: running them, drawing them, and searching for what a figure leaves out."""
