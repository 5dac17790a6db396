"""Figures: shared style, and one module per device."""
