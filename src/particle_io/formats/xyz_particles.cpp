// XYZ: frames of a count, a comment, and one line per atom.
// - Plain: a line is x, y and z, optionally after the name of an element. Numbers after z have no names.
// - Extended: the comment describes the columns (Properties=species:S:1:pos:R:3:...;
//   https://github.com/libAtoms/extxyz) and the box: Lattice="ax ay az bx by bz cx cy cz", pbc="T T F", Origin="x y z".
//   It may have the frame's time or step: Time=0.5, step=100 or Timestep=100.
#include <algorithm>

#include <fmt/format.h>

#include "base/printable.hpp"
#include "particle_io/detail/frame_walk.hpp"
#include "particle_io/detail/particle_columns.hpp"
#include "particle_io/detail/text_rows.hpp"

namespace isoextract::particle_io {
namespace {

struct XyzFrame {
  std::uint64_t begin = 0;  // position of its first byte in the content
  std::uint64_t atoms = 0;
  std::string name;
  FrameTime time;
  Inherited inherited;                       // unused
  ParticleTable table;                       // without columns if there are no atoms
  std::optional<points::SimulationBox> box;  // the file's box, possibly without a volume
  bool box_is_unclear = false;               // the comment has a lattice that cannot be read
};

constexpr std::string_view kProperties = "Properties=";

// Returns the value after KEY= in the comment, quoted or not. Returns nothing if the key is missing.
std::optional<std::string_view> value_of_key(std::string_view comment, std::string_view key) {
  for (std::size_t at = comment.find(key); at != std::string_view::npos; at = comment.find(key, at + 1)) {
    if (at > 0 && comment[at - 1] != ' ' && comment[at - 1] != '\t') continue;
    std::string_view value = comment.substr(at + key.size());
    if (value.starts_with('"')) return value.substr(1, value.find('"', 1) - 1);
    return value.substr(0, value.find_first_of(" \t"));
  }
  return std::nullopt;
}

// Returns the value of the first of these keys that the comment has.
template <std::size_t N>
std::optional<std::string_view> value_of_any(std::string_view comment, const std::array<std::string_view, N>& keys) {
  for (const std::string_view key : keys) {
    if (const auto value = value_of_key(comment, key)) return value;
  }
  return std::nullopt;
}

// Sets the time, step and name of the frame.
void read_time(std::string_view comment, XyzFrame& frame) {
  constexpr std::array<std::string_view, 2> kTime{"Time=", "time="};
  constexpr std::array<std::string_view, 4> kStep{"step=", "Step=", "Timestep=", "timestep="};
  if (const auto time = value_of_any(comment, kTime)) {
    frame.time.time = parse_time(*time);
    frame.name = fmt::format("time {}", printable(*time, 40));
  }
  if (const auto step = value_of_any(comment, kStep)) frame.time.step = parse_step(*step);
}

// Returns the words of a list in one of the two notations: "1 0 0", or "[1, 0, 0]" with inner brackets too.
std::vector<std::string_view> list_words(std::string_view list) {
  std::vector<std::string_view> words;
  constexpr std::string_view kBetween = " \t,[]";
  for (std::size_t at = list.find_first_not_of(kBetween); at != std::string_view::npos;) {
    const std::size_t end = std::min(list.find_first_of(kBetween, at), list.size());
    words.push_back(list.substr(at, end - at));
    at = list.find_first_not_of(kBetween, end);
  }
  return words;
}

// Returns the N numbers of a list; nothing if the list has other words or another length.
template <std::size_t N>
std::optional<std::array<double, N>> numbers_of_list(std::string_view list) {
  const auto words = list_words(list);
  std::array<double, N> numbers{};
  if (words.size() != N) return std::nullopt;
  for (std::size_t n = 0; n < N; ++n) {
    const auto number = number_in(words[n]);
    if (!number) return std::nullopt;
    numbers[n] = *number;
  }
  return numbers;
}

// Sets the frame's box. All edges are periodic unless the comment says otherwise.
void read_lattice(std::string_view comment, XyzFrame& frame) {
  const auto lattice = value_of_key(comment, "Lattice=");
  if (!lattice) return;
  const auto edges = numbers_of_list<9>(*lattice);
  const auto origin = numbers_of_list<3>(value_of_key(comment, "Origin=").value_or("0 0 0"));
  const auto flags = list_words(value_of_key(comment, "pbc=").value_or("T T T"));
  frame.box_is_unclear = !edges || !origin || flags.size() != 3;
  if (frame.box_is_unclear) return;
  points::SimulationBox& box = frame.box.emplace();
  for (int n = 0; n < 9; ++n) box.edges[n / 3][n % 3] = (*edges)[static_cast<std::size_t>(n)];
  box.origin = {(*origin)[0], (*origin)[1], (*origin)[2]};
  constexpr std::array<std::string_view, 5> kTrue{"T", "True", "true", "TRUE", "1"};
  for (std::size_t k = 0; k < 3; ++k) box.periodic[k] = std::ranges::find(kTrue, flags[k]) != kTrue.end();
}

// Parses "species:S:1:pos:R:3".
ParticleTable extended_table(const ContentReader& content, std::string_view properties) {
  ParticleTable table;
  const auto next = [&](std::string_view what) {
    const std::size_t colon = properties.find(':');
    const std::string_view part = properties.substr(0, colon);
    properties.remove_prefix(colon == std::string_view::npos ? properties.size() : colon + 1);
    if (part.empty()) content.expected(fmt::format("{} in Properties", what), "");
    return part;
  };
  while (!properties.empty()) {
    const std::string name(next("a name"));
    const std::string_view type = next("a type");
    const std::string_view number = next("a number of columns");
    const auto components = parse_whole_number(number);
    if (!components || *components == 0 ||
        *components > kMaxParticleColumns - std::min(kMaxParticleColumns, table.columns.size())) {
      content.expected("a number of columns in Properties", number);
    }
    if (std::string_view("RISL").find(type) == std::string_view::npos || type.size() != 1) {
      content.expected("R, I, S or L as a type in Properties", type);
    }
    const bool numeric = type == "R" || type == "I";
    add_tuple(table, name,
              numeric       ? "number"
              : type == "L" ? "true or false"
                            : "text",
              static_cast<std::size_t>(*components), numeric);
    if (name == "pos" && *components == 3 && numeric && !table.position) {
      const std::size_t first = table.columns.size() - 3;
      table.position = {first, first + 1, first + 2};
    }
  }
  make_group_names_unique(table);
  return table;
}

ParticleTable plain_table(ContentReader& content) {
  ParticleTable table;
  std::vector<std::string_view> words;
  if (!content.peek_line()) throw TruncatedFrame("expected the line of an atom, found the end of the file");
  split_words(content.peek_line().value_or(""), words);
  if (words.size() < 3 || words.size() > kMaxParticleColumns) {
    const auto line = content.next_line();
    content.expected("x, y and z, with or without the name of an element before them", line.value_or(""));
  }
  if (words.size() > 3) add_tuple(table, "species", "number", 1);
  for (const char* axis : {"x", "y", "z"}) table.columns.push_back({axis, {}, "number", true});
  const std::size_t first = table.columns.size() - 3;
  table.position = {first, first + 1, first + 2};
  table.groups.push_back({"x y z", {first, first + 1, first + 2}});
  while (table.columns.size() < words.size()) {
    add_tuple(table, fmt::format("column {}", table.columns.size() + 1), "number", 1);
  }
  mark_text_columns(table, words);
  return table;
}

struct XyzFrames {
  using Frame = XyzFrame;
  static InvalidParticleFile no_frames() { return InvalidParticleFile("expected the number of atoms, found nothing"); }
  static constexpr bool kEndsInRow = true;

