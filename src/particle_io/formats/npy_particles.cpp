// NumPy's array files: one row per particle, N x 3 or wider, frames of rows (F x N x 3), or a structured array with
// named fields.
#include <algorithm>
#include <charconv>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/checked.hpp"
#include "base/printable.hpp"
#include "files/file_start.hpp"
#include "particle_io/detail/particle_columns.hpp"
#include "volume_io/npy_header.hpp"

namespace isoextract::particle_io {
namespace {

constexpr std::size_t kMostFieldBytes = 4096;

// One element of an array or of a field.
struct NpyElement {
  std::optional<NumberType> number;  // empty for types that are not numbers, such as text
  std::endian endian = std::endian::native;
  std::size_t bytes = 0;
};

// Returns the size of a type that is not read as a number: text, raw bytes, dates, complex numbers, long doubles.
// Returns 0 for any other type and for types without bytes. Takes the type's letter and size.
std::size_t npy_bytes_of_other(std::string_view type) {
  constexpr std::array<std::string_view, 5> kNumbers{"c8", "c16", "c32", "f12", "f16"};
  const bool is_date = type.starts_with("M8") || type.starts_with("m8");
  const bool is_unit = type.size() == 2 || (type.size() > 2 && type[2] == '[' && type.back() == ']');
  if (is_date) return is_unit ? 8 : 0;
  const bool is_text = std::string_view("SaVU").find(type.front()) != std::string_view::npos;
  if (!is_text && std::ranges::find(kNumbers, type) == kNumbers.end()) return 0;
  std::size_t count = 0;
  const char* const last = type.data() + type.size();
  const auto [end, status] = std::from_chars(type.data() + 1, last, count);
  if (status != std::errc{} || end != last || count > kMostFieldBytes) return 0;
  return type.front() == 'U' ? 4 * count : count;
}

// Parses "<f4". Returns nothing for unsupported types.
std::optional<NpyElement> npy_element(std::string_view descr) {
  constexpr std::array<std::pair<std::string_view, NumberType>, 12> kTypes{{{"u1", NumberType::u8},
                                                                            {"b1", NumberType::u8},
                                                                            {"i1", NumberType::i8},
                                                                            {"u2", NumberType::u16},
                                                                            {"i2", NumberType::i16},
                                                                            {"u4", NumberType::u32},
                                                                            {"i4", NumberType::i32},
                                                                            {"u8", NumberType::u64},
                                                                            {"i8", NumberType::i64},
                                                                            {"f2", NumberType::f16},
                                                                            {"f4", NumberType::f32},
                                                                            {"f8", NumberType::f64}}};
  if (descr.size() < 3) return std::nullopt;
  NpyElement element;
  switch (descr.front()) {
    case '<': element.endian = std::endian::little; break;
    case '>': element.endian = std::endian::big; break;
    case '=':
    case '|': break;
    default: return std::nullopt;
  }
  const std::string_view type = descr.substr(1);
  for (const auto& [name, known] : kTypes) {
    if (name == type) return NpyElement{known, element.endian, number_size(known)};
  }
  element.bytes = npy_bytes_of_other(type);
  if (element.bytes == 0) return std::nullopt;
  return element;
}

struct NpyParticleFile {
  volume_io::NpyHeader header;
  std::uint64_t frames = 1;
  std::uint64_t whole = 1;      // frames that the file is long enough for
  std::uint64_t particles = 0;  // per frame
  std::uint64_t frame_bytes = 0;
  ParticleTable table;
  RecordLayout layout;
  bool by_column = false;  // column by column instead of row by row
  Notes notes;
};

[[noreturn]] void refuse_npy_type(std::string_view descr) {
  throw InvalidParticleFile(fmt::format("expected numbers, found the type {}", printable(descr, 40)),
                            "convert the array in NumPy, for example with a.astype('f4')");
}

bool are_frames(const volume_io::NpyHeader& header) {
  return header.fields.empty() && header.shape.size() == 3 && header.shape[2] == 3;
}

bool are_rows(const volume_io::NpyHeader& header) {
  if (!header.fields.empty()) return header.shape.size() == 1;
  return header.shape.size() == 2 && header.shape[1] >= 3 && header.shape[1] <= kMaxParticleColumns;
}

void add_npy_fields(NpyParticleFile& npy) {
  for (const volume_io::NpyField& field : npy.header.fields) {
    const auto element = npy_element(field.descr);
    if (!element) refuse_npy_type(field.descr);
    std::uint64_t components = 1;
    for (const std::uint64_t size : field.shape) {
      components = checked_product(components, size).value_or(~std::uint64_t{0});
    }
    const std::size_t most = kMaxParticleColumns - npy.table.columns.size();
    if (components > most) {
      throw InvalidParticleFile(
          fmt::format("expected at most {} components in field '{}' ({} in all fields), found more", most,
                      printable(field.name, 80), kMaxParticleColumns));
    }
    if (element->bytes > kMostFieldBytes) {
      throw InvalidParticleFile(fmt::format("expected at most {} bytes per component of field '{}', found {}",
                                            kMostFieldBytes, printable(field.name, 80), element->bytes));
    }
    const bool numeric = element->number.has_value();
    add_tuple(npy.table, field.name, numeric ? std::string(number_name(*element->number)) : printable(field.descr, 40),
              static_cast<std::size_t>(components), numeric);
    for (std::uint64_t i = 0; i < components; ++i) {
      npy.layout.fields.push_back({element->number, npy.layout.bytes, element->endian});
      npy.layout.bytes += element->bytes;
    }
  }
  make_group_names_unique(npy.table);
  // Single columns may form groups by name: x, y, z, vx, vy, vz.
  if (std::ranges::all_of(npy.table.groups, [](const ColumnTuple& group) { return group.columns.size() == 1; })) {
    npy.table.groups.clear();
    group_by_names(npy.table);
  }
}

void add_npy_columns(NpyParticleFile& npy) {
  const auto element = npy_element(npy.header.descr);
  if (!element || !element->number) refuse_npy_type(npy.header.descr);
  const std::size_t count = static_cast<std::size_t>(npy.header.shape.back());
  for (std::size_t i = 0; i < count; ++i) {
    add_tuple(npy.table, fmt::format("column {}", i + 1), std::string(number_name(*element->number)), 1);
    npy.layout.fields.push_back({element->number, npy.layout.bytes, element->endian});
    npy.layout.bytes += element->bytes;
  }
  npy.table.position = {0, 1, 2};
  if (count > 3)
    npy.notes.push_back(
        {NoteId::assumed_columns, fmt::format("the reader takes the first three of {} columns as x, y and z", count)});
}

NpyParticleFile open_npy_particles(const files::InputFile& file) {
  NpyParticleFile npy;
  npy.header = must(volume_io::read_npy_header(file));
  const bool has_frames = are_frames(npy.header);
  if (!has_frames && !are_rows(npy.header)) {
    throw InvalidParticleFile(
        fmt::format("expected a row for each particle (N x 3 to N x {}), frames of rows (F x N x 3) or a structured "
                    "array with one axis, found shape ({}) of {}",
                    kMaxParticleColumns, fmt::join(npy.header.shape, ", "), printable(npy.header.descr, 40)));
  }
  if (has_frames && npy.header.fortran_order) {
    throw InvalidParticleFile("expected frames one after another, found an array in Fortran order",
                              "convert the array in NumPy with numpy.ascontiguousarray(a)");
  }
  if (has_frames) npy.frames = npy.header.shape[0];
  if (npy.frames == 0) throw InvalidParticleFile("expected at least one frame, found an array without frames");
  npy.particles = npy.header.shape[has_frames ? 1 : 0];
  if (npy.header.fields.empty()) {
    add_npy_columns(npy);
    npy.by_column = npy.header.fortran_order;
  } else {
    add_npy_fields(npy);
  }
  if (npy.layout.bytes == 0 || npy.layout.bytes > ContentReader::kMaxPeekedBytes) {
    throw InvalidParticleFile(
        fmt::format("expected 1 to {} bytes per particle (a row or record of the array), found {}",
                    ContentReader::kMaxPeekedBytes, npy.layout.bytes));
  }
  npy.frame_bytes = checked_product(npy.particles, npy.layout.bytes).value_or(~std::uint64_t{0});
  npy.whole = npy.frames;
  const std::uint64_t data = file.size() - std::min(file.size(), npy.header.data_offset);
  if (has_frames && npy.frame_bytes > 0) npy.whole = std::min(npy.frames, data / npy.frame_bytes);
  if (npy.whole > 0 && npy.whole < npy.frames) {
    npy.notes.push_back(
        {NoteId::incomplete_frame, fmt::format("{} ends within frame {} of {}; the reader uses the frames before it",
                                               printable(file.name()), npy.whole, npy.frames)});
  }
  return npy;
}

// Returns the number of the frame to read. Throws as throw_frame_error() does.
std::uint64_t wanted_npy_frame(const NpyParticleFile& npy, const ParticleReadOptions& options) {
  const std::uint64_t wanted = wanted_frame(options);
  // A file without a whole frame fails when its bytes are counted.
  const std::uint64_t frames = std::max<std::uint64_t>(npy.whole, 1);
  if (wanted >= frames || (!options.frame && frames > 1)) throw_frame_error(options, frames);
  return wanted;
}

void read_npy_columns(ContentReader& content, const NpyParticleFile& npy, std::span<const ColumnSink> sinks) {
  for (std::size_t column = 0; column < npy.layout.fields.size(); ++column) {
    RecordLayout one;
    one.fields.resize(column + 1);
    one.fields[column] = npy.layout.fields[column];
    one.fields[column].offset = 0;
    one.bytes = npy.layout.bytes / npy.layout.fields.size();  // all columns have the same type
    const auto first = std::ranges::lower_bound(sinks, column, {}, &ColumnSink::column);
    const auto last = std::ranges::upper_bound(sinks, column, {}, &ColumnSink::column);
    if (first == last) {
      content.skip(npy.particles * one.bytes, "a column");
    } else {
      read_records(content, one, npy.particles, {first, last});
    }
  }
}

// Returns the notes about the file that apply with these options.
Notes notes_of(const NpyParticleFile& npy, const ParticleReadOptions& options) {
  Notes notes = npy.notes;
  if (options.columns) std::erase_if(notes, [](const Note& note) { return note.id == NoteId::assumed_columns; });
  return notes;
}

class NpyParticles final : public ParticleFormat {
 public:
  NpyParticles()
      : ParticleFormat({.id = "npy",
                        .title = "NumPy array, a row a particle, frames of rows, or structured",
                        .extensions = {".npy"},
                        .has_frames = true,
                        .has_columns = true}) {}

