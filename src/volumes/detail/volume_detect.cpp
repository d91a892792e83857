#include "volumes/detail/volume_detect.hpp"

#include <algorithm>
#include <cctype>
#include <optional>

#include <fmt/format.h>

#include "volumes/detail/volume_format.hpp"

namespace isoextract::volumes {
namespace {

std::optional<VolumeFormat> format_by_content(std::span<const std::byte> content, bool inflated) {
  if (looks_like_nifti(content)) return VolumeFormat::nifti;
  // Only NIfTI is compressed as a whole.
  if (inflated) return std::nullopt;
  if (looks_like_vdb(content)) return VolumeFormat::vdb;
  if (looks_like_nrrd(content)) return VolumeFormat::nrrd;
  if (looks_like_npy(content)) return VolumeFormat::npy;
  return std::nullopt;
}

// The longest extension that a format claims, whatever its case.
std::optional<VolumeFormat> format_by_extension(const std::filesystem::path& path) {
  std::string name = path.filename().string();
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  for (const VolumeFormatInfo& info : volume_formats()) {
    std::string_view rest = info.extensions;
    while (!rest.empty()) {
      const std::size_t end = std::min(rest.find(' '), rest.size());
      if (name.ends_with(rest.substr(0, end))) return info.format;
      rest.remove_prefix(std::min(end + 1, rest.size()));
    }
  }
  return std::nullopt;
}

tl::unexpected<Error> fail_unknown(const files::InputFile& file, std::span<const std::byte> content) {
  std::string hint = "it reads";
  for (const VolumeFormatInfo& info : volume_formats()) {
    if (!info.extensions.empty()) hint += fmt::format("\n  {:<6} {} ({})", info.name, info.title, info.extensions);
  }
  return fail(ErrorKind::input,
              fmt::format("{}: not a volume format that isoextract reads; it starts with '{}'", file.name(),
                          files::printable(content, 16)),
              Hint(hint));
}

}  // namespace

std::string_view volume_format_name(VolumeFormat format) {
  return std::ranges::find(volume_formats(), format, &VolumeFormatInfo::format)->name;
}

Result<DetectedFormat> detect_format(const files::InputFile& file, const ReadOptions& options) {
  if (options.format) {
    if (*options.format == VolumeFormat::demo) {
      return fail(ErrorKind::usage, file.name() + ": --input-format demo is for inputs named demo:NAME");
    }
    return DetectedFormat{*options.format, {}};
  }
  std::byte start[2] = {};
  if (file.size() >= sizeof start) {
    if (auto read = file.read_at(0, start); !read) return tl::unexpected(read.error());
  }
  const auto content = files::first_bytes(file, kDetectionBytes);
  if (!content) return tl::unexpected(content.error());
  const auto by_content = format_by_content(*content, files::is_gzip(start));
  const auto by_extension = format_by_extension(file.path());
  if (by_content) {
    DetectedFormat detected{*by_content, {}};
    if (by_extension && *by_extension != *by_content) {
      detected.note = fmt::format("read as {} by its content, although it is named {}", volume_format_name(*by_content),
                                  file.path().filename().string());
    }
    return detected;
  }
  if (options.raw) return DetectedFormat{VolumeFormat::raw, {}};
  // The reader of that format says what is wrong with the content.
  if (by_extension) return DetectedFormat{*by_extension, {}};
  return fail_unknown(file, *content);
}

bool starts_with(std::span<const std::byte> content, std::string_view magic) {
  return content.size() >= magic.size() &&
         std::equal(magic.begin(), magic.end(), content.begin(),
                    [](char m, std::byte b) { return static_cast<std::byte>(m) == b; });
}

tl::unexpected<Error> fail_magic(const files::InputFile& file, std::string_view format, std::string_view expected) {
  const auto content = files::first_bytes(file, kDetectionBytes);
  return fail(ErrorKind::input, fmt::format("{}: not {}: expected {} at the start, found '{}'", file.name(), format,
                                            expected, content ? files::printable(*content, 16) : std::string()));
}

}  // namespace isoextract::volumes
