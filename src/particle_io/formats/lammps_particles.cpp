// Text dumps of LAMMPS, styles atom and custom: a sequence of time steps, each with its box and a table of atoms with
// named columns. Positions are x y z, unwrapped xu yu zu, or fractions of the box xs ys zs (xsu ysu zsu). The box may
// be triclinic (LAMMPS documentation, "dump" and "Howto triclinic").
#include <algorithm>
#include <limits>
#include <optional>

#include <fmt/format.h>

#include "base/printable.hpp"
#include "files/file_start.hpp"
#include "particle_io/detail/frame_walk.hpp"
#include "particle_io/detail/particle_columns.hpp"
#include "particle_io/detail/text_rows.hpp"

namespace isoextract::particle_io {
namespace {

struct LammpsFrame {
  std::uint64_t begin = 0;  // position of its first byte in the content
  std::string step;         // text in the file
  FrameTime time;
  Inherited inherited;  // the units, which the file states once for all later frames
  std::uint64_t atoms = 0;
  std::optional<points::SimulationBox> box;  // the file's box, possibly without a volume
  ParticleTable table;
  std::string unit;  // unit of lengths
};

std::string_view length_unit_of(std::string_view units) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 7> kUnits{{{"real", "angstrom"},
                                                                                 {"metal", "angstrom"},
                                                                                 {"si", "m"},
                                                                                 {"cgs", "cm"},
                                                                                 {"electron", "bohr"},
                                                                                 {"micro", "um"},
                                                                                 {"nano", "nm"}}};
  for (const auto& [name, unit] : kUnits) {
    if (name == units) return unit;
  }
  return {};
}

std::string_view line_of(ContentReader& content, std::string_view what) {
  const auto line = content.next_line();
  if (!line) throw TruncatedFrame(fmt::format("expected {}, found the end of the file", what));
  return *line;
}

// Reads three lines of bounds, with tilt factors if the title names them. The bounds describe the axis-aligned box
// around the parallelepiped. The last three words of the title are the boundaries: "pp" is a periodic edge.
points::SimulationBox read_lammps_box(ContentReader& content, std::span<const std::string_view> title) {
  // "ITEM: BOX BOUNDS xy xz yz pp pp pp"; with "abc origin" the edges are given directly.
  const bool is_general = title.size() > 3 && title[3] == "abc";
  const bool is_tilted = title.size() > 3 && title[3] == "xy";
  const std::size_t numbers = is_general ? 4 : is_tilted ? 3 : 2;
  double rows[3][4] = {};
  std::vector<std::string_view> words;
  for (auto& row : rows) {
    split_words(line_of(content, "the bounds of the box"), words);
    if (words.size() < numbers) content.expected("the bounds of the box", words.empty() ? "" : words.back());
    for (std::size_t i = 0; i < numbers; ++i) {
      const auto value = number_in(words[i]);
      if (!value) content.expected("a number among the bounds of the box", words[i]);
      row[i] = *value;
    }
  }
  points::SimulationBox box;
  for (std::size_t edge = 0; edge < 3; ++edge)
    box.periodic[edge] = title.size() > 5 && title[title.size() - 3 + edge] == "pp";
  if (is_general) {
    for (int edge = 0; edge < 3; ++edge) {
      box.edges[edge] = {rows[edge][0], rows[edge][1], rows[edge][2]};
      box.origin[edge] = rows[edge][3];
    }
    return box;
  }
  const double xy = rows[0][2];
  const double xz = rows[1][2];
  const double yz = rows[2][2];
  const double x_low = rows[0][0] - std::min({0.0, xy, xz, xy + xz});
  const double x_high = rows[0][1] - std::max({0.0, xy, xz, xy + xz});
  const double y_low = rows[1][0] - std::min(0.0, yz);
  const double y_high = rows[1][1] - std::max(0.0, yz);
  box.origin = {x_low, y_low, rows[2][0]};
  box.edges[0] = {x_high - x_low, 0, 0};
  box.edges[1] = {xy, y_high - y_low, 0};
  box.edges[2] = {xz, yz, rows[2][1] - rows[2][0]};
  return box;
}

using AxisNames = std::array<std::string_view, 3>;
// Positions that are fractions of the box's edges.
constexpr std::array<AxisNames, 2> kScaledNames{{{"xs", "ys", "zs"}, {"xsu", "ysu", "zsu"}}};
// All names of positions, in order of precedence.
constexpr std::array<AxisNames, 4> kAxisNames{{{"x", "y", "z"}, {"xu", "yu", "zu"}, kScaledNames[0], kScaledNames[1]}};

// Finds the columns of the position.
void find_lammps_position(LammpsFrame& frame) {
  for (const AxisNames& names : kAxisNames) {
    std::array<std::size_t, 3> position{};
    std::size_t found = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto column = std::ranges::find(frame.table.columns, names[axis], &ParticleColumn::name);
      if (column == frame.table.columns.end()) continue;
      position[axis] = static_cast<std::size_t>(column - frame.table.columns.begin());
      ++found;
    }
    if (found < 3) continue;
    frame.table.position = position;
    return;
  }
}

