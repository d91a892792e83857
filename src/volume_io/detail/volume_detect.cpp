#include "volume_io/detail/volume_detect.hpp"

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/ascii.hpp"
#include "base/printable.hpp"
#include "files/file_bytes.hpp"
#include "files/unpacked_files.hpp"
#include "plugin_host/unpacked_input.hpp"
#include "volume_io/detail/formats.hpp"
#include "volume_io/detail/slice_stack.hpp"
#include "volume_io/detail/unsupported_format.hpp"
#include "volume_io/volume_reader.hpp"

namespace isoextract::volume_io {
namespace {

const VolumeFormat* format_by_prefix(const std::string& input) {
  for (const VolumeFormat* format : volume_formats()) {
    const std::string& prefix = format->about().prefix;
    if (!prefix.empty() && input.starts_with(prefix)) return format;
  }
  return nullptr;
}

const VolumeFormat* format_by_content(const files::FileStart& start) {
  for (const VolumeFormat* format : volume_formats()) {
    if (format->probe(start)) return format;
  }
  return nullptr;
}

// Returns the first format that has the name's ending, ignoring case.
const VolumeFormat* format_by_extension(const std::filesystem::path& path) {
  const std::string name = to_lower(files::name_without_packing(path.filename().string()));
  for (const VolumeFormat* format : volume_formats()) {
    const auto claims = [&](const std::string& extension) { return name.ends_with(extension); };
    if (std::ranges::any_of(format->about().extensions, claims)) return format;
  }
  return nullptr;
}

std::optional<Error> error_of_unread(const files::InputFile& file, std::span<const std::byte> content) {
  const auto known = find_unsupported_format(file.path(), content);
  if (!known) return std::nullopt;
  return Error{ErrorCode::input,
               fmt::format("{}: its {} says that it is {}, which isoextract does not read", file.name(),
                           known->by_name ? "name" : "content", known->title),
               Hint(known->way)};
}

tl::unexpected<Error> fail_unknown(const files::InputFile& file, std::span<const std::byte> content) {
  if (auto known = error_of_unread(file, content)) return tl::unexpected(std::move(*known));
  std::string hint = "isoextract reads";
  for (const VolumeFormat* format : volume_formats()) {
    const FormatDescription& about = format->about();
    if (about.extensions.empty()) continue;
    hint += fmt::format("\n  {:<6} {} ({})", about.id, about.title, fmt::join(about.extensions, " "));
  }
  return fail(ErrorCode::input,
              fmt::format("{}: not a volume format that isoextract reads; it starts with '{}'", file.name(),
                          printable(content, 16)),
              Hint(hint));
}

Result<DetectedFormat> chosen_format(const std::string& input, const std::string& id) {
  const VolumeFormat* format = find_volume_format(id);
  if (format == nullptr) return fail(ErrorCode::usage, fmt::format("{}: there is no volume format '{}'", input, id));
  const std::string& prefix = format->about().prefix;
  if (!prefix.empty()) {
    return fail(ErrorCode::usage,
                fmt::format("{}: the format {} reads only inputs whose names start with {}", input, id, prefix));
  }
  return DetectedFormat{format, {}};
}

Result<const VolumeFormat*> known_by_content(const files::InputFile& file, std::span<const std::byte> content) {
  std::byte start[2] = {};
  if (file.size() >= sizeof start) {
    TRY(file.read_at(0, start));
  }
  const files::FileStart begin{file.path(), content, files::is_gzip(start)};
  // Several formats may claim the content: netCDF-4 files are HDF5 files.
  const VolumeFormat* const named = format_by_extension(file.path());
  if (named != nullptr && named->probe(begin)) return named;
  return format_by_content(begin);
}

bool is_folder(const std::string& input) {
  std::error_code none;
  return !files::is_standard_input(input) && std::filesystem::is_directory(input, none);
}

// Returns whether the name is that of a volume that needs no options; a header counts, its data file does not.
bool has_name_of_volume(const std::filesystem::path& path) {
  const VolumeFormat* format = format_by_extension(path);
  return format != nullptr && !format->about().needs_layout;
}

// Returns the only file in an unpacked archive whose name is that of a volume, such as a header beside its data; the
// folder itself if there is none or several.
std::string only_volume_in(const std::string& folder) {
  namespace fs = std::filesystem;
  std::string found;
  std::error_code error;
  for (fs::recursive_directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    std::error_code none;
    if (!at->is_regular_file(none) || !has_name_of_volume(at->path())) continue;
    if (!found.empty()) return folder;
    found = at->path();
  }
  return found.empty() ? folder : found;
}

Result<DetectedFormat> format_of_folder(const std::string& input, const ReadOptions& options, const Context& context) {
  if (options.format) return chosen_format(input, *options.format);
  for (const VolumeFormat* format : volume_formats()) {
    if (format->probe_folder(input, context)) return DetectedFormat{format, {}};
  }
  if (files::packed_source(input) != input) {
    return tl::unexpected(plugin_host::not_one_input(input, input, has_name_of_volume));
  }
  return fail(ErrorCode::input,
              fmt::format("{}: expected a file, or a folder that is one volume, found a folder that is none",
                          files::input_label(input)),
              "give one of its files, or the slices of a volume as a pattern, such as 'FOLDER/slice_{}.png'");
}

// Returns whether the format takes the files of a pattern as slices.
bool is_pattern_of(const std::string& id, const std::string& input) {
  const VolumeFormat* const format = find_volume_format(id);
  if (format == nullptr || !format->about().takes_slices) return false;
  const auto slices = find_slices(input, *format);
  return !slices || *slices;
}

}  // namespace

bool is_named_by_prefix(const std::string& input) { return format_by_prefix(input) != nullptr; }

Result<DetectedFormat> detect_format(const std::string& input, const ReadOptions& options, const Context& context) {
  if (const VolumeFormat* format = format_by_prefix(input)) return DetectedFormat{format, {}};
  if (!options.format) {
    if (const VolumeFormat* format = format_of_stack(input, context)) return DetectedFormat{format, {}};
  }
  if (is_folder(input)) return format_of_folder(input, options, context);
  if (options.format && is_pattern_of(*options.format, input)) return chosen_format(input, *options.format);
  const auto file = TRY(files::InputFile::open(input, context));
  if (options.format) return chosen_format(file.name(), *options.format);
  const auto content = TRY(files::first_bytes(file, files::kStartBytes));
  const auto known = TRY(known_by_content(file, content));
  const VolumeFormat* by_content = known;
  const VolumeFormat* by_extension = format_by_extension(file.path());
  if (by_content != nullptr) {
    DetectedFormat detected{by_content, {}};
    if (by_extension != nullptr && by_extension != by_content) {
      detected.note = fmt::format("read as {} by its content, although it is named {}", by_content->about().id,
                                  file.path().filename().string());
    }
    return detected;
  }
  if (options.raw) return DetectedFormat{&raw_format(), {}};
  // The format's reader reports what is wrong with the content.
  if (by_extension != nullptr) return DetectedFormat{by_extension, {}};
  return fail_unknown(file, content);
}

std::optional<std::string> folder_of_marker(const std::string& input, const Context& context) {
  std::error_code none;
  const std::filesystem::path path(input);
  if (files::is_standard_input(path) || !std::filesystem::is_regular_file(path, none) ||
      std::filesystem::file_size(path, none) != 0) {
    return std::nullopt;
  }
  const VolumeFormat* const format = format_by_extension(path);
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
  if (format == nullptr || !format->probe_folder(folder, context)) return std::nullopt;
  return folder.string();
}

bool has_volume_extension(const std::filesystem::path& path) { return format_by_extension(path) != nullptr; }

bool has_picture_extension(const std::filesystem::path& path) {
  const VolumeFormat* const format = format_by_extension(path);
  return format != nullptr && format->about().takes_slices;
}

std::optional<Error> unsupported_format_error(const std::filesystem::path& path, const Context& context) {
  const auto file = files::InputFile::open(path, context);
  if (!file) return std::nullopt;
  const auto content = files::first_bytes(*file, files::kStartBytes);
  return content ? error_of_unread(*file, *content) : std::nullopt;
}

Result<std::string> unpack_for_volumes(const std::string& input, const ReadOptions& options, const Context& context) {
  using plugin_host::GzipFiles;
  std::error_code none;
  const bool may_be_file = files::is_standard_input(input) || std::filesystem::is_regular_file(input, none);
  const auto file = may_be_file ? files::InputFile::open(input, context) : tl::unexpected(Error());
  std::byte start[2] = {};
  GzipFiles gzip = GzipFiles::keep;
  if (file && file->size() >= sizeof start && file->read_at(0, start) && files::is_gzip(start)) {
    const auto content = TRY(files::first_bytes(*file, files::kStartBytes));
    const std::filesystem::path inner = file->path().stem();  // without .gz
    const bool is_streamed = format_by_content({file->path(), content, true}) != nullptr;
    const VolumeFormat* chosen = options.format ? find_volume_format(*options.format) : nullptr;
    const bool is_claimed = format_by_content({inner, content, false}) != nullptr || options.raw || chosen != nullptr;
    if (files::is_tar(content) || (!is_streamed && is_claimed)) gzip = GzipFiles::unpack;
  }
  auto path = plugin_host::unpacked_input(input, gzip, context);  // not const: a copy of a Result must not fail
  if (!path || *path == input || !is_folder(*path) || is_volume_folder(*path, context)) return path;
  return only_volume_in(*path);
}

Result<bool> has_volume_content(const std::string& input, const Context& context) {
  if (format_of_stack(input, context) != nullptr) return true;
  if (is_folder(input)) return is_volume_folder(input, context);
  const auto file = TRY(files::InputFile::open(input, context));
  const auto content = TRY(files::first_bytes(file, files::kStartBytes));
  const auto known = TRY(known_by_content(file, content));
  return known != nullptr;
}

}  // namespace isoextract::volume_io
