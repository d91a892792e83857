// GROMACS coordinates (.gro): frames of a title, the number of atoms, a line with fixed columns per atom, and the box
// (https://manual.gromacs.org/current/reference-manual/file-formats.html#gro). Lengths are in nanometers. The box is
// ignored.
#include <array>

#include <fmt/format.h>

#include "base/printable.hpp"
#include "particle_io/detail/frame_index.hpp"
#include "particle_io/detail/particle_columns.hpp"
#include "particle_io/detail/text_rows.hpp"

namespace isoextract::particle_io {
namespace {

// Columns before the numbers: residue number, residue name, atom name, atom number, of 5 characters each.
constexpr std::size_t kWordColumns = 4;
constexpr std::size_t kWordWidth = 5;
constexpr std::size_t kNumbersStart = kWordColumns * kWordWidth;

struct GroFrame {
  std::uint64_t atoms = 0;
  std::string name;
  std::size_t width = 8;  // of a number; its precision is free
  ParticleTable table;    // without columns if there are no atoms
};

// Returns the distance between the first two decimal points, which is the width of all numbers: "%8.3f" by default.
std::size_t number_width(const ContentReader& content, std::string_view line) {
  const std::size_t first = line.find('.', kNumbersStart);
  const std::size_t second = first == std::string_view::npos ? first : line.find('.', first + 1);
  if (second == std::string_view::npos || first < kNumbersStart + 2) {
    throw InvalidParticleFile(
        fmt::format("line {}: expected x, y and z with decimal points from column {} on, found '{}'",
                    content.line_number() + 1, kNumbersStart + 1, printable(line, 40)));
  }
  return second - first;
}

void describe_atoms(const ContentReader& content, std::string_view line, GroFrame& frame) {
  frame.width = number_width(content, line);
  add_tuple(frame.table, "resid", "number", 1);
  add_tuple(frame.table, "residue", "text", 1, false);
  add_tuple(frame.table, "name", "text", 1, false);
  add_tuple(frame.table, "id", "number", 1);
  add_tuple(frame.table, "position", "number", 3);
  frame.table.position = {4, 5, 6};
  frame.table.has_words = true;
  if (!fixed_field(line, kNumbersStart + 3 * frame.width, frame.width).empty()) {
    add_tuple(frame.table, "v", "number", 3, true, AttributeKind::vector);
  }
  for (const std::size_t axis : *frame.table.position) frame.table.columns[axis].unit = "nm";
}

// The next frame up to its first atom; false at the end of the file.
bool next_gro_frame(ContentReader& content, GroFrame& frame) {
  frame = {};
  const auto title = content.next_line();
  if (!title) return false;
  if (const std::size_t time = title->rfind("t="); time != std::string_view::npos) {
    std::string_view value = title->substr(time + 2);
    while (value.starts_with(' ')) value.remove_prefix(1);
    frame.name = fmt::format("time {}", printable(value.substr(0, value.find(' ')), 40));
  }
  const bool is_blank = title->find_first_not_of(" \t") == std::string_view::npos;
  const auto count = content.next_line();
  if (!count && is_blank) return false;  // after the last frame there may be an empty line
  if (!count) throw TruncatedFrame("expected the number of atoms after the title, found the end of the file");
  const auto atoms = parse_whole_number(fixed_field(*count, 0, count->size()));
  if (!atoms) content.expected("the number of atoms alone in the second line of a frame", *count);
  frame.atoms = *atoms;
  if (frame.atoms == 0) return true;
  const auto line = content.peek_line();
  if (!line) throw TruncatedFrame("expected the line of an atom, found the end of the file");
  describe_atoms(content, *line, frame);
  return true;
}

void skip_gro_atoms(ContentReader& content, const GroFrame& frame) {
  skip_rows(content, frame.atoms);
  if (!content.next_line()) throw TruncatedFrame("expected the box after the atoms, found the end of the file");
}

GroFrame find_gro_frame(ContentReader& content, const FrameIndex& index, const ParticleReadOptions& options) {
  return find_frame<GroFrame>(
      content, index, options, InvalidParticleFile("expected a title and the number of atoms, found nothing"),
      [&](GroFrame& frame) { return next_gro_frame(content, frame); },
      [&](const GroFrame& frame) { skip_gro_atoms(content, frame); });
}

std::uint64_t count_gro_frames(ContentReader& content, const FrameIndex& index, std::uint64_t next) {
  return count_frames_from<GroFrame>(
      next, content, index, [&](GroFrame& frame) { return next_gro_frame(content, frame); },
      [&](const GroFrame& frame) { skip_gro_atoms(content, frame); });
}

void read_gro_atoms(ContentReader& content, const GroFrame& frame, std::span<const ColumnSink> sinks) {
  std::vector<std::string_view> fields(frame.table.columns.size());
  for (std::uint64_t atom = 0; atom < frame.atoms; ++atom) {
    const auto line = content.next_line();
    if (!line) {
      throw TruncatedFrame(fmt::format("expected {} atoms, found {} before the end of the file at line {}", frame.atoms,
                                       atom, content.line_number()));
    }
    for (std::size_t c = 0; c < kWordColumns; ++c) fields[c] = fixed_field(*line, c * kWordWidth, kWordWidth);
    for (std::size_t c = kWordColumns; c < fields.size(); ++c) {
      fields[c] = fixed_field(*line, kNumbersStart + (c - kWordColumns) * frame.width, frame.width);
      if (c < kWordColumns + 3 && fields[c].empty()) content.expected("x, y and z of an atom", *line);
    }
    deliver_row(content, frame.table, fields, static_cast<std::size_t>(atom), sinks);
  }
  if (!content.next_line()) throw TruncatedFrame("expected the box after the atoms, found the end of the file");
}

class GroParticles final : public ParticleFormat {
 public:
  GroParticles()
      : ParticleFormat({.id = "gro",
                        .title = "GROMACS coordinates, one frame or several",
                        .extensions = {".gro"},
                        .has_frames = true,
                        .needs_extension = true}) {}

