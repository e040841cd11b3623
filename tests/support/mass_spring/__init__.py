"""A mass on a spring: the smallest slave that uses all of ``rail_fmi``."""
