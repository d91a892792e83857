"""Volumes larger than the address space (ulimit -v): the program maps some layers at a time, and writes the same bytes."""

import math
import resource
import struct

from support import ProgramTest, main

MIB = 1 << 20
DIMS = (224, 192, 256)
RAW = ("--dims", "224,192,256", "--dtype", "f32")
ISO = ("--iso", "0.1")


class AddressSpaceTest(ProgramTest):
    def setUp(self):
        super().setUp()
        self.write_waves("waves.raw", DIMS)

    def write_waves(self, name, dims, layers_alike=1):
        """Float samples of smooth waves that differ along each axis."""
        rows = {phase: struct.pack(f"<{dims[0]}f", *(math.sin(0.21 * x + phase / 40) for x in range(dims[0])))
                for phase in range(97)}
        with (self.folder / name).open("wb") as file:
            for z in range(dims[2]):
                for y in range(dims[1]):
                    file.write(rows[(3 * y + 5 * (z // layers_alike) + (y * z) // 64) % 97])

    @staticmethod
    def limited(mib):
        def limit():
            resource.setrlimit(resource.RLIMIT_AS, (mib * MIB, mib * MIB))
        return {"preexec_fn": limit}

    def least(self):
        """Address space in MiB that suffices for a conversion of few samples, but not for the file of waves, 42 MiB."""
        self.write_waves("small.raw", (16, 16, 16))
        small = ("small.raw", "--dims", "16,16,16", "--dtype", "f32", *ISO, "--threads", "2", "-o", "small.ply")
        for mib in range(20, 400, 10):
            if self.run_program(*small, **self.limited(mib)).code == 0:
                return mib + 26
        raise AssertionError("no limit suffices")
