#include "plugin_host/unpacked_input.hpp"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <unistd.h>

#include "base/ascii.hpp"
#include "base/checked.hpp"
#include "base/counted.hpp"
#include "base/printable.hpp"
#include "files/file_bytes.hpp"
#include "files/file_start.hpp"
#include "files/natural_order.hpp"
#include "files/unpacked_files.hpp"
#include "plugin_host/plugin_kinds.hpp"
#include "plugin_host/plugin_samples.hpp"
#include "plugin_host/plugin_session.hpp"

namespace isoextract::plugin_host {
namespace {

namespace fs = std::filesystem;
using namespace std::string_view_literals;

constexpr const char* kArchivePlugin = "archive";

// Judges by the content; also by the name for zip files, and for gzip files unless `gzip` says to unpack all.
bool is_packed(std::string_view content, const std::string& name, GzipFiles gzip) {
  const std::string lower = to_lower(name);
  const bool is_tar_name = lower.ends_with(".tgz") || lower.find(".tar.") != std::string::npos;
  const bool is_bzip2 =
      content.starts_with("BZh") && content.substr(std::min<std::size_t>(4, content.size())).starts_with("1AY&SY");
  const bool is_xz = content.starts_with(
      "\xFD"
      "7zXZ\0"sv);
  const bool is_zstd = content.starts_with("\x28\xB5\x2F\xFD");
  const bool is_gzip = content.starts_with("\x1F\x8B");
  if (is_xz || is_zstd || is_bzip2 || (is_gzip && (gzip == GzipFiles::unpack || is_tar_name))) return true;
  if (files::is_tar(std::as_bytes(std::span(content)))) return true;
  if (!lower.ends_with(".zip") || !content.starts_with("PK\3\4"sv)) return false;
  const auto has = [&](std::string_view text) { return content.find(text) != std::string_view::npos; };
  const bool is_zarr = has("zarr.json") || has(".zgroup") || has(".zarray") || has(".zattrs");
  return !is_zarr;
}

const PluginLibrary& archive_library() {
  static const PluginLibrary library(kUnpackPlugins, kArchivePlugin, plugin_folders(), "libarchive-dev");
  return library;
}

// Returns the file's name without the extension of its compression; "stdin" for standard input.
std::string name_of_content(const files::InputFile& file) {
  if (files::is_standard_input(file.path())) return "stdin";
  return files::name_without_packing(file.path().filename());
}

Result<std::shared_ptr<const files::UnpackedFiles>> unpack(const files::InputFile& file, std::vector<std::byte> start) {
  const Context& context = file.context();
  context.progress().begin("unpacking", 0);
  VolumeInput wanted;
  wanted.name = file.name();
  wanted.path = files::openable_path(file);
  wanted.start = std::move(start);
  wanted.bytes = file.size();
  wanted.context = context;
  const auto session = TRY(open_volume_session(archive_library(), kArchivePlugin, wanted));
  const isoextract_volume_list& list = session->list();
  const auto invalid = [&] {
    return fail(ErrorCode::input, fmt::format("{}: the plug-in for archives returns an invalid list", file.name()));
  };
  if (list.count < 2 || list.grids == nullptr) return invalid();
  std::vector<files::UnpackedMember> members;
  std::optional<std::uint64_t> total = 0;
  for (std::size_t i = 1; i < list.count; ++i) {
    const isoextract_volume_grid& grid = list.grids[i];
    members.push_back({plugin_text(grid.name), grid.dims[0]});
    total = checked_sum(*total, grid.dims[0]);
    if (!total) return invalid();
  }
  if (*total != list.grids[0].dims[0]) return invalid();
  if (*total == 0) return fail(ErrorCode::input, file.name() + ": the compressed file or archive contains no data");
  const bool as_file = members.size() == 1;
  // The content of a compressed file has no name of its own; the members of an archive have names.
  if (as_file && members.front().name.empty()) members.front().name = name_of_content(file);

  const auto memory = TRY(context.reserve(*total, fmt::format("{}: {} unpacked bytes", file.name(), *total)));
  VolumeSelection selection;
  selection.count = {*total, 1, 1};
  selection.box_bytes = *total;
  const SessionSamples samples = TRY(session->open(selection));
  TRY(session->finish());
  if (samples.samples->filled != *total) return invalid();
  const std::span content(static_cast<const std::byte*>(samples.box), static_cast<std::size_t>(*total));
  return files::UnpackedFiles::make(file.path(), members, content, as_file, context);
}

// Returns the names of the files in the folder for which is_wanted() is true, relative to it, in natural order.
std::vector<std::string> files_in(const fs::path& folder, const std::function<bool(const fs::path&)>& is_wanted) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::recursive_directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    std::error_code none;
    if (!at->is_regular_file(none) || !is_wanted(at->path())) continue;
    names.push_back(at->path().lexically_relative(folder).string());
  }
  std::ranges::sort(names, files::NaturalLess());
  return names;
}

