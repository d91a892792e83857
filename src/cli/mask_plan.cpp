#include "cli/mask_plan.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <unordered_set>

#include <fmt/format.h>

#include "base/printable.hpp"
#include "batch/find_frames.hpp"
#include "batch/header_files.hpp"
#include "cli/plan_parts.hpp"
#include "convert/iso_choice.hpp"
#include "files/file_bytes.hpp"
#include "files/folder_names.hpp"
#include "files/natural_order.hpp"
#include "volume_io/volume_reader.hpp"

namespace isoextract::cli {
namespace {

namespace fs = std::filesystem;

bool is_folder_of_files(const std::string& input) {
  std::error_code none;
  return fs::is_directory(input, none) && !volume_io::is_volume_folder(input, Context());
}

Result<std::vector<std::string>> masks_of_folder(const std::string& folder, Notes& notes) {
  std::vector<std::string> names;
  batch::CountedFiles others;
  TRY(files::visit_folder(folder, [&](const std::string& name, const fs::directory_entry& entry) {
    if (name.starts_with('.') || batch::has_header_beside(folder, name)) return;
    const bool is_volume = is_folder_of_files(entry.path()) ? false : volume_io::has_volume_extension(name);
    is_volume ? names.push_back(name) : others.add(name);
  }));
  if (names.empty()) {
    return fail(ErrorCode::input,
                fmt::format("{}: no file in the folder has the extension of a volume format", printable(folder)),
                "list the files of the masks");
  }
  std::ranges::sort(names, files::NaturalLess());
  if (others.count > 0) {
    notes.push_back(batch::note_of_other_files(folder, "volume file", {names.size(), names.front()}, {}, others));
  }
  for (std::string& name : names) name.insert(0, folder.ends_with('/') ? folder : folder + '/');
  return names;
}

}  // namespace

Result<std::vector<std::string>> find_masks(std::span<const std::string> inputs, Notes& notes) {
  if (inputs.size() == 1 && is_folder_of_files(inputs.front())) return masks_of_folder(inputs.front(), notes);
  std::unordered_set<std::string_view> known;
  for (const std::string& input : inputs) {
    if (files::is_standard_input(input)) return refuse_usage("--masks takes files or a folder, found stdin");
    if (is_folder_of_files(input)) {
      return refuse_usage(
          fmt::format("{}: --masks takes files or one folder, found a folder among several inputs", printable(input)),
          "give the folder alone, or list the files");
    }
    if (!known.insert(input).second) {
      return refuse_usage(fmt::format("{}: expected each mask once, found this input twice", printable(input)));
    }
  }
  std::vector<std::string> masks = batch::without_sample_files(inputs);
  std::ranges::sort(masks, files::NaturalLess());
  return masks;
}

std::string name_of_masks(std::span<const std::string> masks) {
  const std::string folder = fs::path(masks.front()).parent_path().filename().string();
  return folder.empty() || folder == "." || folder == ".." ? "masks" : folder;
}

Result<void> check_mask_input(const InputFlags& input, const ParticleFlags& particles, const Flag& masks) {
  if (!masks) return {};
  TRY(refuse_both(masks, input.volume, "the file of each mask has one volume"));
  TRY(refuse_both(masks, input.inside, "the inside of a mask is every value but 0"));
  for (const Option* option : particles.options()) {
    if (option->is_set()) return refuse_both(masks, *option, "the files of masks are volumes, not particles");
  }
  if (input.grids.size() < 2) return {};
  return refuse_usage("--masks takes one --grid, the name of the grid in all files",
                      "write each mask to a file of its own");
}

Result<void> take_masks(ConvertFlags& flags) {
  if (!flags.masks) return {};
  TRY(check_mask_input(flags.input, flags.particles, flags.masks));
  const auto refuse = [&](const Option& other, std::string_view why) {
    return other.is_set() ? refuse_both(flags.masks, other, why) : Result<void>();
  };
  TRY(refuse(flags.isos, "masks have no iso value"));
  TRY(refuse(flags.heightfield, "masks are no heights"));
  TRY(refuse(flags.labels.background, "the background of masks is 0"));
  TRY(refuse(flags.labels.names, "the files of the masks give the names"));
  for (const Option* option : flags.batch.options()) {
    if (option == &flags.batch.make_folders) continue;
    TRY(refuse(*option, "all inputs are one conversion, not a sequence"));
  }
  if (!flags.labels.chosen) flags.labels.choose_all(flags.masks.name());
  return {};
}

}  // namespace isoextract::cli
