#include "convert/mesh_pieces.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <new>
#include <utility>

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include "convert/source.hpp"
#include "mesh/half_space.hpp"
#include "mesh/metrics.hpp"

#include "base/no_memory.hpp"

namespace isoextract::convert {
namespace {

Json json_of(const edit::PieceCounts& counts) {
  return {{"triangles", counts.triangles}, {"components", counts.components}, {"bodies", counts.bodies}};
}

Json json_of(const mesh::ComponentFacts& facts) {
  const bool closed = facts.is_closed();
  return {{"triangles", facts.triangles},
          {"closed", closed},
          {"cavity", facts.is_cavity()},
          {"genus", closed ? Json(facts.topology.genus()) : Json(nullptr)},
          {"area", facts.area},
          {"volume", closed ? Json(facts.volume) : Json(nullptr)},
          {"bounds", convert::json_of(field::Box{facts.bounds.min, facts.bounds.max})}};
}

Result<ComponentTable> measure_table(const mesh::Mesh& mesh, const Context& context) {
  const std::string what = mesh.name + ": the components of its surface";
  const auto labels = TRY(context.reserve(mesh::Components::bytes(mesh.positions.size()), what));
  const mesh::Components components(mesh.triangles.span(), mesh.positions.size());
  const auto list = TRY(context.reserve(components.count() * sizeof(mesh::ComponentFacts), what));
  auto facts = TRY(measure_components(mesh, components, glm::dmat3(1.0), context));
  std::ranges::stable_sort(facts, std::greater<>(), &mesh::ComponentFacts::area);
  ComponentTable table;
  for (std::size_t i = ComponentTable::kMostTold; i < facts.size(); ++i) {
    ++table.others;
    table.triangles_of_others += facts[i].triangles;
  }
  const std::size_t told = std::min(facts.size(), ComponentTable::kMostTold);
  table.largest.assign(facts.begin(), facts.begin() + static_cast<std::ptrdiff_t>(told));
  return table;
}

}  // namespace

Json json_of(const PieceRecord& record) {
  return {{"iso", record.iso},
          {"before", json_of(record.facts.before)},
          {"after", json_of(record.facts.after)},
          {"without_volume", record.facts.without_volume},
          {"time", json_of(record.facts.time)}};
}

Result<edit::Sites> voxel_sites(const mesh::Mesh& mesh, const Source& source, const SurfaceOptions& surface,
                                const Context& context) {
  if (!surface.relaxes()) return edit::Sites();
  const auto memory = TRY(context.reserve(mesh.positions.size_bytes(), mesh.name + ": the voxels of its components"));
  const double on_plane = 2 * mesh::on_plane_distance(mesh::farthest_coordinate(mesh.positions.span()));
  const field::Affine index_from_output = source.output_from_index.inverse();
  edit::Sites sites(mesh.positions.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, sites.size(), 1 << 12), [&](const auto& range) {
    for (std::size_t v = range.begin(); v != range.end(); ++v) {
      const glm::dvec3 place = mesh.position(v);
      const bool is_cut = std::ranges::any_of(
          source.clip, [&](const mesh::HalfSpace& kept) { return std::abs(kept.depth(place)) <= on_plane; });
      const glm::dvec3 corner = glm::floor(index_from_output(place)) + 0.5;
      sites[v] = is_cut ? mesh.positions[v] : glm::vec3(source.output_from_index(corner) - mesh.origin);
    }
  });
  return sites;
}

Result<PieceRecord> drop_pieces(mesh::Mesh& mesh, double iso, const PieceChoice& choice, const Source& source,
                                edit::Sites sites, const Context& context) {
  edit::PieceOptions options;
  const bool in_voxels = choice.least && !choice.least->in_world_units;
  if (choice.least) {
    options.least = choice.least->amount;
    options.measure = choice.least->measure;
  }
  options.fill_cavities = choice.fill_cavities;
  options.largest = choice.largest;
  if (in_voxels) options.to_metric = glm::inverse(source.output_from_index.linear);
  context.progress().begin("finding pieces", 0);
  auto kept = TRY(edit::keep_pieces(std::move(mesh), options, context, std::move(sites)));
  mesh = std::move(kept.mesh);
  return PieceRecord{iso, kept.facts};
}

Result<std::vector<mesh::Mesh>> split_mesh(mesh::Mesh mesh, bool into_files, const Context& context) {
  const std::string name = mesh.name;
  auto pieces = edit::split_pieces(std::move(mesh), into_files ? kMostPieceFiles : kMostPieceMeshes, context);
  if (!pieces) return pieces;
  for (std::size_t i = 0; i < pieces->size(); ++i) (*pieces)[i].name += fmt::format(" piece {}", i + 1);
  if (pieces->empty() && !into_files) pieces->emplace_back().name = name;
  return pieces;
}

std::string piece_path(std::string pattern, std::size_t number) {
  const std::string text = std::to_string(number);
  for (std::size_t at = pattern.find(kPieceWord); at != std::string::npos; at = pattern.find(kPieceWord, at)) {
    pattern.replace(at, kPieceWord.size(), text);
    at += text.size();
  }
  return pattern;
}

Result<ComponentTable> component_table(const mesh::Mesh& mesh, const Context& context) {
  try {
    return measure_table(mesh, context);
  } catch (const std::bad_alloc&) {
    return tl::unexpected(
        no_memory(ErrorKind::input, mesh.name + ": the components of its surface need more memory than there is"));
  }
}

Json json_of(const ComponentTable& table) {
  Json largest = Json::array();
  for (const mesh::ComponentFacts& facts : table.largest) largest.push_back(json_of(facts));
  return {{"largest", std::move(largest)},
          {"others", {{"components", table.others}, {"triangles", table.triangles_of_others}}}};
}

}  // namespace isoextract::convert
