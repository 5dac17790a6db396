"""Simulators: a known motion, the recording that sensors would make of it, and the truth.

They share only the devices' geometry with the estimators, never an equation of theirs.
"""
