#include "measure/index_mesh.hpp"

#include "extract/edge_geometry.hpp"
#include "extract/sparse_blocks.hpp"

namespace isoextract {

IndexMesh::IndexMesh(const Mesh& mesh, const ScalarField& field, const ExtractOptions& extracted)
    : mesh_(mesh),
      linear_(extracted.output_from_index.linear),
      index_from_local_(glm::inverse(linear_)),
      local_offset_(mesh.origin - extracted.output_from_index.offset) {
  const auto* sparse = std::get_if<SparseSamples>(&field.samples);
  const IndexBox samples = sparse != nullptr ? stored_box(*sparse) : field.extents();
  // Half of what keeps vertices off the ends of their edges: closer than that only rounding brings them.
  tolerance_ = Placement(extracted.output_from_index, samples, field.kind, field.scale).margin() / 2;
  if (!extracted.cap) return;
  if (sparse != nullptr) {
    cap_ = extracted.region;  // unbounded samples have no other border
  } else if (!extracted.region) {
    cap_ = samples;
  } else {
    cap_ = IndexBox{glm::max(samples.min, extracted.region->min), glm::min(samples.max, extracted.region->max)};
  }
}

std::vector<std::uint8_t> IndexMesh::surface_vertices() const {
  std::vector<std::uint8_t> used(mesh_.positions.size(), cap_ ? 0 : 1);
  if (!cap_) return used;
  for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
    if (is_cap(corners(t))) continue;
    for (int corner = 0; corner < 3; ++corner) used[mesh_.triangles[t][corner]] = 1;
  }
  return used;
}

}  // namespace isoextract
