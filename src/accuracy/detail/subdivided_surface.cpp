#include "accuracy/detail/subdivided_surface.hpp"

#include <limits>
#include <utility>
#include <vector>

#include "extract/extractor.hpp"

namespace isoextract::accuracy {
namespace {

// Returns the values at the corners of the parts, x fastest; NaN in cells without surface. Empty if no cell has
// surface.
std::vector<double> sample_parts(field::Interpolant::Cursor& field, const field::IndexBox& cells,
                                 const Subdivision& how, const glm::ivec3& dims) {
  std::vector<double> values;
  const auto n = static_cast<double>(how.parts);
  const auto fill = [&](const glm::ivec3& cell) {
    if (values.empty()) {
      values.assign(
          static_cast<std::size_t>(dims.x) * static_cast<std::size_t>(dims.y) * static_cast<std::size_t>(dims.z),
          std::numeric_limits<double>::quiet_NaN());
    }
    const glm::ivec3 first = (cell - cells.min) * how.parts;
    for (int k = 0; k <= how.parts; ++k) {
      for (int j = 0; j <= how.parts; ++j) {
        const auto row = static_cast<std::size_t>(first.x) +
                         static_cast<std::size_t>(dims.x) *
                             (static_cast<std::size_t>(first.y + j) +
                              static_cast<std::size_t>(dims.y) * static_cast<std::size_t>(first.z + k));
        for (int i = 0; i <= how.parts; ++i) {
          values[row + static_cast<std::size_t>(i)] = field.evaluate_in_cell(cell, glm::dvec3(i, j, k) / n).value;
        }
      }
    }
  };
  for (int z = cells.min.z; z <= cells.max.z; ++z) {
    for (int y = cells.min.y; y <= cells.max.y; ++y) {
      for (int x = cells.min.x; x <= cells.max.x; ++x) {
        const auto range = field.range({x, y, z});
        if (range && range->low <= 0 && range->high >= 0 && range->low < range->high) fill({x, y, z});
      }
    }
  }
  return values;
}

}  // namespace

Result<SubdividedSurface> SubdividedSurface::make(field::Interpolant::Cursor& field, const field::IndexBox& cells,
                                                  const Subdivision& how) {
  SubdividedSurface surface(glm::dvec3(cells.min), how.linear);
  const glm::ivec3 dims = (cells.max - cells.min + 1) * how.parts + 1;
  const std::vector<double> values = sample_parts(field, cells, how, dims);
  if (values.empty()) return surface;
  field::ScalarField parts;
  parts.kind = how.kind;
  parts.samples = field::DenseSamples{field::SampleType::f64, dims, nullptr, values.data()};
  extract::ExtractOptions options;
  options.iso = 0;
  options.nan = extract::NanPolicy::hole;
  options.output_from_index.linear = how.linear / static_cast<double>(how.parts);
  auto extraction = TRY(extract::make_cpu_extractor()->extract(parts, options, Context()));
  surface.mesh_ = std::move(extraction.mesh);
  return surface;
}

std::uint64_t SubdividedSurface::bytes(int cells, int parts, std::uint64_t triangles) {
  const auto square = static_cast<std::uint64_t>(parts) * static_cast<std::uint64_t>(parts);
  const auto along = static_cast<std::uint64_t>(cells) * static_cast<std::uint64_t>(parts) + 1;
  const std::uint64_t small = triangles * square;
  return along * along * along * sizeof(double) + small * (sizeof(glm::uvec3) + sizeof(glm::vec3)) +
         mesh::TriangleTree::bytes(small);
}

const mesh::TriangleTree& SubdividedSurface::tree() {
  if (!tree_) tree_.emplace(mesh_.positions.span(), mesh_.triangles.span());
  return *tree_;
}

}  // namespace isoextract::accuracy
