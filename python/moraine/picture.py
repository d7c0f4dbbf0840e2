"""Pictures of a run, from Python (`draw`) and as a command.

    moraine picture RUN_DIR [--field speed|pressure|plastic_shear_strain|depth|rank] [--times 0,2,8] [--output DIR]    (or python -m moraine.picture)
"""
import sys

from .drawing import draw
from .picture_command import main

__all__ = ["draw", "main"]

if __name__ == "__main__":
    sys.exit(main())
