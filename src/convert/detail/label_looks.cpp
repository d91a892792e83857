#include "convert/detail/label_looks.hpp"

#include <utility>

#include <fmt/format.h>

#include "base/printable.hpp"
#include "base/srgb.hpp"
#include "edit/vertex_colors.hpp"

namespace isoextract::convert {

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
  const mesh_io::MeshFormat format = job.meshes().format;
  if (mesh_io::is_gltf(format)) {
    if (!mesh.material) mesh.material.emplace();
    mesh.material->colour = glm::dvec3(linear_of_srgb(colour.x), linear_of_srgb(colour.y), linear_of_srgb(colour.z));
    return {};
  }
  if (!table_ || format != mesh_io::MeshFormat::ply) return {};
  return edit::color_all(mesh, colour, context);
}

}  // namespace isoextract::convert
