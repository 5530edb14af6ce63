"""Pedestrian-trajectory prediction: the iterative-attention model, its training and its use.

Importing the package loads nothing heavy; take what you need from its modules, `forecaster` first.
"""
