"""``python -m rail_cosim.cli``."""

from rail_cosim.cli import main

main()
