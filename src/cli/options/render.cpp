#include "cli/options/render.hpp"

#include <fmt/ranges.h>

#include "render/antialias.hpp"

namespace isoextract::cli {

std::vector<std::string> transfer_names() {
  std::vector<std::string> names = words_of_choices(choices_of_words<render::BuiltInTransfer>());
  names.emplace_back("none");
  return names;
}

std::optional<render::BuiltInTransfer> transfer_of(std::string_view name) {
  return name == "grey" ? render::BuiltInTransfer::gray : value_of<render::BuiltInTransfer>(name);
}

TransferOption::TransferOption(const Place& place)
    : Value(place, "--tf", "NAME|FILE", parse_text,
            fmt::format("Transfer function of the volume (default: {}). {} to leave the volume out, or a file with "
                        "lines of value, red, green, blue and opacity.",
                        word_of(render::BuiltInTransfer{}), fmt::join(transfer_names(), ", "))) {}

Result<std::array<double, 2>> parse_value_range(std::string_view text) {
  const auto numbers = parse_numbers(text);
  if (numbers && numbers->size() == 2 && (*numbers)[0] < (*numbers)[1]) return std::array{(*numbers)[0], (*numbers)[1]};
  return fail(ErrorCode::usage, fmt::format("expected two values MIN,MAX with MIN below MAX, found '{}'", text));
}

Result<EmissionChoice> parse_emission(std::string_view text) {
  const std::size_t colon = text.rfind(':');
  const std::string_view rest = colon == std::string_view::npos ? "" : text.substr(colon + 1);
  const bool has_range = rest.find(',') != std::string_view::npos && rest.find_first_of("0123456789.+-") == 0;
  EmissionChoice choice;
  choice.grid = has_range ? text.substr(0, colon) : text;
  if (choice.grid.empty()) {
    return fail(ErrorCode::usage, fmt::format("expected the name of a grid, and :MIN,MAX if its values are no kelvins, "
                                              "found '{}'",
                                              text));
  }
  if (has_range) {
    choice.range = TRY(parse_value_range(rest));
  }
  return choice;
}

Result<double> parse_samples(std::string_view text) {
  const auto samples = parse_number(text);
  if (samples && *samples >= 1.0 / 64 && *samples <= 64) return *samples;
  return fail(ErrorCode::usage,
              fmt::format("expected a number of samples per voxel, from 0.015625 to 64, found '{}'", text));
}

Result<int> parse_rays_across(std::string_view text) {
  const auto rays = parse_positive_count(text);
  if (rays && *rays <= render::kMostRaysAcross) return static_cast<int>(*rays);
  return fail(ErrorCode::usage,
              fmt::format("expected a whole number from 1 to {}, found '{}'", render::kMostRaysAcross, text));
}

Result<double> parse_termination(std::string_view text) {
  const auto share = parse_number(text);
  if (share && *share >= 0 && *share < 1) return *share;
  return fail(ErrorCode::usage, fmt::format("expected a number, 0 or more and below 1, found '{}'", text));
}

RenderFlags::RenderFlags() = default;

}  // namespace isoextract::cli
