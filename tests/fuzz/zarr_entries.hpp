// A Zarr hierarchy as one input of the fuzz target: entries of a byte that chooses the key, two bytes with the size of
// the value (little-endian), and the value. The last value ends with the input.
#pragma once

#include <array>
#include <string_view>

namespace isoextract::fuzz {

inline constexpr std::array<std::string_view, 24> kZarrKeys{"zarr.json",
                                                            ".zarray",
                                                            ".zgroup",
                                                            ".zattrs",
                                                            ".zmetadata",
                                                            "0.0.0",
                                                            "0.0.1",
                                                            "0/0/0",
                                                            "c/0/0/0",
                                                            "c/0/0/1",
                                                            "0/zarr.json",
                                                            "0/.zarray",
                                                            "0/.zattrs",
                                                            "0/c/0/0/0",
                                                            "0/0.0.0",
                                                            "0/0/0/0",
                                                            "labels/zarr.json",
                                                            "labels/.zgroup",
                                                            "labels/a/zarr.json",
                                                            "labels/a/.zgroup",
                                                            "labels/a/.zattrs",
                                                            "x/zarr.json",
                                                            "x/c/0",
                                                            "1/zarr.json"};

}  // namespace isoextract::fuzz