  // Other arrays with more axes are volumes.
  [[nodiscard]] bool probe(const files::FileStart& start) const override {
    if (start.packed) return false;
    const auto header = volume_io::npy_header_in(start.bytes);
    return header && (are_rows(*header) || are_frames(*header));
  }

  [[nodiscard]] ParticleInfo info(const files::InputFile& file, const ParticleReadOptions& options) const override {
    const NpyParticleFile npy = open_npy_particles(file);
    ParticleInfo info;
    ParticleReadOptions one = options;
    one.frame = options.frame.value_or(0);
    static_cast<void>(wanted_npy_frame(npy, one));
    info.frames = std::max<std::uint64_t>(npy.whole, 1);
    info.particles = npy.particles;
    info.notes = notes_of(npy, options);
    describe_table(npy.table, options, info);
    return info;
  }

  [[nodiscard]] ParticleFile read(const files::InputFile& file, const ParticleReadOptions& options) const override {
    const NpyParticleFile npy = open_npy_particles(file);
    const std::uint64_t frame = wanted_npy_frame(npy, options);
    const ColumnChoice choice = choose_columns(npy.table, options);
    check_numbers(npy.table, choice.position, "x, y and z",
                  {Remedy::give, Setting::columns, "choose columns of numbers"});
    ContentReader content(file);
    content.go_to({.position = npy.header.data_offset + frame * npy.frame_bytes, .number = 0, .line_end = '\n'},
                  npy.frame_bytes);
    check_count(content, npy.particles, npy.layout.bytes);
    ParticleFile result;
    result.particles = make_particles(file.context(), label_of_frame(file.name(), options), npy.particles, choice);
    const auto sinks = sinks_of(result.particles, choice);
    if (npy.by_column) {
      read_npy_columns(content, npy, sinks);
    } else {
      read_records(content, npy.layout, npy.particles, sinks);
    }
    const std::uint64_t later = checked_product(npy.frames - frame - 1, npy.frame_bytes).value_or(~std::uint64_t{0});
    if (content.max_remaining_bytes() > later) {
      throw InvalidParticleFile(
          fmt::format("expected the end of the file after {} particles of {} bytes each, found {} "
                      "more bytes",
                      npy.frames * npy.particles, npy.layout.bytes, content.max_remaining_bytes() - later));
    }
    result.notes = notes_of(npy, options);
    result.notes.insert(result.notes.end(), choice.notes.begin(), choice.notes.end());
    return result;
  }

  [[nodiscard]] std::vector<files::ByteRange> frame_ranges(const files::InputFile& file,
                                                           const ParticleReadOptions& options) const override {
    if (!options.frame) return {};
    const NpyParticleFile npy = open_npy_particles(file);
    const std::uint64_t frame = wanted_npy_frame(npy, options);
    if (npy.frames == 1) return {};
    return {{0, npy.header.data_offset}, {npy.header.data_offset + frame * npy.frame_bytes, npy.frame_bytes}};
  }
};

}  // namespace

const ParticleFormat& npy_particles() {
  static const NpyParticles format;
  return format;
}

}  // namespace isoextract::particle_io
