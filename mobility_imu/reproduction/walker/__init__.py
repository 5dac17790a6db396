"""Doan & Pham: the tables by their own arithmetic, and their experiments simulated."""
