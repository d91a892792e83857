#include "convert/detail/label_looks.hpp"

#include <utility>

#include <fmt/format.h>

#include "base/printable.hpp"
#include "base/srgb.hpp"
#include "edit/vertex_colors.hpp"

namespace isoextract::convert {

Result<LabelAppearance> LabelAppearance::open(const ConversionJob& job, const Context& context) {
  LabelAppearance looks;
  if (!job.label_names) return looks;
  auto table = TRY(volume_io::LabelTable::read(job.label_names->path, context));
  if (table.hash() != job.label_names->hash) {
    return fail(ErrorCode::input, fmt::format("{}: the table of labels has changed since the program first read it",
                                              printable(job.label_names->path)));
  }
  looks.table_ = std::move(table);
  return looks;
}

std::string LabelAppearance::name(const std::string& field, std::int64_t label) const {
  const volume_io::LabelEntry* entry = table_ ? table_->find(label) : nullptr;
  if (entry == nullptr) return fmt::format("{} label {}", field, label);
  return table_->shares_name(*entry) ? fmt::format("{} label {}", entry->name, label) : entry->name;
}

Result<void> LabelAppearance::color(const ConversionJob& job, std::int64_t label, mesh::Mesh& mesh,
                                    const Context& context) const {
  if (job.color) return {};
  const volume_io::LabelEntry* entry = table_ ? table_->find(label) : nullptr;
  const glm::dvec3 color = entry != nullptr ? entry->color : volume_io::default_label_color(label);
  const mesh_io::MeshFormat format = job.meshes().format;
  if (mesh_io::is_gltf(format)) {
    if (!mesh.material) mesh.material.emplace();
    mesh.material->color = glm::dvec3(srgb_to_linear(color.x), srgb_to_linear(color.y), srgb_to_linear(color.z));
    return {};
  }
  if (!table_ || format != mesh_io::MeshFormat::ply) return {};
  return edit::color_uniformly(mesh, color, context);
}

}  // namespace isoextract::convert
