"""``python -m ravengc`` is the command ``ravengc``."""

import sys

from _ravengc_command import main

if __name__ == "__main__":
    sys.exit(main())
