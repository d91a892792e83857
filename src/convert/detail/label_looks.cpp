#include "convert/detail/label_looks.hpp"

#include <algorithm>
#include <span>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/printable.hpp"
#include "base/srgb.hpp"
#include "edit/vertex_colors.hpp"
#include "volume_io/label_table.hpp"

namespace isoextract::convert {
namespace {

constexpr std::size_t kMaxName = 60;  // most bytes of a name in a note

}  // namespace

Result<LabelAppearance> LabelAppearance::open(const ConversionJob& job, const field::ScalarField& field,
                                              std::optional<std::int64_t> layer, const Context& context) {
  LabelAppearance looks;
  if (!job.label_names) {
    looks.labels_ = field.labels;
    looks.layer_ = layer;
    return looks;
  }
  const auto table = TRY(volume_io::LabelTable::read(job.label_names->path, context));
  if (table.hash() != job.label_names->hash) {
    return fail(ErrorCode::input, fmt::format("{}: the table of labels has changed since the program first read it",
                                              printable(job.label_names->path)));
  }
  looks.labels_ = table.entries();
  looks.has_table_ = true;
  return looks;
}

const field::LabelName* LabelAppearance::find(std::int64_t label) const {
  const auto is_it = [&](const field::LabelName& entry) { return entry.label == label && is_here(entry); };
  const auto found = std::ranges::find_if(labels_, is_it);
  return found != labels_.end() ? &*found : nullptr;
}

std::string LabelAppearance::name(const std::string& field, std::int64_t label) const {
  const field::LabelName* entry = find(label);
  if (entry == nullptr) return fmt::format("{} label {}", field, label);
  const bool is_shared = std::ranges::count(labels_, entry->name, &field::LabelName::name) > 1;
  return is_shared ? fmt::format("{} label {}", entry->name, label) : entry->name;
}

std::optional<Note> LabelAppearance::note_of_missing(const std::string& source, const std::vector<std::int64_t>& found,
                                                     bool in_region) const {
  if (has_table_) return std::nullopt;
  std::vector<std::string> missing;
  std::size_t named = 0;
  for (const field::LabelName& entry : labels_) {
    if (entry.label == 0 || !is_here(entry)) continue;
    ++named;
    if (std::ranges::find(found, entry.label) == found.end()) missing.push_back(printable(entry.name, kMaxName));
  }
  if (missing.empty()) return std::nullopt;
  constexpr std::size_t kMostTold = 10;
  const std::size_t told = std::min(missing.size(), kMostTold);
  return Note{NoteId::labels_empty,
              fmt::format("{}: no mesh for {} of the {} labels that the file names ({}{}): no sample{} has them",
                          source, missing.size(), named, fmt::join(std::span(missing).first(told), ", "),
                          told < missing.size() ? ", ..." : "", in_region ? " in the region" : "")};
}

Result<void> LabelAppearance::color(const ConversionJob& job, std::int64_t label, mesh::Mesh& mesh,
                                    const Context& context) const {
  if (job.color) return {};
  const field::LabelName* entry = find(label);
  const glm::dvec3 color = entry != nullptr && entry->color ? *entry->color : volume_io::default_label_color(label);
  const mesh_io::MeshFormat format = job.meshes().format;
  if (mesh_io::is_gltf(format)) {
    if (!mesh.material) mesh.material.emplace();
    mesh.material->color = glm::dvec3(srgb_to_linear(color.x), srgb_to_linear(color.y), srgb_to_linear(color.z));
    return {};
  }
  if (labels_.empty() || format != mesh_io::MeshFormat::ply) return {};
  return edit::color_uniformly(mesh, color, context);
}

}  // namespace isoextract::convert
