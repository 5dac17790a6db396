"""WheelMove-ID (v0): its sample, its tool's answers, its equations and tables."""
