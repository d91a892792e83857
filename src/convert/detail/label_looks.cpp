#include "convert/detail/label_looks.hpp"

#include <algorithm>
#include <iterator>
#include <span>
#include <unordered_set>

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
    looks.index();
    return looks;
  }
  const auto table = TRY(volume_io::LabelTable::read(job.label_names->path, context));
  if (table.hash() != job.label_names->hash) {
    return fail(ErrorCode::input,
                fmt::format("{}: the table of labels has changed since the program first read it",
                            printable(job.label_names->path)),
                "run again when no other program writes to the file");
  }
  looks.labels_ = table.entries();
  looks.has_table_ = true;
  looks.index();
  return looks;
}

void LabelAppearance::index() {
  for (std::size_t i = 0; i < labels_.size(); ++i) {
    if (is_here(labels_[i])) by_label_.try_emplace(labels_[i].label, i);
    ++shared_by_[labels_[i].name];
  }
}

const field::LabelName* LabelAppearance::find(std::int64_t label) const {
  const auto found = by_label_.find(label);
  return found != by_label_.end() ? &labels_[found->second] : nullptr;
}

std::string LabelAppearance::name(const std::string& field, std::int64_t label) const {
  const field::LabelName* entry = find(label);
  if (entry == nullptr) return fmt::format("{} label {}", field, label);
  return shared_by_.at(entry->name) > 1 ? fmt::format("{} label {}", entry->name, label) : entry->name;
}

std::string LabelAppearance::given_name(std::int64_t label) const {
  const field::LabelName* entry = find(label);
  return entry != nullptr ? entry->name : std::string();
}

std::vector<std::string> LabelAppearance::names() const {
  std::vector<std::string> names;
  for (const field::LabelName& entry : labels_) names.push_back(entry.name);
  names.insert(names.end(), without_voxels_.begin(), without_voxels_.end());
  return names;
}

void LabelAppearance::add_names_without_voxels(const std::vector<std::string>& names) {
  without_voxels_.insert(without_voxels_.end(), names.begin(), names.end());
}

std::vector<field::LabelName> LabelAppearance::of_other_layers() const {
  std::vector<field::LabelName> others;
  std::ranges::copy_if(labels_, std::back_inserter(others), [&](const auto& entry) { return !is_here(entry); });
  return others;
}

std::optional<Note> LabelAppearance::note_of_missing(const std::string& source, const std::vector<std::int64_t>& found,
                                                     std::int64_t background, bool in_region) const {
  if (has_table_) return std::nullopt;
  const std::unordered_set<std::int64_t> here(found.begin(), found.end());
  std::vector<std::string> missing;
  std::size_t named = 0;
  for (const field::LabelName& entry : labels_) {
    if (entry.label == background || !is_here(entry)) continue;
    ++named;
    if (!here.contains(entry.label)) missing.push_back(printable(entry.name, kMaxName));
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
