#!/usr/bin/python3
"""Writes src/edit/colormap_tables.cpp: color maps of matplotlib as control points.

    scripts/colormaps.py > src/edit/colormap_tables.cpp

Each map becomes colors at equal distances, with straight lines between them in sRGB. A comment in the output states the
greatest difference of a channel from the full map of 256 colors. Needs Debian's package python3-matplotlib, and runs
with Debian's own python3. The build needs neither: the repository has the tables.
"""

import matplotlib
import numpy

NAMES = ("viridis", "plasma", "magma", "inferno", "cividis", "turbo", "coolwarm", "gray")
POINTS = 86  # on every third of the full map
A_LINE = 11

HEAD = """// Written by scripts/colormaps.py from matplotlib {version}: change that and not this.
//
// viridis, plasma, magma and inferno: Nathaniel Smith, Stefan van der Walt and (viridis) Eric Firing, in the public
// domain (CC0).
// cividis: Nunez, Anderton and Renslow, "Optimizing colormaps with consideration for color vision deficiency", 2018.
// turbo: Anton Mikhailov, Google, 2019 (Apache 2.0).
// coolwarm: Kenneth Moreland, "Diverging color maps for scientific visualization", 2009.
#include "edit/colormap.hpp"

namespace isoextract::edit {{
namespace {{

using Points = std::array<std::uint32_t, kColormapPoints>;  // 0xRRGGBB, sRGB
"""


def lines():
    places = numpy.linspace(0, 1, POINTS)
    full = numpy.linspace(0, 1, 256)
    yield HEAD.format(version=matplotlib.__version__)
    for name in NAMES:
        colors = matplotlib.colormaps[name](numpy.arange(256))[:, :3]
        points = [numpy.interp(places, full, colors[:, c]) for c in range(3)]
        bytes_ = numpy.rint(255 * numpy.array(points)).astype(int)
        error = max(numpy.abs(numpy.interp(full, places, bytes_[c] / 255) - colors[:, c]).max() for c in range(3))
        yield f"// Within {255 * error:.2f} of 255 of the full map."
        yield f"constexpr Points k{name.capitalize()}{{"
        words = [f"0x{r:02X}{g:02X}{b:02X}" for r, g, b in bytes_.T]
        for first in range(0, POINTS, A_LINE):
            yield "    " + ", ".join(words[first:first + A_LINE]) + ("," if first + A_LINE < POINTS else "};")
        yield ""
    yield "}  // namespace"
    yield ""
    yield "const std::array<std::uint32_t, kColormapPoints>& colormap_points(Colormap map) {"
    yield "  switch (map) {"
    for name in NAMES[1:]:
        yield f"    case Colormap::{name}: return k{name.capitalize()};"
    yield "    case Colormap::viridis: break;"
    yield "  }"
    yield "  return kViridis;"
    yield "}"
    yield ""
    yield "}  // namespace isoextract::edit"


if __name__ == "__main__":
    print("\n".join(lines()))
