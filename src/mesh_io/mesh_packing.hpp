// How meshes are packed into fewer bytes, and what that did to them.
//
// Positions that are quantised lie on one lattice: the multiples of a step, a power of two, in the coordinates of the
// output, wherever a mesh's own origin is. So equal positions become equal positions, in both meshes that share them
// and to the last bit, also in different files, as long as the step is the same: that of one voxel size, or of one box
// and number of bits. Such coordinates are exact in float32 up to 2^24 steps from zero; beyond, a file's meshes are
// relative to one common origin, itself on the lattice. No coordinate moves by more than half a step.
//
// What was packed is unpacked again before it is written: triangles, their orientation, attributes and positions are
// compared with the mesh, and errors are measured.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "base/stopwatch.hpp"
#include "base/words.hpp"
#include "mesh/metrics.hpp"

namespace isoextract::mesh_io {

enum class Compression {
  none,
  draco,   // glb and gltf: KHR_draco_mesh_compression. Quantises; the order of vertices and triangles changes
  meshopt  // glb and gltf: EXT_meshopt_compression. Loses nothing; corners of triangles may turn
};
constexpr auto words_of(Compression /*type*/) {
  return std::array{Word{Compression::none, "none"}, Word{Compression::draco, "draco"},
                    Word{Compression::meshopt, "meshopt"}};
}

// How files are packed; by default they are not.
struct PackingOptions {
  Compression compression = Compression::none;
  // glb and gltf: positions of 16 bits, normals of 8 (KHR_mesh_quantization). Draco quantises by itself.
  bool quantize = false;
  // Of Draco: the longest side of the box has less than 2^bits steps. Nothing: the step is at most a 32nd of a voxel.
  std::optional<std::uint64_t> position_bits;
  // Vertices and triangles in an order that graphics cards and packers like (meshoptimizer). Any format, but not with
  // Draco, which has an order of its own.
  bool optimize_order = false;

  [[nodiscard]] bool quantizes() const { return quantize || compression == Compression::draco; }
  [[nodiscard]] bool packs() const { return quantize || compression != Compression::none; }
  friend bool operator==(const PackingOptions&, const PackingOptions&) = default;
};

// Packing, and what it takes of the field: the voxel and the box of its samples.
struct MeshPacking : PackingOptions {
  // The shortest side of a voxel, in the mesh's units. 0: not known; the step is as fine as the bits allow.
  double voxel = 0;
  // What all that shares the lattice lies in; a vertex outside is an error. Nothing: the box around the meshes of the
  // file, which then are held until the last.
  std::optional<mesh::Bounds> box = {};
};

inline constexpr std::uint64_t kMinPositionBits = 8;
inline constexpr std::uint64_t kMaxPositionBits = 22;  // with which float32 still counts in halves

// What packing did to one mesh.
struct PackedFacts {
  std::uint64_t bytes_before = 0;  // of positions, normals, attributes and indices, as they are written without packing
  std::uint64_t bytes_after = 0;

  struct Positions {
    int bits = 0;             // of the largest coordinate, in steps
    double step = 0;          // in the mesh's units
    double largest_axis = 0;  // by which a coordinate moved: at most half a step
    double largest = 0;       // by which a vertex moved
  };
  std::optional<Positions> positions;         // where they were quantised
  std::optional<double> largest_normal_turn;  // in degrees, where normals were quantised
  std::uint64_t flattened_triangles = 0;      // that have lost their area by it
  // By Draco, in their own order: where they do not join as on a manifold, nothing else keeps them as they are.
  bool one_by_one = false;
  StageTime time;  // to pack, unpack and compare
};

}  // namespace isoextract::mesh_io
