#include "convert/detail/label_looks.hpp"

#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "base/printable.hpp"
#include "base/srgb.hpp"

namespace isoextract::convert {
namespace {

Result<void> colour_vertices(const glm::dvec3& colour, mesh::Mesh& mesh, const Context& context) {
  mesh::Attribute made;
  made.name = "colour";
  made.role = mesh::AttributeRole::colour;
  made.type = mesh::ComponentType::u8;
  made.components = 3;
  made.normalised = true;
  const std::size_t vertices = mesh.positions.size();
  auto memory = TRY(context.reserve(vertices * made.stride(), "colours of vertices"));
  made.values = Buffer<std::byte>(vertices * made.stride());
  for (std::size_t v = 0; v < vertices; ++v) {
    for (int c = 0; c < 3; ++c) {
      made.values[3 * v + static_cast<std::size_t>(c)] = static_cast<std::byte>(std::lround(colour[c] * 255));
    }
  }
  mesh.attributes.push_back(std::move(made));
  mesh.memory.take(std::move(memory));
  return {};
}

}  // namespace

Result<LabelLooks> LabelLooks::open(const ConversionJob& job, const Context& context) {
  LabelLooks looks;
  if (!job.label_names) return looks;
  auto table = TRY(volume_io::LabelTable::read(job.label_names->path, context));
  if (table.hash() != job.label_names->hash) {
    return fail(ErrorCode::input, fmt::format("{}: the table of labels has changed since the conversion was planned",
                                              printable(job.label_names->path)));
  }
  looks.table_ = std::move(table);
  return looks;
}

std::string LabelLooks::name(const std::string& field, std::int64_t label) const {
  const volume_io::LabelEntry* entry = table_ ? table_->find(label) : nullptr;
  if (entry == nullptr) return fmt::format("{} label {}", field, label);
  return table_->shares_name(*entry) ? fmt::format("{} label {}", entry->name, label) : entry->name;
}

Result<void> LabelLooks::colour(const ConversionJob& job, std::int64_t label, mesh::Mesh& mesh,
                                const Context& context) const {
  if (job.colour) return {};
  const volume_io::LabelEntry* entry = table_ ? table_->find(label) : nullptr;
  const glm::dvec3 colour = entry != nullptr ? entry->colour : volume_io::usual_label_colour(label);
  const bool has_materials = mesh_io::is_gltf(job.format);
  if (has_materials || job.picture_file) {
    if (!mesh.material) mesh.material.emplace();
    mesh.material->colour = glm::dvec3(linear_of_srgb(colour.x), linear_of_srgb(colour.y), linear_of_srgb(colour.z));
    return {};
  }
  if (!table_ || job.format != mesh_io::MeshFormat::ply) return {};
  return colour_vertices(colour, mesh, context);
}

}  // namespace isoextract::convert
