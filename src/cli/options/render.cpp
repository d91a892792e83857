#include "cli/options/render.hpp"

#include <charconv>
#include <optional>

#include <fmt/ranges.h>

#include "base/srgb.hpp"

namespace isoextract::cli {
namespace {

// RRGGBB as screens have it, as linear light.
std::optional<glm::dvec3> color_in(std::string_view text) {
  if (text.starts_with('#')) text.remove_prefix(1);
  unsigned rgb = 0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), rgb, 16);
  if (text.size() != 6 || problem != std::errc() || end != text.data() + text.size()) return std::nullopt;
  const auto channel = [&](unsigned shift) { return srgb_to_linear((rgb >> shift & 0xFFU) / 255.0); };
  return glm::dvec3(channel(16), channel(8), channel(0));
}

}  // namespace

std::string transfer_list() {
  std::vector<std::string_view> names;
  for (const auto& word : words_of(render::BuiltInTransfer{})) names.push_back(word.word);
  return fmt::format("{}", fmt::join(names, ", "));
}

Result<glm::dvec4> parse_background(std::string_view text) {
  if (text == "none") return glm::dvec4(0);
  const auto color = color_in(text == "black" ? "000000" : text == "white" ? "ffffff" : text);
  if (color) return glm::dvec4(*color, 1);
  return fail(ErrorCode::usage, fmt::format("expected none, black, white or a color as RRGGBB, found '{}'", text));
}

Result<std::vector<glm::dvec3>> parse_colors(std::string_view text) {
  std::vector<glm::dvec3> colors;
  for (std::string_view rest = text;;) {
    const std::size_t comma = rest.find(',');
    const auto color = color_in(rest.substr(0, comma));
    if (!color) return fail(ErrorCode::usage, fmt::format("expected colors as RRGGBB[,RRGGBB...], found '{}'", text));
    colors.push_back(*color);
    if (comma == std::string_view::npos) return colors;
    rest.remove_prefix(comma + 1);
  }
}

Result<std::array<double, 2>> parse_value_range(std::string_view text) {
  const auto numbers = parse_numbers(text);
  if (numbers && numbers->size() == 2 && (*numbers)[0] < (*numbers)[1]) return std::array{(*numbers)[0], (*numbers)[1]};
  return fail(ErrorCode::usage, fmt::format("expected two values MIN,MAX with MIN below MAX, found '{}'", text));
}

Result<double> parse_field_of_view(std::string_view text) {
  const auto degrees = parse_number(text);
  if (degrees && *degrees >= 1 && *degrees <= 170) return *degrees;
  return fail(ErrorCode::usage, fmt::format("expected degrees from 1 to 170, found '{}'", text));
}

Result<double> parse_samples(std::string_view text) {
  const auto samples = parse_number(text);
  if (samples && *samples >= 1.0 / 64 && *samples <= 64) return *samples;
  return fail(ErrorCode::usage,
              fmt::format("expected a number of samples per voxel, from 0.015625 to 64, found '{}'", text));
}

Result<double> parse_termination(std::string_view text) {
  const auto share = parse_number(text);
  if (share && *share >= 0 && *share < 1) return *share;
  return fail(ErrorCode::usage, fmt::format("expected a number, 0 or more and below 1, found '{}'", text));
}

RenderFlags::RenderFlags() = default;

}  // namespace isoextract::cli
