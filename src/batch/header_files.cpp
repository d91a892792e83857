#include "batch/header_files.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <iterator>
#include <string_view>
#include <system_error>
#include <unordered_set>

namespace isoextract::batch {
namespace {

namespace fs = std::filesystem;

// Returns the paths that the header of a file with samples alone may have; none for other files.
std::vector<std::string> headers_of(fs::path file) {
  if (file.extension() == ".gz" || file.extension() == ".bz2") file.replace_extension();
  constexpr std::array<std::string_view, 4> kData{".raw", ".zraw", ".img", ".dat"};
  if (std::ranges::find(kData, file.extension().string()) == kData.end()) return {};
  std::vector<std::string> headers;
  for (const std::string_view extension : {".nhdr", ".mhd", ".hdr", ".ini"}) {
    headers.push_back(file.replace_extension(extension).string());
  }
  return headers;
}

}  // namespace

bool has_header_beside(const std::string& folder, const std::string& name) {
  return std::ranges::any_of(headers_of(fs::path(folder) / name), [](const std::string& header) {
    std::error_code none;
    return fs::exists(header, none);
  });
}

std::vector<std::string> without_sample_files(std::span<const std::string> inputs) {
  const std::unordered_set<std::string> listed(inputs.begin(), inputs.end());
  std::vector<std::string> others;
  std::ranges::copy_if(inputs, std::back_inserter(others), [&](const std::string& input) {
    return std::ranges::none_of(headers_of(input), [&](const std::string& header) { return listed.contains(header); });
  });
  return others;
}

}  // namespace isoextract::batch
