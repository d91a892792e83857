#include "convert/mesh_smooth.hpp"

#include <cmath>
#include <utility>

namespace isoextract::convert {

Json json_of(const SmoothRecord& record) {
  const edit::SmoothFacts& facts = record.facts;
  return {{"iso", record.iso},
          {"method", word_of(record.asked.method)},
          {"passes", record.asked.passes},
          {"pass_band", record.asked.pass_band},
          {"vertices", facts.vertices},
          {"border_vertices", facts.border_vertices},
          {"cap_vertices", facts.wall_vertices},
          {"greatest_move", {{"voxels", facts.greatest_move}, {"world", facts.greatest_move_world}}},
          {"volume", {{"before", facts.volume_before}, {"after", facts.volume_after}}},
          {"time", json_of(facts.time)}};
}

Result<SmoothRecord> smooth_mesh(mesh::Mesh& mesh, double iso, const SmoothChoice& choice,
                                 const field::Affine& output_from_index, const std::optional<field::IndexBox>& data,
                                 std::span<const mesh::HalfSpace> cuts, const Context& context) {
  edit::SmoothOptions options;
  options.method = choice.method;
  options.passes = choice.passes;
  options.pass_band = choice.pass_band;
  const field::Affine index_from_output = output_from_index.inverse();
  options.to_metric = index_from_output.linear;
  options.cuts = cuts;
  if (data) {
    options.walls = edit::SmoothWalls{index_from_output.linear, index_from_output.offset, glm::dvec3(data->min),
                                      glm::dvec3(data->max)};
  }
  auto facts = TRY(edit::smooth(mesh, options, context));
  return SmoothRecord{iso, choice, facts};
}

}  // namespace isoextract::convert
