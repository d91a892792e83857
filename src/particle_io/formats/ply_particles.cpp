// PLY (Greg Turk, 1994) without faces: text, little- and big-endian; the element "vertex" with any properties. Skips
// other elements and lists. A file with faces is a mesh.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include <fmt/format.h>

#include "base/printable.hpp"
#include "files/file_start.hpp"
#include "particle_io/detail/particle_columns.hpp"
#include "particle_io/detail/text_rows.hpp"

namespace isoextract::particle_io {
namespace {

struct PlyProperty {
  std::string name;
  NumberType type = NumberType::f32;
  std::optional<NumberType> count_type;  // set for lists
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;

  [[nodiscard]] bool has_lists() const {
    return std::ranges::any_of(properties, [](const PlyProperty& p) { return p.count_type.has_value(); });
  }
  // Returns the least size of an element in a binary file.
  [[nodiscard]] std::size_t least_bytes() const {
    std::size_t bytes = 0;
    for (const PlyProperty& p : properties) bytes += number_size(p.count_type.value_or(p.type));
    return bytes;
  }
};

struct PlyFile {
  bool is_text = false;
  std::endian endian = std::endian::little;
  std::vector<PlyElement> elements;
  std::size_t vertices = 0;  // index of the vertex element
  Notes notes;

