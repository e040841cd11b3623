"""Build SingleWheelset.fmu into the folder given (default: here)."""

import sys
from pathlib import Path

from rail_fmi.builder import build_fmu

if __name__ == "__main__":
    out = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent
    script = Path(__file__).with_name("single_wheelset_fmu.py")
    print(build_fmu(script, ("rail_fmi", "rail_quantities"), out))