  [[nodiscard]] ParticleInfo info(const files::InputFile& file, const ParticleReadOptions& options) const override {
    ContentReader content(file);
    const FrameIndex index(file);
    const GroFrame frame = find_gro_frame(content, index, options);
    ParticleInfo info;
    info.particles = frame.atoms;
    info.frame_name = frame.name;
    if (frame.atoms > 0) describe_table(frame.table, options, info);
    skip_gro_atoms(content, frame);
    info.frames = count_gro_frames(content, index, wanted_frame(options) + 1);
    return info;
  }

  [[nodiscard]] ParticleFile read(const files::InputFile& file, const ParticleReadOptions& options) const override {
    ContentReader content(file);
    const FrameIndex index(file);
    const GroFrame frame = find_gro_frame(content, index, options);
    const ColumnChoice choice = frame.atoms > 0 ? choose_columns(frame.table, options) : ColumnChoice();
    if (frame.atoms > 0) check_count(content, frame.atoms, kNumbersStart + 3 * frame.width);
    ParticleFile result;
    result.particles = make_particles(file.context(), label_of_frame(file.name(), options), frame.atoms, choice);
    read_gro_atoms(content, frame, sinks_of(result.particles, choice));
    index.add(wanted_frame(options) + 1, content, {});
    if (!options.frame) {
      const std::uint64_t frames = count_gro_frames(content, index, 1);
      if (frames > 1) throw_frame_error(options, frames);
    }
    result.length_unit = choice.length_unit;
    result.notes = choice.notes;
    return result;
  }
};

}  // namespace

const ParticleFormat& gro_particles() {
  static const GroParticles format;
  return format;
}

}  // namespace isoextract::particle_io