  [[nodiscard]] const PlyElement& vertex() const { return elements[vertices]; }
};

NumberType ply_type(const ContentReader& content, std::string_view name) {
  struct TypeName {
    std::string_view name;
    std::string_view other;
    NumberType type;
  };
  static constexpr std::array kTypes{
      TypeName{"char", "int8", NumberType::i8},      TypeName{"uchar", "uint8", NumberType::u8},
      TypeName{"short", "int16", NumberType::i16},   TypeName{"ushort", "uint16", NumberType::u16},
      TypeName{"int", "int32", NumberType::i32},     TypeName{"uint", "uint32", NumberType::u32},
      TypeName{"float", "float32", NumberType::f32}, TypeName{"double", "float64", NumberType::f64},
  };
  const auto* const found =
      std::ranges::find_if(kTypes, [&](const TypeName& t) { return t.name == name || t.other == name; });
  if (found == kTypes.end()) content.expected("a type such as float or uint", name);
  return found->type;
}

void read_ply_property(const ContentReader& content, std::span<const std::string_view> words, PlyFile& ply) {
  if (ply.elements.empty()) content.expected("an element before its properties", words[0]);
  PlyElement& element = ply.elements.back();
  const bool is_list = words.size() > 1 && words[1] == "list";
  if (words.size() != (is_list ? 5 : 3)) content.expected("a type and a name of a property", words.back());
  if (element.properties.size() == kMaxParticleColumns) content.expected("fewer properties", words.back());
  PlyProperty property;
  if (is_list) property.count_type = ply_type(content, words[2]);
  property.type = ply_type(content, words[words.size() - 2]);
  property.name = words.back();
  element.properties.push_back(std::move(property));
}

void read_ply_format(const ContentReader& content, std::string_view name, PlyFile& ply) {
  if (name == "binary_big_endian") {
    ply.endian = std::endian::big;
  } else if (name == "ascii") {
    ply.is_text = true;
  } else if (name != "binary_little_endian") {
    content.expected("ascii, binary_little_endian or binary_big_endian", name);
  }
}

void check_ply_is_particles(const PlyFile& ply) {
  for (const PlyElement& element : ply.elements) {
    if (element.name != "face" && element.name != "tristrips") continue;
    if (element.count == 0) continue;
    throw InvalidParticleFile(fmt::format("expected particles, found a mesh: a PLY file with {} {}", element.count,
                                          element.name == "face" ? "faces" : "triangle strips"),
                              "write its vertices alone, without faces");
  }
}

// Limit of the header, whose elements and properties are kept in memory; a compressed file could have any number of
// them.
constexpr std::uint64_t kMaxPlyHeaderBytes = std::uint64_t{1} << 20;  // bytes

PlyFile read_ply_header(ContentReader& content) {
  PlyFile ply;
  bool has_format = false;
  std::vector<std::string_view> words;
  const auto magic = content.next_line();
  if (!magic || *magic != "ply") content.expected("'ply'", magic.value_or(""));
  while (true) {
    const auto line = content.next_line();
    if (!line) throw InvalidParticleFile("expected 'end_header' in a PLY file, found none");
    if (content.position() > kMaxPlyHeaderBytes) {
      throw InvalidParticleFile(fmt::format("expected 'end_header' within {} bytes, found none", kMaxPlyHeaderBytes));
    }
    split_words(*line, words);
    if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
    if (words[0] == "end_header") break;
    if (words[0] == "format" && words.size() == 3) {
      read_ply_format(content, words[1], ply);
      has_format = true;
    } else if (words[0] == "element" && words.size() == 3) {
      const auto count = parse_whole_number(words[2]);
      if (!count) content.expected("a number of elements", words[2]);
      if (ply.elements.size() == kMaxParticleColumns) content.expected("fewer elements", words[1]);
      ply.elements.push_back({std::string(words[1]), *count, {}});
    } else if (words[0] == "property") {
      read_ply_property(content, words, ply);
    } else {
      content.expected("format, element, property or comment", *line);
    }
  }
  if (!has_format) throw InvalidParticleFile("expected a line 'format ...' in the header of a PLY file, found none");
  check_ply_is_particles(ply);
  const auto vertex = std::ranges::find(ply.elements, "vertex", &PlyElement::name);
  if (vertex == ply.elements.end()) {
    throw InvalidParticleFile("expected the element 'vertex' in the header of a PLY file, found none");
  }
  ply.vertices = static_cast<std::size_t>(vertex - ply.elements.begin());
  return ply;
}

// Makes a column for each number of a vertex. Lists have no columns; remove_list_words() removes them from rows of
// text.
ParticleTable ply_table(PlyFile& ply) {
  ParticleTable table;
  for (const PlyProperty& property : ply.vertex().properties) {
    if (property.count_type) {
      ply.notes.push_back(
          {NoteId::data_left_out, fmt::format("the reader skips the lists '{}'", printable(property.name, 80))});
    } else {
      table.columns.push_back({property.name, {}, std::string(number_name(property.type)), true});
    }
  }
  group_by_names(table);
  return table;
}

std::uint64_t list_length(const PlyProperty& property, double length) {
  if (!(length >= 0) || length != std::floor(length) || length > 4294967295.0) {
    throw InvalidParticleFile(
        fmt::format("expected a whole number up to 4294967295 as the length of a list '{}', found {}",
                    printable(property.name, 80), length));
  }
  return static_cast<std::uint64_t>(length);
}

// Reads one element of a binary file: its numbers go into `record`, its lists are skipped.
void walk_ply_element(ContentReader& content, const PlyFile& ply, const PlyElement& element,
                      std::vector<std::byte>& record) {
  record.clear();
  for (const PlyProperty& property : element.properties) {
    const auto bytes = content.take(number_size(property.count_type.value_or(property.type)), property.name);
    if (!property.count_type) {
      record.insert(record.end(), bytes.begin(), bytes.end());
      continue;
    }
    double length = 0;
    for_each_number(*property.count_type, ply.endian, bytes.data(), 0, 1,
                    [&](std::size_t, double value) { length = value; });
    content.skip(list_length(property, length) * number_size(property.type), property.name);
  }
}

// Skips to the vertices.
void skip_to_vertices(ContentReader& content, const PlyFile& ply) {
  std::vector<std::byte> record;
  for (std::size_t i = 0; i < ply.vertices; ++i) {
    const PlyElement& element = ply.elements[i];
    if (ply.is_text) {
      skip_rows(content, element.count);
      continue;
    }
    check_count(content, element.count, element.least_bytes());
    if (!element.has_lists()) {
      content.skip(element.count * element.least_bytes(), element.name);
      continue;
    }
    for (std::uint64_t k = 0; k < element.count; ++k) walk_ply_element(content, ply, element, record);
  }
}

// Removes the words that belong to lists from a line.
void remove_list_words(const ContentReader& content, const PlyElement& vertex, std::vector<std::string_view>& words) {
  std::size_t from = 0;
  std::vector<std::string_view> numbers;
  for (const PlyProperty& property : vertex.properties) {
    if (from >= words.size()) content.expected(fmt::format("'{}'", printable(property.name, 80)), "");
    if (property.count_type) {
      const auto length = number_in(words[from]);
      if (!length) content.expected("the length of a list", words[from]);
      from += static_cast<std::size_t>(list_length(property, *length));
    } else {
      numbers.push_back(words[from]);
    }
    ++from;
  }
  if (from != words.size())
    content.expected(fmt::format("{} values of a vertex (not {})", from, words.size()), words[0]);
  words = std::move(numbers);
}

void read_ply_rows(ContentReader& content, const PlyElement& vertex, const ParticleTable& table,
                   std::span<const ColumnSink> sinks) {
  if (!vertex.has_lists()) return read_rows(content, table, vertex.count, sinks);
  std::vector<std::string_view> words;
  for (std::uint64_t v = 0; v < vertex.count; ++v) {
    const auto line = content.next_line();
    if (!line) throw InvalidParticleFile(fmt::format("expected {} vertices, found {}", vertex.count, v));
    split_words(*line, words);
    remove_list_words(content, vertex, words);
    deliver_row(content, table, words, static_cast<std::size_t>(v), sinks);
  }
}

void read_ply_records(ContentReader& content, const PlyFile& ply, std::span<const ColumnSink> sinks) {
  const PlyElement& vertex = ply.vertex();
  RecordLayout layout;
  for (const PlyProperty& property : vertex.properties) {
    if (property.count_type) continue;
    layout.fields.push_back({property.type, layout.bytes, ply.endian});
    layout.bytes += number_size(property.type);
  }
  if (!vertex.has_lists()) return read_records(content, layout, vertex.count, sinks);
  std::vector<std::byte> record;
  for (std::uint64_t v = 0; v < vertex.count; ++v) {
    walk_ply_element(content, ply, vertex, record);
    deliver_records(layout, record, static_cast<std::size_t>(v), sinks);
  }
}

class PlyParticles final : public ParticleFormat {
 public:
  PlyParticles()
      : ParticleFormat(
            {.id = "ply", .title = "PLY without faces, text or binary", .extensions = {".ply"}, .has_columns = true}) {}

