#include "convert/mesh_packing.hpp"

#include <algorithm>

#include "convert/source.hpp"

namespace isoextract::convert {

double shortest_voxel_side(const field::Affine& output_from_index) {
  const glm::dmat3& sides = output_from_index.linear;
  return std::min({glm::length(sides[0]), glm::length(sides[1]), glm::length(sides[2])});
}

meshes::MeshPacking mesh_packing(const PackingOptions& options, const Source& source) {
  meshes::MeshPacking packing;
  packing.compression = options.compression;
  packing.quantize = options.quantize;
  packing.position_bits = options.position_bits;
  packing.optimize_order = options.optimize_order;
  if (!options.packs()) return packing;
  packing.voxel = shortest_voxel_side(source.output_from_index);
  const field::IndexBox extents = source.field.extents();
  if (extents.empty()) return packing;
  // Surfaces of sparse fields pass between active voxels and the background beside them.
  const field::Box samples{glm::dvec3(extents.min) - 1.0, glm::dvec3(extents.max) + 1.0};
  const field::Box box = field::image_of(source.output_from_index, samples);
  packing.box = mesh::Bounds{box.min, box.max};
  return packing;
}

}  // namespace isoextract::convert
