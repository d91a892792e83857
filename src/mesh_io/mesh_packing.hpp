// Options for packing meshes into fewer bytes, and the record of what packing changed.
//
// Quantized positions lie on one lattice: the multiples of a step, which is a power of two, in the coordinates of the
// output. The mesh's own origin does not matter. So positions that are equal before stay equal, bit for bit, across
// meshes and across files that use the same step.
// The step depends on the voxel size and the box; with `position_bits`, on the box and the bits only.
// float32 holds such coordinates exactly up to 2^24 steps from zero. Farther away, and always with 16-bit positions,
// the meshes of a glTF file are relative to one common origin, which is a lattice point; a .drc file has no origin, so
// its step grows. No coordinate moves by more than half a step.
//
// Before the writer writes the file, it decodes each mesh that Draco or meshoptimizer compressed, and compares its
// triangles, their orientation, attributes and positions with those that it encoded. It measures the errors of
// quantizing for every mesh.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "base/enum_words.hpp"
#include "base/stopwatch.hpp"
#include "mesh/metrics.hpp"

namespace isoextract::mesh_io {

enum class Compression {
  none,
  draco,   // glb and gltf: KHR_draco_mesh_compression. Quantizes; changes the order of vertices and triangles
  meshopt  // glb and gltf: EXT_meshopt_compression. Lossless; may rotate the corners within a triangle
};
constexpr auto words_of(Compression /*type*/) {
  return std::array{Word{Compression::none, "none"}, Word{Compression::draco, "draco"},
                    Word{Compression::meshopt, "meshopt"}};
}

// How to pack files; the default packs nothing.
struct PackingOptions {
  Compression compression = Compression::none;
  // glb and gltf: 16-bit positions and 8-bit normals (KHR_mesh_quantization). Draco quantizes by itself.
  bool quantize = false;
  // Draco only: the longest side of the box has fewer than 2^bits steps. If unset, the step is at most 1/32 of a voxel,
  // unless the box then has more than 2^kMaxPositionBits steps, or lies too far from 0 for such steps in float32.
  std::optional<std::uint64_t> position_bits;
  // Reorders vertices and triangles for the caches of graphics cards and for compressors (meshoptimizer). Any format,
  // but not with Draco, which uses its own order.
  bool optimize_order = false;

  [[nodiscard]] bool quantizes() const { return quantize || compression == Compression::draco; }
  [[nodiscard]] bool packs() const { return quantize || compression != Compression::none; }
  friend bool operator==(const PackingOptions&, const PackingOptions&) = default;
};

// Packing options, with the voxel size and the bounding box of the field.
struct MeshPacking : PackingOptions {
  // The shortest side of a voxel, in the mesh's units. 0 if unknown: the step is then the finest that position_bits
  // allow or, if unset, kMaxPositionBits (16 bits with `quantize`).
  double voxel = 0;
  // The box around every mesh that shares the lattice; a vertex outside is an error. If unset, MeshWriter uses the box
  // around the meshes of the file and holds all of them in memory until finish(); AnimationWriter fails.
  std::optional<mesh::Bounds> box = {};
};

inline constexpr std::uint64_t kMinPositionBits = 8;
inline constexpr std::uint64_t kMaxPositionBits = 22;  // float32 (24 bits) still holds half steps

// Records what packing did to one mesh.
struct PackedFacts {
  std::uint64_t bytes_before = 0;  // positions, normals, attributes and indices without packing
  std::uint64_t bytes_after = 0;

  struct Positions {
    int bits = 0;                  // bits for the number of steps along the box's longest side
    double step = 0;               // in the mesh's units
    double largest_axis_move = 0;  // the largest move of a coordinate: at most half a step
    double largest_move = 0;       // of a vertex
  };
  std::optional<Positions> positions;          // set if positions were quantized
  std::optional<double> largest_normal_angle;  // in degrees; set if normals were quantized
  std::uint64_t flattened_triangles = 0;       // triangles that lost their area by quantizing
  // Draco stored the triangles one by one in their original order, because its default method (edgebreaker) did not
  // reproduce this mesh, as happens if it is not manifold.
  bool used_sequential_method = false;
  StageTime time;  // of packing, unpacking and comparing
};

}  // namespace isoextract::mesh_io