  [[nodiscard]] bool probe(const files::FileStart& start) const override {
    return files::starts_with(start.bytes, "ply\n") || files::starts_with(start.bytes, "ply\r");
  }

  [[nodiscard]] ParticleInfo info(const files::InputFile& file, const ParticleReadOptions& options) const override {
    ContentReader content(file);
    PlyFile ply = read_ply_header(content);
    ParticleInfo info;
    const ParticleTable table = ply_table(ply);
    info.notes = ply.notes;
    info.particles = ply.vertex().count;
    describe_table(table, options, info);
    return info;
  }

  [[nodiscard]] ParticleFile read(const files::InputFile& file, const ParticleReadOptions& options) const override {
    ContentReader content(file);
    PlyFile ply = read_ply_header(content);
    const ParticleTable table = ply_table(ply);
    const ColumnChoice choice = choose_columns(table, options);
    skip_to_vertices(content, ply);
    const PlyElement& vertex = ply.vertex();
    // A value in text has at least a character and a separator.
    check_count(content, vertex.count, ply.is_text ? 2 * vertex.properties.size() - 1 : vertex.least_bytes());
    ParticleFile result;
    result.particles = make_particles(file.context(), file.name(), vertex.count, choice);
    const auto sinks = sinks_of(result.particles, choice);
    if (ply.is_text) {
      read_ply_rows(content, vertex, table, sinks);
    } else {
      read_ply_records(content, ply, sinks);
    }
    result.notes = std::move(ply.notes);
    result.notes.insert(result.notes.end(), choice.notes.begin(), choice.notes.end());
    return result;
  }
};

}  // namespace

const ParticleFormat& ply_particles() {
  static const PlyParticles format;
  return format;
}

}  // namespace isoextract::particle_io