// Returns "a.npy, b.npy, c.npy and 4 more".
std::string first_names(const std::vector<std::string>& names) {
  constexpr std::size_t kMost = 3;
  std::string text;
  for (const std::string& name : std::span(names).first(std::min(names.size(), kMost))) {
    text += fmt::format("{}{}", text.empty() ? "" : ", ", printable(name, 100));
  }
  return names.size() > kMost ? fmt::format("{} and {} more", text, names.size() - kMost) : text;
}

// Returns " with 'unzip two.zip'"; nothing for standard input and for names that a shell would not take as they are.
std::string unpack_command(const fs::path& archive) {
  const std::string path = archive.string();
  const auto is_plain = [](char c) {
    return is_digit(c) || is_letter(c) || "._-+/"sv.find(c) != std::string_view::npos;
  };
  if (files::is_standard_input(archive) || !std::ranges::all_of(path, is_plain) || path.starts_with('-')) return "";
  return fmt::format(" with '{} {}'", to_lower(path).ends_with(".zip") ? "unzip" : "tar -xf", path);
}

}  // namespace

Result<std::string> unpacked_input(const std::string& input, GzipFiles gzip, const Context& context) {
  std::error_code none;
  if (!files::is_standard_input(input) && !std::filesystem::is_regular_file(input, none)) return input;
  const auto file = files::InputFile::open(input, context);
  if (!file) return input;
  std::vector<std::byte> start(static_cast<std::size_t>(std::min<std::uint64_t>(file->size(), files::kStartBytes)));
  // Avoids read_at(), which would count these bytes as bytes of the volume.
  const ssize_t got = ::pread(file->descriptor(), start.data(), start.size(), 0);
  if (got != static_cast<ssize_t>(start.size())) return input;
  const std::string_view content(reinterpret_cast<const char*>(start.data()), start.size());
  if (!is_packed(content, file->path().filename(), gzip)) return input;
  auto unpacked = files::find_unpacked(*file);
  if (!unpacked) {
    unpacked = TRY(unpack(*file, std::move(start)));
    files::keep_unpacked(*file, unpacked);
  }
  return unpacked->path().string();
}

Error not_one_input(const std::string& input, const fs::path& folder,
                    const std::function<bool(const fs::path&)>& is_input) {
  const std::vector<std::string> inputs = files_in(folder, is_input);
  const std::vector<std::string> all = inputs.empty() ? files_in(folder, [](const fs::path&) { return true; }) : inputs;
  const std::string found = inputs.empty() ? "none among " + counted(all.size(), "file") : counted(all.size(), "input");
  return {
      ErrorCode::input,
      fmt::format("{}: expected the files of one input in the archive, such as the slices of a volume, found {}: {}",
                  files::input_label(input), found, first_names(all)),
      fmt::format("unpack the archive{}, then give one of its files, or the folder of one input",
                  unpack_command(files::packed_source(folder)))};
}

bool has_no_input(const fs::path& folder, const std::function<bool(const fs::path&)>& is_input) {
  return files_in(folder, is_input).empty();
}

}  // namespace isoextract::plugin_host
