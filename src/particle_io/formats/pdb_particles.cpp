// Atoms of Protein Data Bank files (.pdb): lines with fixed columns
// (https://www.wwpdb.org/documentation/file-format-content/format33/sect9.html). MODEL, ENDMDL and END separate frames.
// Lengths are in angstrom. All other records are ignored, the unit cell too.
#include <array>

#include <fmt/format.h>

#include "base/ascii.hpp"
#include "base/printable.hpp"
#include "particle_io/detail/frame_walk.hpp"
#include "particle_io/detail/particle_columns.hpp"
#include "particle_io/detail/text_rows.hpp"

namespace isoextract::particle_io {
namespace {

// The columns of an atom, counted from 0, in the order of pdb_table().
struct FixedColumn {
  std::size_t first;
  std::size_t count;
};
constexpr std::array kFixedColumns{FixedColumn{6, 5},  FixedColumn{12, 4}, FixedColumn{17, 3}, FixedColumn{21, 1},
                                   FixedColumn{22, 4}, FixedColumn{30, 8}, FixedColumn{38, 8}, FixedColumn{46, 8},
                                   FixedColumn{54, 6}, FixedColumn{60, 6}, FixedColumn{76, 2}};
constexpr std::size_t kId = 0;
constexpr std::size_t kName = 1;
constexpr std::size_t kResid = 4;
constexpr std::size_t kX = 5;
constexpr std::size_t kOccupancy = 8;
constexpr std::size_t kTemperature = 9;
constexpr std::size_t kElement = 10;
constexpr std::size_t kLeastLine = 54;  // up to z

ParticleTable pdb_table() {
  ParticleTable table;
  add_tuple(table, "id", "number", 1);
  add_tuple(table, "name", "text", 1, false);
  add_tuple(table, "residue", "text", 1, false);
  add_tuple(table, "chain", "text", 1, false);
  add_tuple(table, "resid", "number", 1);
  add_tuple(table, "position", "number", 3);
  add_tuple(table, "occupancy", "number", 1);
  add_tuple(table, "temperature", "number", 1);
  add_tuple(table, "element", "text", 1, false);
  table.position = {kX, kX + 1, kX + 2};
  table.has_words = true;
  for (const std::size_t axis : *table.position) table.columns[axis].unit = "angstrom";
  return table;
}

bool is_record(std::string_view line, std::string_view name) { return fixed_field(line, 0, 6) == name; }
bool is_atom(std::string_view line) { return is_record(line, "ATOM") || is_record(line, "HETATM"); }

struct PdbFrame {
  std::uint64_t begin = 0;  // position of its first byte in the content
  std::uint64_t atoms = 0;  // known once the frame was passed
  std::string name;
  FrameTime time;       // unset
  Inherited inherited;  // text is kEnded if a record ended the previous frame
};

constexpr std::string_view kEnded = "ended";

// Calls use(line, atom) for each atom of the frame.
template <class Use>
void pass_pdb_atoms(ContentReader& content, PdbFrame& frame, const Use& use) {
  const bool before_ended = frame.inherited.text == kEnded;
  frame.atoms = 0;
  frame.inherited.text.clear();
  while (const auto line = content.peek_line()) {
    if (is_record(*line, "MODEL")) return;
    const auto taken = content.next_line();
    if (is_atom(*taken)) use(*taken, frame.atoms++);
    if (!is_record(*taken, "ENDMDL") && !is_record(*taken, "END")) continue;
    frame.inherited.text = kEnded;
    return;
  }
  // The last frame needs no record at its end if the previous frame has none.
  if (before_ended) {
    throw TruncatedFrame("expected ENDMDL or END after the atoms, found the end of the file",
                         fmt::format("{} atoms without the record ENDMDL or END after them", frame.atoms));
  }
}

struct PdbFrames {
  using Frame = PdbFrame;
  static InvalidParticleFile no_frames() {
    return InvalidParticleFile("expected lines that start with ATOM or HETATM, found none");
  }
  static constexpr bool kEndsInRow = false;  // the record at the end follows

