// Readers of image files: each opens one file as a volume. A single picture is a volume of one slice. Row 0 is y 0.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <volume_reader.hpp>

namespace isoextract_plugin {

[[nodiscard]] std::unique_ptr<VolumeFile> open_tiff(const std::string& path, const isoextract_plugin_host& host);

// Decides whether an OpenEXR file of the channels R, G, B (and A) is one gray image, which is listed as channel R.
// `equal` decides if it is set. Else the image is gray if R, G and B are equal and A is 1, in the file and in the
// stack's files `compared`.
struct RgbRule {
  std::vector<std::string> compared;
  std::optional<bool> equal;
};
[[nodiscard]] std::unique_ptr<VolumeFile> open_exr(const std::string& path, const RgbRule& rule,
                                                   const isoextract_plugin_host& host);

[[nodiscard]] std::unique_ptr<VolumeFile> open_png(const std::string& path, const isoextract_plugin_host& host);

[[nodiscard]] bool is_tiff(const unsigned char* start, std::size_t bytes);
[[nodiscard]] bool is_exr(const unsigned char* start, std::size_t bytes);
[[nodiscard]] bool is_png(const unsigned char* start, std::size_t bytes);

[[nodiscard]] inline bool starts_with(const unsigned char* start, std::size_t bytes, std::string_view magic) {
  return bytes >= magic.size() && std::memcmp(start, magic.data(), magic.size()) == 0;
}

// Returns the size of a file in bytes.
[[nodiscard]] std::uint64_t file_size_of(const std::string& path);

// Throws ReadError if `sample_bytes` of samples do not fit into the file even if compressed by `ratio` : 1.
void check_file_holds(std::uint64_t file_size, std::uint64_t sample_bytes, std::uint64_t ratio);

// Returns the product, or throws if it exceeds 2^62.
[[nodiscard]] std::uint64_t checked_product(std::uint64_t a, std::uint64_t b);

// Returns width, height and sample type of a grid for users.
[[nodiscard]] std::string dims_text(const Grid& grid);

}  // namespace isoextract_plugin
