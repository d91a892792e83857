// GROMACS coordinates (.gro): frames of a title, the number of atoms, a line with fixed columns per atom, and the box
// (https://manual.gromacs.org/current/reference-manual/file-formats.html#gro). Lengths are in nanometers. The box is
// ignored.
#include <array>

#include <fmt/format.h>

#include "base/printable.hpp"
#include "particle_io/detail/frame_walk.hpp"
#include "particle_io/detail/particle_columns.hpp"
#include "particle_io/detail/text_rows.hpp"

namespace isoextract::particle_io {
namespace {

// Columns before the numbers: residue number, residue name, atom name, atom number, of 5 characters each.
constexpr std::size_t kWordColumns = 4;
constexpr std::size_t kWordWidth = 5;
constexpr std::size_t kNumbersStart = kWordColumns * kWordWidth;

struct GroFrame {
  std::uint64_t begin = 0;  // position of its first byte in the content
  std::uint64_t atoms = 0;
  std::string name;
  FrameTime time;
  Inherited inherited;    // unused
  std::size_t width = 8;  // characters of a number; files differ
  ParticleTable table;    // without columns if there are no atoms
};

// Returns the distance between the first two decimal points of the next line, which is the width of all numbers:
// "%8.3f" by default.
std::size_t number_width(ContentReader& content, std::string_view line) {
  const std::size_t first = line.find('.', kNumbersStart);
  const std::size_t second = first == std::string_view::npos ? first : line.find('.', first + 1);
  if (second == std::string_view::npos || first < kNumbersStart + 2) {
    const auto consumed = content.next_line();
    content.expected(fmt::format("x, y and z with decimal points from column {} on", kNumbersStart + 1),
                     consumed.value_or(""));
  }
  return second - first;
}

void describe_atoms(ContentReader& content, std::string_view line, GroFrame& frame) {
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

// Returns the word after a key in a title: "Water in a box t= 0.50000 step= 250".
std::optional<std::string_view> word_after(std::string_view title, std::string_view key) {
  const std::size_t at = title.rfind(key);
  if (at == std::string_view::npos) return std::nullopt;
  std::string_view value = title.substr(at + key.size());
  while (value.starts_with(' ')) value.remove_prefix(1);
  return value.substr(0, value.find(' '));
}

void read_box_line(ContentReader& content) {
  const auto line = content.next_line();
  if (!line) {
    throw TruncatedFrame("expected the box after the atoms, found the end of the file", "the file ends before its box");
  }
  std::vector<std::string_view> words;
  split_words(*line, words);
  if (!content.line_has_end() && words.size() < 3) content.expected("three numbers of the box after the atoms", *line);
}

struct GroFrames {
  using Frame = GroFrame;
  static InvalidParticleFile no_frames() {
    return InvalidParticleFile("expected a title and the number of atoms, found nothing");
  }
  static constexpr bool kEndsInRow = false;  // the box follows

  static bool next(ContentReader& content, GroFrame& frame);
  static void skip(ContentReader& content, const GroFrame& frame) {
    skip_rows(content, frame.atoms);
    read_box_line(content);
  }
};

bool GroFrames::next(ContentReader& content, GroFrame& frame) {
  frame = {};
  frame.begin = content.position();
  const auto title = content.next_line();
  if (!title) return false;
  if (const auto time = word_after(*title, "t=")) {
    frame.name = fmt::format("time {}", printable(*time, 40));
    frame.time.time = parse_time(*time);
  }
  if (const auto step = word_after(*title, "step=")) frame.time.step = parse_step(*step);
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

void read_gro_atoms(ContentReader& content, const GroFrame& frame, std::span<const ColumnSink> sinks) {
  std::vector<std::string_view> fields(frame.table.columns.size());
  for_each_row(content, frame.atoms, [&](std::uint64_t atom, std::string_view line) {
    for (std::size_t c = 0; c < kWordColumns; ++c) fields[c] = fixed_field(line, c * kWordWidth, kWordWidth);
    for (std::size_t c = kWordColumns; c < fields.size(); ++c) {
      fields[c] = fixed_field(line, kNumbersStart + (c - kWordColumns) * frame.width, frame.width);
      if (c < kWordColumns + 3 && fields[c].empty()) content.expected("x, y and z of an atom", line);
    }
    deliver_row(content, frame.table, fields, static_cast<std::size_t>(atom), sinks);
  });
  read_box_line(content);
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
    ParticleInfo info;
    const GroFrame frame = survey_frames<GroFrames>(file, options, info);
    info.particles = frame.atoms;
    info.frame_name = frame.name;
    if (frame.atoms > 0) describe_table(frame.table, options, info);
    return info;
  }

  [[nodiscard]] FrameTime frame_time(const files::InputFile& file, const ParticleReadOptions& options) const override {
    return find_time<GroFrames>(file, options);
  }

  [[nodiscard]] ParticleFile read(const files::InputFile& file, const ParticleReadOptions& options) const override {
    ContentReader content(file);
    const FrameIndex index(file);
    const GroFrame frame = find_frame<GroFrames>(content, index, options);
    const ColumnChoice choice = frame.atoms > 0 ? choose_columns(frame.table, options) : ColumnChoice();
    if (frame.atoms > 0) check_count(content, frame.atoms, kNumbersStart + 3 * frame.width);
    ParticleFile result;
    result.particles = make_particles(file.context(), label_of_frame(file.name(), options), frame.atoms, choice);
    read_gro_atoms(content, frame, sinks_of(result.particles, choice));
    index.add(wanted_frame(options) + 1, content, {});
    result.notes = check_only_frame<GroFrames>(file, content, index, options, frame);
    content.park();
    result.notes.insert(result.notes.end(), choice.notes.begin(), choice.notes.end());
    result.length_unit = choice.length_unit;
    result.time = frame.time;
    return result;
  }

  [[nodiscard]] std::vector<files::ByteRange> frame_ranges(const files::InputFile& file,
                                                           const ParticleReadOptions& options) const override {
    return find_ranges<GroFrames>(file, options);
  }
};

}  // namespace

const ParticleFormat& gro_particles() {
  static const GroParticles format;
  return format;
}

}  // namespace isoextract::particle_io
