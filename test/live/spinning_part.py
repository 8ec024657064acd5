"""A part of a warehouse that never comes to its end by itself, in one of several ways."""

from __future__ import annotations

import ctypes
import mmap
import sys
from collections.abc import Sequence

from soup_live.domain import stay_on_this_machine
from soup_live.process import Live, exit_status

JUMP_TO_ITSELF = b"\xeb\xfe"  # x86-64, as native code that waits for ever in a busy loop
_page = mmap.mmap(-1, mmap.PAGESIZE, prot=mmap.PROT_READ | mmap.PROT_WRITE | mmap.PROT_EXEC)
_page.write(JUMP_TO_ITSELF)
ctypes.pythonapi.Py_IncRef(ctypes.py_object(_page))  # it is there to the last instruction
_place = ctypes.addressof(ctypes.c_char.from_buffer(_page))


def spin_in_static_destructors() -> None:
    """At the very end of the process, after Python's own end, spin."""
    ctypes.CDLL(None).on_exit(ctypes.c_void_p(_place), None)


def spin() -> None:
    """Spin in native code, and never let go of the interpreter."""
    ctypes.PYFUNCTYPE(None)(_place)()


def spin_in_python() -> None:
    """Spin as a policy could that has an endless loop."""
    while True:
        pass


def main(argv: Sequence[str]) -> int:
    """Be the part; the first word says where it spins, the second where it says that it is at work."""
    where, ready = argv
    return exit_status(lambda: run(where, ready))


def run(where: str, ready: str) -> None:
    """Join the graph, be at work, and end if told."""
    stay_on_this_machine()
    with Live("spinner") as live:
        live.node("spinner")
        if where == "static destructors":
            spin_in_static_destructors()
        elif where == "farewell":
            live.at_end(spin)
        with open(ready, "w") as file:
            file.write("at work")
        if where == "native callback":
            spin()
        elif where == "callback":
            spin_in_python()
        live.spin()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
