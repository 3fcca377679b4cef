"""``python -m ravengc`` is the command ``ravengc``."""

import sys

from ravengc.cli import main

if __name__ == "__main__":
    sys.exit(main())
