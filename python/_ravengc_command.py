"""The command ``ravengc`` before anything of the package is there: quiet under Ctrl-C from its first line on.

It stands beside the package, not in it, because Python imports a package before what is in it.
"""

import sys


def main() -> int:
    """Import and run :func:`ravengc.cli.main`; 130 after Ctrl-C on the way, 2 where the package refuses its setting."""
    try:
        from ravengc.cli import main as command
    except KeyboardInterrupt:
        return 130
    except ValueError as error:  # the package's own, about RAVENGC_LEVEL
        if sys.stderr is not None:
            sys.stderr.write(f"ravengc: error: {error}\n")
        return 2
    return command()
