"""Fills a surface by fTetWild: reads `in.bin` (two counts, points, triangles), writes `out.bin` (two counts, points, tets)."""
import ctypes
import mmap
import platform
import sys

# On Linux it ends with its parent.
try:
    ctypes.CDLL(None).prctl(1, 9)
except Exception:
    pass

# Machine code of a function that returns 1.
RETURN_ONE = {
    "x86_64": b"\xb8\x01\x00\x00\x00\xc3",
    "aarch64": b"\x20\x00\x80\x52\xc0\x03\x5f\xd6",
}


def draw_the_same_numbers():
    """fTetWild shuffles the triangles by a generator seeded from `std::random_device`, and takes no seed: without this, two runs give two fillings, of which
    one may take four times as long. Here the device of this process, which does nothing else, gives the same number always."""
    library = ctypes.CDLL("libstdc++.so.6")
    draw = library._ZNSt13random_device9_M_getvalEv
    start = ctypes.cast(draw, ctypes.c_void_p).value
    page = start // mmap.PAGESIZE * mmap.PAGESIZE
    code = RETURN_ONE[platform.machine()]
    length = start + len(code) - page
    system = ctypes.CDLL(None)
    every = mmap.PROT_READ | mmap.PROT_WRITE | mmap.PROT_EXEC
    if system.mprotect(ctypes.c_void_p(page), ctypes.c_size_t(length), every) == 0:
        ctypes.memmove(start, code, len(code))
        system.mprotect(ctypes.c_void_p(page), ctypes.c_size_t(length), mmap.PROT_READ | mmap.PROT_EXEC)


# Where it cannot be done the fillings differ a little from run to run, and are as good.
try:
    draw_the_same_numbers()
except Exception:
    pass

import numpy as np
import pytetwild

edge, envelope, energy = (float(a) for a in sys.argv[1:4])
passes = int(sys.argv[4])
with open("in.bin", "rb") as f:
    n, m = (int(c) for c in np.fromfile(f, "<u8", 2))
    points = np.fromfile(f, "<f8", 3 * n).reshape(-1, 3)
    triangles = np.fromfile(f, "<u4", 3 * m).reshape(-1, 3)
points, tets = pytetwild.tetrahedralize(
    points,
    triangles.astype(np.int32),
    edge_length_fac=edge,
    epsilon=envelope,
    stop_energy=energy,
    num_opt_iter=passes,
    num_threads=1,
    quiet=True,
)
with open("out.bin", "wb") as f:
    np.array([len(points), len(tets)], "<u8").tofile(f)
    points.astype("<f8").tofile(f)
    tets.astype("<u4").tofile(f)
