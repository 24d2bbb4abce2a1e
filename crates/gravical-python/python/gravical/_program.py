"""The script `gravical` of the wheel: the program, as `cargo install gravical-cli` installs it."""

import signal
import sys

from . import _gravical


def main() -> None:
    # Python's handler waits for the interpreter, which waits for the program. What is ignored stays ignored.
    if signal.getsignal(signal.SIGINT) is not signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.exit(_gravical.program(["gravical", *sys.argv[1:]]))
