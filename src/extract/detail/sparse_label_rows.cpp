#include "extract/detail/sparse_label_rows.hpp"

#include <cstdint>
#include <utility>

#include "extract/detail/voxel_input.hpp"

namespace isoextract::extract {

SparseLabelRows::SparseLabelRows(const field::ScalarField& field, const field::SparseSamples& samples,
                                 const field::IndexBox& region, const std::vector<glm::ivec3>& nodes,
                                 Reservation memory)
    : field_(field), samples_(samples), region_(region), memory_(std::move(memory)), lookup_(samples, nodes) {}

Result<SparseLabelRows> SparseLabelRows::make(const field::ScalarField& field, const field::SparseSamples& samples,
                                              const field::IndexBox& region, const Context& context,
                                              const std::string& what) {
  const std::vector<glm::ivec3> nodes = field::SparseLookup::node_origins(samples);
  auto memory = TRY(context.reserve(nodes.size() * sizeof(field::SparseLookup::Node), what));
  return SparseLabelRows(field, samples, region, nodes, std::move(memory));
}

Result<SparseLabelRows::Chunks> SparseLabelRows::chunks(const Context& context) const {
  Chunks chunks;
  const std::vector<std::uint8_t> tiles_inside(samples_.tiles.size(), 1);
  chunks.origins = TRY(sparse_chunks(field_, samples_, region_, false, tiles_inside, context, chunks.memory));
  return chunks;
}

}  // namespace isoextract::extract