  static bool next(ContentReader& content, PdbFrame& frame) {
    bool in_model = false;
    frame.begin = content.position();
    frame.name.clear();
    while (const auto line = content.peek_line()) {
      if (is_atom(*line)) return true;
      const bool begins = is_record(*line, "MODEL");
      if (begins) frame.name = fmt::format("model {}", printable(fixed_field(*line, 6, 20), 40));
      if (begins || is_record(*line, "ENDMDL") || is_record(*line, "END")) in_model = begins;
      static_cast<void>(content.next_line());
    }
    if (in_model && frame.inherited.text == kEnded)
      throw TruncatedFrame("expected ATOM after MODEL, found the end of the file");
    return false;
  }
  static void skip(ContentReader& content, PdbFrame& frame) {
    pass_pdb_atoms(content, frame, [](std::string_view, std::uint64_t) {});
  }
};

// Returns the element from the atom's name, for files without the element column: names have the symbol right-justified
// in their first two characters, except hydrogen names of four characters.
std::string_view element_of_name(std::string_view line) {
  const std::string_view name = line.substr(12, 4);
  if (fixed_field(name, 0, 4).size() == 4 && name.front() == 'H') return name.substr(0, 1);
  std::string_view symbol = fixed_field(name, 0, 2);
  while (!symbol.empty() && !is_letter(symbol.front())) symbol.remove_prefix(1);
  return symbol;
}

void deliver_pdb_atom(const ContentReader& content, const ParticleTable& table, std::string_view line,
                      std::uint64_t atom, std::vector<std::string_view>& fields, std::span<const ColumnSink> sinks) {
  if (line.size() < kLeastLine) content.expected("x, y and z of an atom in the columns 31 to 54", line);
  fields.clear();
  for (const FixedColumn& column : kFixedColumns) fields.push_back(fixed_field(line, column.first, column.count));
  for (std::size_t axis = kX; axis < kX + 3; ++axis) {
    if (fields[axis].empty()) content.expected("x, y and z of an atom in the columns 31 to 54", line);
  }
  // Files with more atoms than their columns can count have letters or stars there.
  for (const std::size_t number : {kId, kResid, kOccupancy, kTemperature}) {
    if (!number_in(fields[number])) fields[number] = {};
  }
  if (fields[kElement].empty()) fields[kElement] = element_of_name(line);
  deliver_row(content, table, fields, static_cast<std::size_t>(atom), sinks);
}

class PdbParticles final : public ParticleFormat {
 public:
  PdbParticles()
      : ParticleFormat({.id = "pdb",
                        .title = "atoms of Protein Data Bank files, one model or several",
                        .extensions = {".pdb", ".ent"},
                        .has_frames = true,
                        .needs_extension = true}) {}

  [[nodiscard]] ParticleInfo info(const files::InputFile& file, const ParticleReadOptions& options) const override {
    ParticleInfo info;
    const PdbFrame frame = survey_frames<PdbFrames>(file, options, info);
    info.times.clear();  // the format has none
    info.particles = frame.atoms;
    info.frame_name = frame.name;
    describe_table(pdb_table(), options, info);
    return info;
  }

  [[nodiscard]] ParticleFile read(const files::InputFile& file, const ParticleReadOptions& options) const override {
    const FrameIndex index(file);
    const ParticleTable table = pdb_table();
    ParticleFile result;
    std::uint64_t atoms = 0;
    {
      ContentReader content(file);
      PdbFrame frame = find_frame<PdbFrames>(content, index, options);
      PdbFrames::skip(content, frame);
      index.add(wanted_frame(options) + 1, content, frame.inherited);
      result.notes = check_only_frame<PdbFrames>(file, content, index, options, frame);
      atoms = frame.atoms;
    }
    const ColumnChoice choice = choose_columns(table, options);
    result.particles = make_particles(file.context(), label_of_frame(file.name(), options), atoms, choice);
    const std::vector<ColumnSink> sinks = sinks_of(result.particles, choice);
    ContentReader content(file);
    PdbFrame frame = find_frame<PdbFrames>(content, index, options);
    std::vector<std::string_view> fields;
    pass_pdb_atoms(content, frame, [&](std::string_view line, std::uint64_t atom) {
      deliver_pdb_atom(content, table, line, atom, fields, sinks);
    });
    if (frame.atoms != atoms) {
      throw InvalidParticleFile("the number of atoms changed while the program read the file",
                                "run again when no other program writes to the file");
    }
    content.park();
    result.length_unit = choice.length_unit;
    result.notes.insert(result.notes.end(), choice.notes.begin(), choice.notes.end());
    return result;
  }

  [[nodiscard]] std::vector<files::ByteRange> frame_ranges(const files::InputFile& file,
                                                           const ParticleReadOptions& options) const override {
    return find_ranges<PdbFrames>(file, options);
  }
};

}  // namespace

const ParticleFormat& pdb_particles() {
  static const PdbParticles format;
  return format;
}

}  // namespace isoextract::particle_io
