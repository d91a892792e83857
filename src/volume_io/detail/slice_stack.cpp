#include "volume_io/detail/slice_stack.hpp"

#include <algorithm>
#include <filesystem>
#include <numeric>
#include <tuple>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/ascii.hpp"
#include "base/printable.hpp"
#include "field/demo_field.hpp"
#include "files/file_bytes.hpp"
#include "files/folder_names.hpp"
#include "files/frame_pattern.hpp"
#include "files/natural_order.hpp"

namespace isoextract::volume_io {
namespace {

namespace fs = std::filesystem;

struct NumberedFile {
  std::int64_t number = 0;
  std::string path;
};

bool has_extension_of(const VolumeFormat& format, const std::string& name) {
  const std::string lower = to_lower(name);
  return std::ranges::any_of(format.about().extensions,
                             [&](const std::string& extension) { return lower.ends_with(extension); });
}

// Returns the files that match the pattern; none if its number is in a folder's name.
Result<std::vector<NumberedFile>> matching_files(const files::FramePattern& pattern) {
  const std::string& prefix = pattern.prefix();
  const std::size_t name = prefix.find_last_of('/') + 1;
  std::vector<NumberedFile> found;
  if (pattern.suffix().find('/') != std::string::npos) return found;
  const std::string folder = prefix.substr(0, name);
  const files::FramePattern names(prefix.substr(name), pattern.width(), pattern.suffix());
  TRY(files::visit_folder(folder, [&](const std::string& entry, const fs::directory_entry& at) {
    std::error_code none;
    const auto number = names.match(entry);
    if (number && !at.is_directory(none)) found.push_back({*number, folder + entry});
  }));
  return found;
}

// Returns the number of each name if the names are equal except for their last group of digits.
std::optional<std::vector<std::int64_t>> numbers_of(const std::vector<std::string>& names) {
  const std::string& first = names.front();
  const std::size_t last = first.find_last_of("0123456789", fs::path(first).stem().string().size() - 1);
  if (last == std::string::npos) return std::nullopt;
  const std::size_t before = first.find_last_not_of("0123456789", last);
  const std::size_t begin = before == std::string::npos ? 0 : before + 1;
  const files::FramePattern pattern(first.substr(0, begin), 0, first.substr(last + 1));
  std::vector<std::int64_t> numbers;
  for (const std::string& name : names) {
    const auto number = pattern.match(name);
    if (!number) return std::nullopt;
    numbers.push_back(*number);
  }
  return numbers;
}

// Returns the files of a folder in order; they are numbered from 0 unless their names differ only in one number.
// Returns no files if one has another volume format's extension.
Result<std::vector<NumberedFile>> files_of_folder(const std::string& folder, const VolumeFormat& format) {
  std::vector<std::string> names;
  bool has_others = false;
  TRY(files::visit_folder(folder, [&](const std::string& name, const fs::directory_entry& entry) {
    std::error_code none;
    if (name.starts_with('.') || entry.is_directory(none)) return;
    if (has_extension_of(format, name)) {
      names.push_back(name);
    } else if (std::ranges::any_of(volume_formats(),
                                   [&](const VolumeFormat* other) { return has_extension_of(*other, name); })) {
      has_others = true;
    }
  }));
  std::vector<NumberedFile> found;
  if (names.empty() || has_others) return found;
  std::ranges::sort(names, files::NaturalLess());
  const auto numbers = numbers_of(names);
  const std::string start = folder.ends_with('/') ? folder : folder + '/';
  for (std::size_t i = 0; i < names.size(); ++i) {
    found.push_back({numbers ? (*numbers)[i] : static_cast<std::int64_t>(i), start + names[i]});
  }
  return found;
}

// Fails if numbers are missing or repeat.
Result<void> check_numbers(const std::string& input, const std::vector<NumberedFile>& files) {
  const auto twice = std::ranges::adjacent_find(files, {}, &NumberedFile::number);
  if (twice != files.end()) {
    return fail(ErrorCode::input,
                fmt::format("{}: expected one file for slice {}, found {} and {}", printable(input), twice->number,
                            printable(twice->path), printable(std::next(twice)->path)));
  }
  std::int64_t step = 0;
  for (std::size_t i = 1; i < files.size(); ++i) step = std::gcd(step, files[i].number - files[i - 1].number);
  constexpr std::size_t kMostShown = 10;
  std::vector<std::string> missing;
  for (std::size_t i = 1; i < files.size() && missing.size() <= kMostShown; ++i) {
    const std::int64_t first = files[i - 1].number + step;
    const std::int64_t last = files[i].number - step;
    if (first > last) continue;
    missing.push_back(first == last ? fmt::format("{}", first) : fmt::format("{} to {}", first, last));
  }
  if (missing.empty()) return {};
  if (missing.size() > kMostShown) missing.back() = "...";
  return fail(ErrorCode::input,
              fmt::format("{}: expected a file for every slice from {} to {}, found none for {}", printable(input),
                          files.front().number, files.back().number, fmt::join(missing, ", ")),
              "add the missing files: the distances between slices must be equal");
}

// Returns whether the file is a single picture; nullopt if it cannot be read.
std::optional<bool> is_picture(const VolumeFormat& format, const std::string& path, const Context& context) {
  const auto grids = format.list(path, {}, context);
  // A missing plug-in is reported when the stack is read.
  if (!grids) return grids.error().code == ErrorCode::unavailable ? std::optional(true) : std::nullopt;
  return std::ranges::all_of(
      *grids, [](const GridInfo& grid) { return grid.volumes == 1 && grid.box.min.z == grid.box.max.z; });
}

// Returns the files in order, without checks of their numbers; fewer than two for inputs that are no stack.
Result<std::vector<NumberedFile>> list_files(const std::string& input, const VolumeFormat& format) {
  std::vector<NumberedFile> found;
  if (input.empty() || input.starts_with(field::kDemoPrefix) || files::is_standard_input(input)) return found;
  std::error_code none;
  const fs::file_status status = fs::status(input, none);
  if (fs::is_directory(status)) {
    found = TRY(files_of_folder(input, format));
  } else if (!fs::exists(status) && has_extension_of(format, input)) {
    const auto pattern = files::FramePattern::parse(input);
    if (!pattern || !*pattern) return found;
    auto matched = matching_files(**pattern);
    if (matched) found = std::move(*matched);  // else the search for frames reports that the folder is missing
  }
  std::ranges::sort(found, {}, [](const NumberedFile& file) { return std::tie(file.number, file.path); });
  return found;
}

}  // namespace

Result<std::optional<std::vector<std::string>>> find_slices(const std::string& input, const VolumeFormat& format) {
  using Slices = std::optional<std::vector<std::string>>;
  auto found = TRY(list_files(input, format));
  if (found.size() < 2) return Slices();
  TRY(check_numbers(input, found));
  std::vector<std::string> paths;
  for (NumberedFile& file : found) paths.push_back(std::move(file.path));
  return Slices(std::move(paths));
}

const VolumeFormat* format_of_stack(const std::string& input, const Context& context) {
  for (const VolumeFormat* format : volume_formats()) {
    if (!format->about().takes_slices) continue;
    const auto files = list_files(input, *format);
    if (!files || files->size() < 2) continue;
    const auto first = is_picture(*format, files->front().path, context);
    const auto known = first ? first : is_picture(*format, files->back().path, context);
    if (known.value_or(false)) return format;
  }
  return nullptr;
}

}  // namespace isoextract::volume_io
