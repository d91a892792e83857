#include "cli/values.hpp"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <optional>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/byte_size.hpp"
#include "base/nearest_name.hpp"
#include "base/printable.hpp"
#include "convert/conversion_size.hpp"
#include "convert/label_selection.hpp"
#include "simulate/terrain.hpp"

namespace isoextract::cli {
namespace {

constexpr int kMaxThreads = 1024;

tl::unexpected<Error> expected_found(std::string_view expected, std::string_view found) {
  return fail(ErrorCode::usage, fmt::format("expected {}, found '{}'", expected, found));
}

template <class T>
std::optional<T> whole_text_as(std::string_view text) {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  T value{};
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (status != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::vector<std::string_view> split(std::string_view text, std::string_view separators) {
  std::vector<std::string_view> parts;
  for (;;) {
    const std::size_t at = text.find_first_of(separators);
    parts.push_back(text.substr(0, at));
    if (at == std::string_view::npos) return parts;
    text.remove_prefix(at + 1);
  }
}

// Parses `count` finite numbers separated by commas; nullopt for anything else.
std::optional<std::vector<double>> numbers_in(std::string_view text, std::size_t count) {
  auto numbers = parse_numbers(text);
  return numbers && numbers->size() == count ? numbers : std::nullopt;
}

// Parses distinct whole numbers separated by commas, and sorts them; `expected` describes them in messages.
template <class Allowed>
Result<std::vector<int>> whole_numbers(std::string_view text, std::string_view expected, const Allowed& allowed) {
  std::vector<int> numbers;
  for (const std::string_view part : split(text, ",")) {
    const auto number = whole_text_as<int>(part);
    if (!number || !allowed(*number)) return expected_found(expected, text);
    numbers.push_back(*number);
  }
  std::ranges::sort(numbers);
  if (std::ranges::adjacent_find(numbers) != numbers.end()) return expected_found("each number once", text);
  return numbers;
}

// Parses three whole numbers of at least `least`: 48,62,42 or 48x62x42.
std::optional<glm::ivec3> whole_vector(std::string_view text, int least) {
  const std::vector<std::string_view> parts = split(text, ",xX");
  if (parts.size() != 3) return std::nullopt;
  glm::ivec3 vector;
  for (int axis = 0; axis < 3; ++axis) {
    const auto number = whole_text_as<int>(parts[static_cast<std::size_t>(axis)]);
    if (!number || *number < least) return std::nullopt;
    vector[axis] = *number;
  }
  return vector;
}

// Parses two whole numbers from `least` to `most`.
std::optional<glm::ivec2> whole_pair(std::string_view text, std::string_view separators, int least, int most) {
  const std::vector<std::string_view> parts = split(text, separators);
  if (parts.size() != 2) return std::nullopt;
  glm::ivec2 pair;
  for (int i = 0; i < 2; ++i) {
    const auto number = whole_text_as<int>(parts[static_cast<std::size_t>(i)]);
    if (!number || *number < least || *number > most) return std::nullopt;
    pair[i] = *number;
  }
  return pair;
}

// Parses three numbers above 0, or one for all.
std::optional<glm::dvec3> three_above_0(std::string_view text, std::string_view separators) {
  const std::vector<std::string_view> parts = split(text, separators);
  if (parts.size() != 1 && parts.size() != 3) return std::nullopt;
  glm::dvec3 numbers;
  for (int axis = 0; axis < 3; ++axis) {
    const auto number = parse_positive(parts[static_cast<std::size_t>(axis) % parts.size()]);
    if (!number) return std::nullopt;
    numbers[axis] = *number;
  }
  return numbers;
}

}  // namespace

Result<std::string> parse_text(std::string_view text) { return std::string(text); }

Result<double> parse_number(std::string_view text) {
  const auto number = whole_text_as<double>(text);
  if (!number) return expected_found("a number", text);
  if (!std::isfinite(*number)) return expected_found("a finite number", text);
  return *number;
}

Result<convert::IsoChoice> parse_iso(std::string_view text) {
  if (const auto choice = convert::iso_choice_of(text)) return *choice;
  const auto number = whole_text_as<double>(text);
  if (!number || !std::isfinite(*number)) {
    auto refused = expected_found(fmt::format("a finite number, {}", convert::kIsoWords), text);
    if (text.find(',') != std::string_view::npos) refused.value().hint = "give --iso several times for several values";
    return refused;
  }
  return convert::IsoChoice(*number);
}

Result<std::vector<convert::IsoChoice>> parse_labels(std::string_view text) {
  if (text == "all") return std::vector{convert::IsoChoice::all_labels()};
  std::vector<convert::IsoChoice> labels;
  for (std::set<std::int64_t> found; const std::string_view part : split(text, ",")) {
    const auto number = whole_text_as<std::int64_t>(part);
    if (!number) {
      if (convert::LabelSelection::parse(text))
        return std::vector{convert::IsoChoice::selected_labels(std::string(text))};
      return expected_found("all, or numbers, ranges and names with commas, such as 1-40,Hippocampus*,!Skull", text);
    }
    if (!found.insert(*number).second) return expected_found("each label once", text);
    labels.push_back(convert::IsoChoice::label(*number));
  }
  return labels;
}

Result<std::int64_t> parse_label(std::string_view text) {
  if (const auto number = whole_text_as<std::int64_t>(text)) return *number;
  return expected_found("a whole number", text);
}

Result<double> parse_positive(std::string_view text) {
  const auto number = whole_text_as<double>(text);
  if (!number || !std::isfinite(*number) || *number <= 0) return expected_found("a number above 0", text);
  return *number;
}

Result<RadiusChoice> parse_radius(std::string_view text) {
  if (text == "auto") return RadiusChoice();
  if (text == "auto:each") return RadiusChoice{std::nullopt, true};
  const auto number = parse_positive(text);
  if (!number) return expected_found("a number above 0, auto or auto:each", text);
  return RadiusChoice{*number, false};
}

Result<double> parse_part(std::string_view text) {
  const auto number = whole_text_as<double>(text);
  if (!number || !(*number >= 0 && *number <= 1)) return expected_found("a number from 0 to 1", text);
  return *number;
}

Result<double> parse_one_or_more(std::string_view text) {
  const auto number = whole_text_as<double>(text);
  if (!number || !std::isfinite(*number) || *number < 1) return expected_found("a number of 1 or more", text);
  return *number;
}

Result<std::uint64_t> parse_count(std::string_view text) {
  const auto number = whole_text_as<std::uint64_t>(text);
  if (!number) return expected_found("a whole number, 0 or more", text);
  return *number;
}

Result<std::uint64_t> parse_components(std::string_view text) {
  constexpr std::uint64_t kMost = 64;
  const auto number = whole_text_as<std::uint64_t>(text);
  if (!number || *number == 0 || *number > kMost) {
    return expected_found(fmt::format("a whole number from 1 to {}", kMost), text);
  }
  return *number;
}

Result<std::uint64_t> parse_relaxations(std::string_view text) {
  constexpr std::uint64_t kMost = 10'000;
  const auto number = whole_text_as<std::uint64_t>(text);
  if (!number || *number > kMost) return expected_found(fmt::format("a whole number from 0 to {}", kMost), text);
  return *number;
}

Result<std::uint64_t> parse_positive_count(std::string_view text) {
  const auto number = whole_text_as<std::uint64_t>(text);
  if (!number || *number == 0) return expected_found("a whole number above 0", text);
  return *number;
}

Result<glm::ivec2> parse_grid_size(std::string_view text) {
  const auto size = whole_pair(text, ",xX", 2, simulate::kMaxGridSize);
  if (!size) return expected_found(fmt::format("NXxNY, each 2 to {}", simulate::kMaxGridSize), text);
  return *size;
}

Result<glm::dvec3> parse_sides(std::string_view text) {
  const auto sides = three_above_0(text, "xX");
  if (!sides) return expected_found("three lengths above 0, such as 60x40x60, or one for all", text);
  return *sides;
}

Result<simulate::WaterTap> parse_tap(std::string_view text) {
  const std::vector<std::string_view> parts = split(text, ",");
  if (parts.size() == 3) {
    const auto x = whole_text_as<int>(parts[0]);
    const auto y = whole_text_as<int>(parts[1]);
    const auto rate = parse_positive(parts[2]);
    if (x && y && rate) return simulate::WaterTap{{*x, *y}, *rate};
  }
  return expected_found("X,Y,RATE: a cell, counted from 0, and a depth per step, above 0", text);
}

Result<double> parse_not_negative(std::string_view text) {
  const auto number = whole_text_as<double>(text);
  if (!number || !std::isfinite(*number) || *number < 0) return expected_found("a number, 0 or above", text);
  return *number;
}

Result<convert::TriangleCount> parse_triangle_count(std::string_view text) {
  constexpr double kMost = 0x1p53;
  std::string_view number = text;
  const bool in_percent = text.ends_with('%');
  const double unit = text.ends_with('k') ? 1e3 : text.ends_with('M') ? 1e6 : 1;
  if (in_percent || unit > 1) number.remove_suffix(1);
  const double amount = whole_text_as<double>(number).value_or(0) * unit;
  const bool fits = amount > 0 && amount <= (in_percent ? 100 : kMost);
  if (!fits || (!in_percent && amount != std::floor(amount))) {
    return expected_found("a number of triangles such as 100000 or 100k, or a part of them such as 10%", text);
  }
  return convert::TriangleCount{amount, in_percent};
}

std::optional<std::vector<double>> parse_numbers(std::string_view text) {
  std::vector<double> numbers;
  for (const std::string_view part : split(text, ",")) {
    const auto number = whole_text_as<double>(part);
    if (!number || !std::isfinite(*number)) return std::nullopt;
    numbers.push_back(*number);
  }
  return numbers;
}

Result<glm::dvec3> parse_vector(std::string_view text) {
  const auto numbers = numbers_in(text, 3);
  if (!numbers) return expected_found("three numbers X,Y,Z", text);
  return glm::dvec3((*numbers)[0], (*numbers)[1], (*numbers)[2]);
}

Result<render::PictureSize> parse_picture_size(std::string_view text) {
  const auto size = whole_pair(text, "xX", 1, render::PictureSize::kMaxSide);
  if (!size) {
    return expected_found(
        fmt::format("a width and a height from 1 to {} pixels, such as 1920x1080", render::PictureSize::kMaxSide),
        text);
  }
  return render::PictureSize{size->x, size->y};
}

Result<std::array<std::string, 3>> parse_columns(std::string_view text) {
  const auto refused = [&] {
    return expected_found("the columns of x, y and z, such as x=3,y=4,z=5 or x=Px,y=Py,z=Pz", text);
  };
  std::array<std::string, 3> columns;
  std::string_view rest = text;
  for (int part = 0; part < 3; ++part) {
    const std::size_t comma = rest.find(',');
    if ((comma == std::string_view::npos) != (part == 2)) return refused();
    const std::string_view pair = rest.substr(0, comma);
    rest = part == 2 ? std::string_view() : rest.substr(comma + 1);
    if (pair.size() < 3 || pair[0] < 'x' || pair[0] > 'z' || pair[1] != '=') return refused();
    std::string& column = columns[static_cast<std::size_t>(pair[0] - 'x')];
    if (!column.empty()) return refused();
    column = pair.substr(2);
  }
  return columns;
}

Result<glm::dvec3> parse_spacing(std::string_view text) {
  const auto spacing = three_above_0(text, ",");
  if (!spacing) return expected_found("one or three numbers above 0, such as 0.5,0.5,2", text);
  return *spacing;
}

Result<glm::ivec3> parse_dims(std::string_view text) {
  const auto dims = whole_vector(text, 1);
  if (!dims) return expected_found("three whole numbers above 0, such as 48,62,42 or 48x62x42", text);
  return *dims;
}

Result<glm::ivec3> parse_resolution(std::string_view text) {
  if (const auto number = whole_text_as<int>(text); number && *number >= 2) return glm::ivec3(*number);
  const auto resolution = whole_vector(text, 2);
  if (!resolution) return expected_found("one or three whole numbers, 2 or above, such as 256 or 256,256,128", text);
  return *resolution;
}

Result<convert::FilterStep> parse_filter(std::string_view text) {
  const std::size_t colon = text.find(':');
  const auto filter = value_of<volume_io::LevelSetFilter>(text.substr(0, colon));
  std::optional<int> width = 1;
  if (colon != std::string_view::npos) width = whole_text_as<int>(text.substr(colon + 1));
  if (!filter || !width || *width < 1 || *width > volume_io::kMaxFilterWidth) {
    return expected_found(
        fmt::format("gaussian, median or mean, optionally with a width of 1 to {} voxels (gaussian:2)",
                    volume_io::kMaxFilterWidth),
        text);
  }
  return convert::FilterStep{*filter, static_cast<std::uint64_t>(*width)};
}

Result<convert::ClipPlane> parse_clip_plane(std::string_view text) {
  const auto numbers = numbers_in(text, 4);
  if (!numbers) return expected_found("four numbers NX,NY,NZ,D", text);
  const glm::dvec3 normal((*numbers)[0], (*numbers)[1], (*numbers)[2]);
  const double length = glm::length(normal);
  if (!(std::isfinite(length) && length > 0)) return expected_found("a normal NX,NY,NZ other than 0,0,0", text);
  return convert::ClipPlane{normal, (*numbers)[3]};
}

Result<std::array<bool, 3>> parse_periodic(std::string_view text) {
  std::array<bool, 3> periodic{};
  if (text == "none") return periodic;
  for (std::string_view rest = text;;) {
    const std::string_view word = rest.substr(0, rest.find(','));
    const std::size_t axis = std::string_view("xyz").find(word);
    if (word.size() != 1 || axis == std::string_view::npos || periodic[axis]) {
      return expected_found("none, or one or more of x,y,z with commas", text);
    }
    periodic[axis] = true;
    if (word.size() == rest.size()) return periodic;
    rest.remove_prefix(word.size() + 1);
  }
}

Result<field::Box> parse_box(std::string_view text) {
  const auto numbers = numbers_in(text, 6);
  if (!numbers) return expected_found("six numbers X0,Y0,Z0,X1,Y1,Z1", text);
  const field::Box box{{(*numbers)[0], (*numbers)[1], (*numbers)[2]}, {(*numbers)[3], (*numbers)[4], (*numbers)[5]}};
  for (int axis = 0; axis < 3; ++axis) {
    if (box.min[axis] > box.max[axis]) {
      return expected_found(fmt::format("the smaller corner first, but {0}0 = {1} is above {0}1 = {2}", "XYZ"[axis],
                                        box.min[axis], box.max[axis]),
                            text);
    }
  }
  return box;
}

Result<VolumeChoice> parse_volume(std::string_view text) {
  if (text == "all") return AllVolumes{};
  const auto number = parse_volume_number(text);
  if (!number) return expected_found("the number of a volume, counted from 0, or all", text);
  return *number;
}

Result<std::int64_t> parse_volume_number(std::string_view text) {
  const auto number = whole_text_as<std::int64_t>(text);
  if (!number || *number < 0) return expected_found("the number of a volume, counted from 0", text);
  return *number;
}

Result<volume_io::ComponentChoice> parse_component(std::string_view text) {
  if (text == "length") return volume_io::ComponentChoice{};
  const auto number = whole_text_as<std::int64_t>(text);
  if (!number || *number < 0) {
    return expected_found("the number of a component, counted from 0, or the word 'length'", text);
  }
  return volume_io::ComponentChoice{*number};
}

Result<int> parse_thread_count(std::string_view text) {
  const auto number = whole_text_as<int>(text);
  if (!number || *number < 1 || *number > kMaxThreads) {
    return expected_found(fmt::format("a whole number from 1 to {}", kMaxThreads), text);
  }
  return *number;
}

Result<std::vector<int>> parse_thread_counts(std::string_view text) {
  return whole_numbers(text, fmt::format("whole numbers from 1 to {}, such as 1,2,4", kMaxThreads),
                       [](int n) { return n >= 1 && n <= kMaxThreads; });
}

Result<std::vector<int>> parse_demo_sizes(std::string_view text) {
  return whole_numbers(text, "whole numbers from 8 to 2048, such as 32,64,128",
                       [](int n) { return n >= 8 && n <= 2048; });
}

Result<std::vector<int>> parse_coarse_factors(std::string_view text) {
  return whole_numbers(text, "powers of two from 2 to 64, such as 2,4,8",
                       [](int n) { return n >= 2 && n <= 64 && std::has_single_bit(static_cast<unsigned>(n)); });
}

Result<std::vector<extract::Method>> parse_methods(std::string_view text) {
  std::vector<extract::Method> methods;
  for (const std::string_view word : split(text, ",")) {
    const auto method = value_of<extract::Method>(word);
    if (!method) {
      const auto ids = extract::method_ids();
      return expected_found(
          fmt::format("a comma-separated list of {}, such as {},{}", fmt::join(ids, ", "), ids[0], ids[1]), text);
    }
    if (std::ranges::find(methods, *method) != methods.end()) return expected_found("each method once", text);
    methods.push_back(*method);
  }
  return methods;
}

Result<gl::DeviceChoice> parse_device(std::string_view text) { return gl::parse_device_choice(std::string(text)); }

Result<int> parse_repeats(std::string_view text) {
  const auto number = whole_text_as<int>(text);
  if (!number || *number < 1 || *number > 1000) return expected_found("a whole number from 1 to 1000", text);
  return *number;
}

Result<std::uint64_t> parse_size(std::string_view text) { return parse_byte_size(text); }

Result<std::uint64_t> parse_memory_size(std::string_view text) {
  const std::uint64_t bytes = TRY(parse_byte_size(text));
  const bool has_unit = text.find_first_of("BbKkMmGgTt") != std::string_view::npos;
  if (has_unit || bytes >= convert::kProgramBytes) return bytes;
  return fail(ErrorCode::usage, fmt::format("expected a size with a unit, such as 512M or 2G, found '{}'", text),
              fmt::format("add a unit: K, M, G or T, or B for bytes, as in {}B", text));
}

Result<std::vector<NoteId>> parse_note_ids(std::string_view text) {
  std::vector<NoteId> ids;
  for (const std::string_view word : split(text, ",")) {
    const auto id = value_of<NoteId>(word);
    if (!id) {
      std::vector<std::string> known;
      for (const auto& entry : words_of(NoteId{})) known.emplace_back(entry.word);
      return fail(ErrorCode::usage, fmt::format("expected ids of notes, found '{}'{}", word, did_you_mean(word, known)),
                  "see 'isoextract help notes' for all ids");
    }
    if (std::ranges::find(ids, *id) != ids.end()) return expected_found("each id once", text);
    ids.push_back(*id);
  }
  return ids;
}

namespace {

// Quotes as $'...' with octal escapes, which shells read as the same bytes.
std::string ansi_quoted(std::string_view text) {
  std::string quoted = "$'";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '\n') {
      quoted += "\\n";
    } else if (c == '\\' || c == '\'') {
      quoted += fmt::format("\\{}", c);
    } else if (byte < 0x20 || byte >= 0x7f) {
      quoted += fmt::format("\\{:03o}", byte);
    } else {
      quoted += c;
    }
  }
  return quoted + "'";
}

}  // namespace

std::string shell_quoted(std::string_view text) {
  constexpr std::string_view kPlain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=./,:@%";
  if (!text.empty() && text.find_first_not_of(kPlain) == std::string_view::npos) return std::string(text);
  if (printable(text) != text) return ansi_quoted(text);
  std::string quoted = "'";
  for (const char c : text) {
    if (c == '\'') {
      quoted += "'\\''";
    } else {
      quoted += c;
    }
  }
  return quoted + "'";
}

}  // namespace isoextract::cli