  static bool next(ContentReader& content, XyzFrame& frame);
  static void skip(ContentReader& content, const XyzFrame& frame) {
    skip_rows(content, frame.atoms, frame.table.columns.size());
  }
};

bool XyzFrames::next(ContentReader& content, XyzFrame& frame) {
  frame = {};
  frame.begin = content.position();
  std::vector<std::string_view> words;
  do {
    const auto line = content.next_line();
    if (!line) return false;
    split_words(*line, words);
  } while (words.empty());  // after the last frame there may be empty lines
  const auto count = parse_whole_number(words.front());
  if (!count || words.size() != 1) content.expected("the number of atoms alone in a line", words.front());
  frame.atoms = *count;
  const auto comment = content.next_line();
  if (!comment) throw TruncatedFrame("expected a comment after the number of atoms, found the end of the file");
  const auto properties = value_of_key(*comment, kProperties);
  read_time(*comment, frame);
  read_lattice(*comment, frame);
  if (frame.atoms == 0) return true;
  if (!content.line_has_end()) throw_missing_rows(content, 0, frame.atoms);
  frame.table = properties ? extended_table(content, *properties) : plain_table(content);
  frame.table.has_words = true;
  return true;
}

class XyzParticles final : public ParticleFormat {
 public:
  XyzParticles()
      : ParticleFormat({.id = "xyz",
                        .title = "XYZ and extended XYZ, one frame or several",
                        .extensions = {".xyz", ".extxyz"},
                        .has_frames = true,
                        .has_columns = true,
                        .needs_extension = true}) {}

