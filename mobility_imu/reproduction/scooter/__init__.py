"""Suzurikawa et al. 2022: the static test, the fit of Table 1, the driving test."""
