#include "accuracy/index_mesh.hpp"

#include "extract/edge_geometry.hpp"
#include "extract/sparse_blocks.hpp"
#include "extract/sparse_sites.hpp"

namespace isoextract::accuracy {

IndexMesh::IndexMesh(const mesh::Mesh& mesh, const field::ScalarField& field, const extract::ExtractOptions& extracted,
                     const field::ScalarField* grid)
    : mesh_(mesh) {
  const field::ScalarField& from = grid != nullptr ? *grid : field;
  const field::Affine field_from_grid = field.index_to_file.inverse().after(from.index_to_file);
  output_from_index_ = extracted.output_from_index.after(field_from_grid.inverse());
  index_from_local_ = glm::inverse(output_from_index_.linear);
  local_offset_ = mesh.origin - output_from_index_.offset;
  const auto* sparse = std::get_if<field::SparseSamples>(&field.samples);
  const field::IndexBox samples = sparse != nullptr ? extract::stored_box(*sparse) : field.extents();
  field::IndexBox region = samples;
  if (extracted.region && grid == nullptr) {
    region = {glm::max(samples.min - 1, extracted.region->min), glm::min(samples.max + 1, extracted.region->max)};
    if (sparse != nullptr) region = extract::sparse_region(field, *sparse, extracted).value_or(region);
  }
  extract::ExtractOptions placed = extracted;
  placed.output_from_index = output_from_index_;
  // Half the margin that keeps vertices off edge ends: smaller distances come from rounding only.
  tolerance_ = extract::output_placement(field, placed, samples, region).margin() / 2;
  const bool always_closed = extract::method_info(extracted.method).traits.always_closed;
  if (!extracted.cap && !always_closed) return;
  std::optional<field::IndexBox> cap = extracted.region;
  // Only dense samples have a boundary besides the region.
  if (std::holds_alternative<field::DenseSamples>(from.samples)) {
    const field::IndexBox all = from.extents();
    cap = cap ? field::IndexBox{glm::max(all.min, cap->min), glm::min(all.max, cap->max)} : all;
  }
  if (!cap) return;
  (always_closed ? outermost_samples_ : cap_) =
      field::image_of(field_from_grid, {glm::dvec3(cap->min), glm::dvec3(cap->max)});
}

std::vector<std::uint8_t> IndexMesh::surface_vertices() const {
  const bool may_have_caps = cap_ || outermost_samples_ || !caps_.cuts.empty();
  std::vector<std::uint8_t> used(mesh_.positions.size(), may_have_caps ? 0 : 1);
  if (!may_have_caps) return used;
  for (std::size_t t = 0; t < mesh_.triangles.size(); ++t) {
    if (is_cap(corners(t))) continue;
    for (int corner = 0; corner < 3; ++corner) used[mesh_.triangles[t][corner]] = 1;
  }
  return used;
}

}  // namespace isoextract::accuracy