  // Recognizes only extended XYZ: a count alone may begin any file.
  [[nodiscard]] bool probe(const files::FileStart& start) const override {
    std::string_view text(reinterpret_cast<const char*>(start.bytes.data()), start.bytes.size());
    const std::size_t end = text.find('\n');
    if (end == std::string_view::npos) return false;
    std::string_view count = text.substr(0, end);
    while (!count.empty() && (count.back() == ' ' || count.back() == '\r')) count.remove_suffix(1);
    while (!count.empty() && count.front() == ' ') count.remove_prefix(1);
    text.remove_prefix(end + 1);
    return parse_whole_number(count).has_value() &&
           value_of_key(text.substr(0, text.find('\n')), kProperties).has_value();
  }

  [[nodiscard]] ParticleInfo info(const files::InputFile& file, const ParticleReadOptions& options) const override {
    ParticleInfo info;
    const XyzFrame frame = survey_frames<XyzFrames>(file, options, info);
    info.particles = frame.atoms;
    info.frame_name = frame.name;
    if (frame.atoms > 0) describe_table(frame.table, options, info);
    return info;
  }

  [[nodiscard]] FrameTime frame_time(const files::InputFile& file, const ParticleReadOptions& options) const override {
    return find_time<XyzFrames>(file, options);
  }

  [[nodiscard]] ParticleFile read(const files::InputFile& file, const ParticleReadOptions& options) const override {
    ContentReader content(file);
    const FrameIndex index(file);
    const XyzFrame frame = find_frame<XyzFrames>(content, index, options);
    const ColumnChoice choice = frame.atoms > 0 ? choose_columns(frame.table, options) : ColumnChoice();
    if (frame.atoms > 0) check_count(content, frame.atoms, 2 * frame.table.columns.size() - 1);
    ParticleFile result;
    result.particles = make_particles(file.context(), label_of_frame(file.name(), options), frame.atoms, choice);
    read_rows(content, frame.table, frame.atoms, sinks_of(result.particles, choice));
    index.add(wanted_frame(options) + 1, content, {});
    result.notes = check_only_frame<XyzFrames>(file, content, index, options, frame);
    content.park();
    result.notes.insert(result.notes.end(), choice.notes.begin(), choice.notes.end());
    result.time = frame.time;
    if (frame.box && frame.atoms > 0) set_box(*frame.box, choice.position == frame.table.position, result);
    if (frame.box_is_unclear) {
      result.notes.push_back({NoteId::box_ignored,
                              "the reader ignores the box of the file: expected nine numbers in Lattice, three in "
                              "Origin and three words in pbc"});
    }
    return result;
  }

  [[nodiscard]] std::vector<files::ByteRange> frame_ranges(const files::InputFile& file,
                                                           const ParticleReadOptions& options) const override {
    return find_ranges<XyzFrames>(file, options);
  }
};

}  // namespace

const ParticleFormat& xyz_particles() {
  static const XyzParticles format;
  return format;
}

}  // namespace isoextract::particle_io
