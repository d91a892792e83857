#include "particle_io/detail/vtk_cells.hpp"

#include <algorithm>
#include <charconv>
#include <optional>
#include <span>
#include <string>

#include "particle_io/detail/particle_source.hpp"

namespace isoextract::particle_io {
namespace {

constexpr std::uint64_t kPartBytes = 1 << 20;

std::optional<std::uint64_t> number_after(std::string_view text, std::string_view key) {
  const std::size_t at = text.find(key);
  if (at == std::string_view::npos) return std::nullopt;
  const std::string_view rest = text.substr(at + key.size());
  std::uint64_t number = 0;
  const auto [end, status] = std::from_chars(rest.data(), rest.data() + rest.size(), number);
  return status == std::errc{} ? std::optional(number) : std::nullopt;
}

std::string bytes_at(const files::InputFile& file, std::uint64_t offset, std::uint64_t most) {
  std::string bytes(offset < file.size() ? std::min(most, file.size() - offset) : 0, '\0');
  if (!bytes.empty()) must(file.read_at(offset, std::as_writable_bytes(std::span(bytes))));
  return bytes;
}

// Returns the offset after the line of the first `word` from `offset` on.
std::optional<std::uint64_t> find_line_end(const files::InputFile& file, std::uint64_t offset, std::string_view word) {
  std::string part;
  while (offset < file.size()) {
    part = bytes_at(file, offset, kPartBytes);
    const std::size_t at = part.find(word);
    const std::size_t end = at == std::string::npos ? at : part.find('\n', at + word.size());
    if (end != std::string::npos) return offset + end + 1;
    // A part may end in the middle of the word or its line, so parts overlap.
    constexpr std::size_t kOverlap = 256;
    if (part.size() <= kOverlap) return std::nullopt;
    offset += part.size() - kOverlap;
  }
  return std::nullopt;
}

bool has_legacy_cells(const files::InputFile& file, std::string_view start) {
  constexpr std::string_view kPoints = "\nPOINTS ";
  const std::size_t points = start.find(kPoints);
  const auto count = number_after(start, kPoints);
  const std::size_t line_end = points == std::string_view::npos ? points : start.find('\n', points + 1);
  if (!count || line_end == std::string_view::npos) return false;
  const std::string_view line = start.substr(points, line_end - points);
  const bool is_binary = start.find("\nBINARY") < points;
  std::uint64_t offset = line_end + 1;
  if (is_binary && *count < file.size()) offset += *count * 3 * (line.find("double") != std::string_view::npos ? 8 : 4);
  const auto types = find_line_end(file, offset, "\nCELL_TYPES ");
  if (!types) return false;
  const std::string first = bytes_at(file, *types, 16);
  constexpr std::uint64_t kPolyVertex = 2;  // 0: empty, 1: a vertex
  if (is_binary) {
    return first.size() >= 4 &&
           (first[0] != 0 || first[1] != 0 || first[2] != 0 || static_cast<unsigned char>(first[3]) > kPolyVertex);
  }
  return number_after(first, "").value_or(0) > kPolyVertex;
}

}  // namespace

bool has_vtk_cells(const files::InputFile& file, std::string_view start) {
  if (start.starts_with("# vtk")) {
    return start.find("DATASET UNSTRUCTURED_GRID") != std::string_view::npos && has_legacy_cells(file, start);
  }
  if (start.find("\"UnstructuredGrid\"") == std::string_view::npos) return false;
  const auto points = number_after(start, "NumberOfPoints=\"");
  const auto cells = number_after(start, "NumberOfCells=\"");
  // A file of points has one cell per point, or one cell for all points.
  return points && cells && *cells > 1 && *cells != *points;
}

}  // namespace isoextract::particle_io