struct LammpsFrames {
  using Frame = LammpsFrame;
  static InvalidParticleFile no_frames() { return InvalidParticleFile("expected 'ITEM: TIMESTEP', found nothing"); }
  static constexpr bool kEndsInRow = true;

  static bool next(ContentReader& content, LammpsFrame& frame);
  static void skip(ContentReader& content, const LammpsFrame& frame) {
    skip_rows(content, frame.atoms, frame.table.columns.size());
  }
};

bool LammpsFrames::next(ContentReader& content, LammpsFrame& frame) {
  const Inherited units = std::move(frame.inherited);
  frame = {};
  frame.begin = content.position();
  frame.inherited = units;
  bool has_atoms = false;
  bool has_step = false;
  std::vector<std::string_view> words;
  while (true) {
    const std::uint64_t begin = content.position();
    const auto line = content.next_line();
    if (!line && !has_step && !has_atoms) return false;
    if (!line) throw TruncatedFrame("expected 'ITEM: ATOMS', found the end of the file");
    split_words(*line, words);
    if (words.empty() && !has_step) continue;
    if (words.size() < 2 || words[0] != "ITEM:") content.expected("a line 'ITEM: ...'", *line);
    if (words[1] == "TIMESTEP") {
      split_words(line_of(content, "a time step"), words);
      frame.step = words.empty() ? std::string() : printable(words.front(), 40);
      frame.time.step = parse_step(words.empty() ? std::string_view() : words.front());
      has_step = true;
    } else if (words[1] == "TIME") {
      split_words(line_of(content, "a time"), words);
      frame.time.time = parse_time(words.empty() ? std::string_view() : words.front());
    } else if (words[1] == "UNITS") {
      frame.inherited.text = printable(line_of(content, "the units"), 40);
      frame.inherited.stated = {begin, content.position() - begin};
    } else if (words[1] == "NUMBER" && words.size() == 4 && words[3] == "ATOMS") {
      const std::string_view text = line_of(content, "the number of atoms");
      const auto count = parse_whole_number(text);
      if (!count) content.expected("the number of atoms", text);
      frame.atoms = *count;
      has_atoms = true;
    } else if (words[1] == "BOX" && words.size() > 2) {
      const std::string title(*line);
      split_words(title, words);
      frame.box = read_lammps_box(content, words);
    } else if (words[1] == "ATOMS") {
      if (!has_atoms) content.expected("'ITEM: NUMBER OF ATOMS' before 'ITEM: ATOMS'", "none");
      if (words.size() - 2 > kMaxParticleColumns)
        content.expected(fmt::format("at most {} columns", kMaxParticleColumns), *line);
      for (std::size_t i = 2; i < words.size(); ++i) {
        frame.table.columns.push_back({std::string(words[i]), {}, "number", true});
      }
      break;
    } else {
      static_cast<void>(line_of(content, "the data of an ITEM"));  // skips the data of an ITEM that is not needed
    }
  }
  if (frame.atoms > 0 && !content.line_has_end()) throw_missing_rows(content, 0, frame.atoms);
  if (frame.table.columns.empty()) content.expected("the names of columns after 'ITEM: ATOMS'", "");
  find_lammps_position(frame);
  if (frame.atoms > 0) mark_text_columns_ahead(content, frame.table);
  group_by_names(frame.table);
  frame.table.has_words = true;
  frame.unit = length_unit_of(frame.inherited.text);
  return true;
}

// Returns the box edge whose fractions the column holds; nothing for other columns.
std::optional<std::size_t> scaled_axis(const ParticleColumn& column) {
  for (const AxisNames& names : kScaledNames) {
    const auto name = std::ranges::find(names, column.name);
    if (name != names.end()) return static_cast<std::size_t>(name - names.begin());
  }
  return std::nullopt;
}

// Converts fractional coordinates to lengths, for any assignment of box edges to x, y and z in `columns`.
void unscale(Buffer<glm::dvec3>& positions, const LammpsFrame& frame, const std::array<std::size_t, 3>& columns) {
  std::array<std::optional<std::size_t>, 3> axes;
  std::array<int, 3> times{};  // how often each edge is used
  for (std::size_t k = 0; k < 3; ++k) {
    axes[k] = scaled_axis(frame.table.columns[columns[k]]);
    if (axes[k]) ++times[*axes[k]];
  }
  if (times == std::array{0, 0, 0}) return;
  if (!frame.box)
    throw InvalidParticleFile("expected 'ITEM: BOX BOUNDS' before positions that are fractions of the box");
  const points::SimulationBox& box = *frame.box;
  const auto axis_of = [&](std::size_t k) { return static_cast<glm::length_t>(*axes[k]); };
  if (times == std::array{1, 1, 1}) {
    for (glm::dvec3& p : positions) {
      glm::dvec3 f(0);
      for (glm::length_t k = 0; k < 3; ++k) f[axis_of(static_cast<std::size_t>(k))] = p[k];
      const glm::dvec3 offset = box.edges[0] * f.x + box.edges[1] * f.y + box.edges[2] * f.z;
      const glm::dvec3 place = box.origin + offset;
      for (glm::length_t k = 0; k < 3; ++k) p[k] = place[axis_of(static_cast<std::size_t>(k))];
    }
    return;
  }
  const glm::dmat3& edges = box.edges;
  const glm::dmat3 upright(edges[0][0], 0, 0, 0, edges[1][1], 0, 0, 0, edges[2][2]);
  if (edges != upright) {
    std::string names;
    for (const std::size_t column : columns) names += ' ' + printable(frame.table.columns[column].name, 80);
    throw InvalidParticleFile(
        fmt::format("expected fractions of all three edges of the triclinic box as x, y and z, found{}", names),
        Hint(Remedy::set, Setting::columns, "x=xs,y=ys,z=zs, or three columns of lengths"));
  }
  for (glm::dvec3& p : positions) {
    for (glm::length_t k = 0; k < 3; ++k) {
      if (!axes[static_cast<std::size_t>(k)]) continue;
      const glm::length_t axis = axis_of(static_cast<std::size_t>(k));
      p[k] = box.origin[axis] + edges[axis][axis] * p[k];
    }
  }
}

// Returns whether the columns of a position are coordinates or fractions along x, y and z, in this order.
bool is_in_axis_order(const ParticleTable& table, const std::array<std::size_t, 3>& position) {
  for (std::size_t k = 0; k < 3; ++k) {
    const auto is_column = [&](const AxisNames& names) { return names[k] == table.columns[position[k]].name; };
    if (std::ranges::none_of(kAxisNames, is_column)) return false;
  }
  return true;
}

class LammpsParticles final : public ParticleFormat {
 public:
  LammpsParticles()
      : ParticleFormat({.id = "lammps",
                        .title = "LAMMPS dump, styles atom and custom, as text",
                        .extensions = {".lammpstrj", ".dump"},
                        .has_frames = true,
                        .has_columns = true}) {}

  [[nodiscard]] bool probe(const files::FileStart& start) const override {
    return files::starts_with(start.bytes, "ITEM: TIMESTEP") || files::starts_with(start.bytes, "ITEM: UNITS") ||
           files::starts_with(start.bytes, "ITEM: TIME");
  }

  [[nodiscard]] ParticleInfo info(const files::InputFile& file, const ParticleReadOptions& options) const override {
    ParticleInfo info;
    const LammpsFrame frame = survey_frames<LammpsFrames>(file, options, info);
    info.particles = frame.atoms;
    info.frame_name = "time step " + frame.step;
    describe_table(frame.table, options, info);
    info.length_unit = frame.unit;
    return info;
  }

  [[nodiscard]] FrameTime frame_time(const files::InputFile& file, const ParticleReadOptions& options) const override {
    return find_time<LammpsFrames>(file, options);
  }

  [[nodiscard]] ParticleFile read(const files::InputFile& file, const ParticleReadOptions& options) const override {
    ContentReader content(file);
    const FrameIndex index(file);
    const LammpsFrame frame = find_frame<LammpsFrames>(content, index, options);
    const ColumnChoice choice = choose_columns(frame.table, options);
    check_count(content, frame.atoms, 2 * frame.table.columns.size() - 1);
    ParticleFile result;
    result.particles =
        make_particles(file.context(), fmt::format("{}, time step {}", file.name(), frame.step), frame.atoms, choice);
    read_rows(content, frame.table, frame.atoms, sinks_of(result.particles, choice));
    index.add(wanted_frame(options) + 1, content, frame.inherited);
    result.notes = check_only_frame<LammpsFrames>(file, content, index, options, frame);
    content.park();
    result.notes.insert(result.notes.end(), choice.notes.begin(), choice.notes.end());
    unscale(result.particles.positions, frame, choice.position);
    result.length_unit = frame.unit;
    result.time = frame.time;
    if (frame.box) set_box(*frame.box, is_in_axis_order(frame.table, choice.position), result);
    return result;
  }

  [[nodiscard]] std::vector<files::ByteRange> frame_ranges(const files::InputFile& file,
                                                           const ParticleReadOptions& options) const override {
    return find_ranges<LammpsFrames>(file, options);
  }
};

}  // namespace

const ParticleFormat& lammps_particles() {
  static const LammpsParticles format;
  return format;
}

}  // namespace isoextract::particle_io
