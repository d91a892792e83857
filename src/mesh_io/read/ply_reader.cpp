// Reads PLY (Greg Turk, 1994) as text, little-endian or big-endian: the elements "vertex" and "face"; skips other
// elements.
//
// Vertex attributes are: red, green, blue and alpha as one color, if they share a type that a color can have; up to
// four consecutive properties a_0, a_1, ... of one type as the components of a; and every other number.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include <fmt/format.h>

#include "base/checked.hpp"
#include "mesh_io/detail/placement_entry.hpp"
#include "mesh_io/read/mesh_format_readers.hpp"

namespace isoextract::mesh_io {
namespace {

using mesh::ComponentType;

struct TypeName {
  std::string_view name;
  std::string_view other;
  ComponentType type;
  std::size_t size;
};
constexpr std::array kPlyTypes{
    TypeName{"char", "int8", ComponentType::i8, 1},      TypeName{"uchar", "uint8", ComponentType::u8, 1},
    TypeName{"short", "int16", ComponentType::i16, 2},   TypeName{"ushort", "uint16", ComponentType::u16, 2},
    TypeName{"int", "int32", ComponentType::i32, 4},     TypeName{"uint", "uint32", ComponentType::u32, 4},
    TypeName{"float", "float32", ComponentType::f32, 4}, TypeName{"double", "float64", ComponentType::f64, 8},
};

const TypeName& type_named(const TextScanner& header, std::string_view name) {
  const auto* found = std::find_if(kPlyTypes.begin(), kPlyTypes.end(),
                                   [&](const TypeName& t) { return t.name == name || t.other == name; });
  if (found == kPlyTypes.end()) header.expected("a type such as float or uint", name);
  return *found;
}

struct Property {
  std::string name;
  TypeName type;
  std::optional<TypeName> count_type;  // set for a list
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;

  // Returns the least number of bytes that one element takes in the file.
  [[nodiscard]] std::uint64_t least_bytes(bool text) const {
    std::uint64_t bytes = 0;
    for (const Property& p : properties) bytes += text ? 2 : p.count_type ? p.count_type->size : p.type.size;
    return bytes;
  }
  [[nodiscard]] std::optional<std::size_t> find(std::string_view property) const {
    for (std::size_t i = 0; i < properties.size(); ++i) {
      if (properties[i].name == property) return i;
    }
    return std::nullopt;
  }
};

enum class BodyEncoding { text, little, big };

struct Header {
  BodyEncoding encoding = BodyEncoding::text;
  std::vector<Element> elements;
  std::size_t bytes = 0;
  bool is_by_isoextract = false;  // from a comment
  std::string placement;          // from a comment
};

// Upper bound of the memory for a header line: a property with its name, and its values in one element.
constexpr std::uint64_t kHeaderLineBytes = 512;

Header read_header(std::string_view text, MemoryUse& memory) {
  Header header;
  // Lines end with line feeds or, if the header has none, with carriage returns. This is decided first, because the
  // data after the header may be binary.
  const bool has_line_feeds = text.substr(0, text.find("end_header")).find('\n') != std::string_view::npos;
  TextScanner scanner(text, has_line_feeds ? '\n' : '\r');
  scanner.next_line();  // "ply"
  bool has_format = false;
  bool ended = false;
  while (!ended && scanner.next_line()) {
    const std::string_view keyword = scanner.word();
    memory.take(kHeaderLineBytes);
    if (keyword == "format") {
      const std::string_view name = scanner.word();
      has_format = true;
      if (name == "ascii") {
        header.encoding = BodyEncoding::text;
      } else if (name == "binary_little_endian") {
        header.encoding = BodyEncoding::little;
      } else if (name == "binary_big_endian") {
        header.encoding = BodyEncoding::big;
      } else {
        scanner.expected("ascii, binary_little_endian or binary_big_endian", name);
      }
    } else if (keyword == "element") {
      Element element;
      element.name = scanner.word();
      const std::int64_t count = scanner.whole_number(scanner.word());
      if (count < 0) scanner.expected("a number of elements", std::to_string(count));
      element.count = static_cast<std::uint64_t>(count);
      header.elements.push_back(std::move(element));
    } else if (keyword == "property") {
      if (header.elements.empty()) scanner.expected("an element before its properties", keyword);
      const std::string_view word = scanner.word();
      Property property;
      if (word == "list") property.count_type = type_named(scanner, scanner.word());
      property.type = type_named(scanner, word == "list" ? scanner.word() : word);
      property.name = scanner.word();
      header.elements.back().properties.push_back(std::move(property));
    } else if (keyword == "end_header") {
      if (const std::string_view more = scanner.word(); !more.empty())
        scanner.expected("nothing after end_header", more);
      ended = true;
    } else if (keyword == "comment") {
      const std::string_view word = scanner.word();
      header.is_by_isoextract = header.is_by_isoextract || word == kProgram;
      if (word == kPlacementEntry) header.placement = scanner.rest_of_line().substr(0, kMaxPlacement + 1);
    } else if (keyword != "obj_info" && !keyword.empty()) {
      scanner.expected("format, element, property or comment", keyword);
    }
  }
  if (!ended) throw DamagedMesh("expected 'end_header' in a PLY file, found none");
  header.bytes = text.size() - scanner.rest().size();
  if (!has_format) throw DamagedMesh("expected a line 'format ...' in the header of a PLY file, found none");
  return header;
}

class TextBody {
 public:
  explicit TextBody(std::string_view text) : scanner_(text), size_(text.size()) {}
  [[nodiscard]] std::uint64_t size() const { return size_; }
  double next(const TypeName&) {
    const std::string_view word = scanner_.next_word_across_lines();
    if (word.empty())
      throw DamagedMesh("expected more numbers after the header of a PLY file, found the end of the file");
    return scanner_.number(word);
  }
  // Returns the first word after the last element, for a note; empty if there is none.
  std::string_view left() { return scanner_.next_word_across_lines(); }

 private:
  TextScanner scanner_;
  std::uint64_t size_;
};

class BinaryBody {
 public:
  BinaryBody(std::string_view bytes, bool big_endian) : rest_(bytes), swap_(big_endian), size_(bytes.size()) {}
  [[nodiscard]] std::uint64_t size() const { return size_; }
  double next(const TypeName& type) {
    switch (type.type) {
      case ComponentType::i8: return as<std::int8_t>();
      case ComponentType::u8: return as<std::uint8_t>();
      case ComponentType::i16: return as<std::int16_t>();
      case ComponentType::u16: return as<std::uint16_t>();
      case ComponentType::i32: return as<std::int32_t>();
      case ComponentType::u32: return as<std::uint32_t>();
      case ComponentType::f32: return static_cast<double>(as<float>());
      case ComponentType::f64: break;
    }
    return as<double>();
  }
  [[nodiscard]] std::string_view left() const { return rest_; }

 private:
  template <class T>
  T as() {
    if (rest_.size() < sizeof(T)) {
      throw DamagedMesh(
          fmt::format("expected more data than the {} bytes that follow the header of a PLY file", size_));
    }
    std::array<char, sizeof(T)> bytes;
    std::copy_n(rest_.begin(), sizeof(T), bytes.begin());
    if (swap_) std::reverse(bytes.begin(), bytes.end());
    rest_.remove_prefix(sizeof(T));
    return std::bit_cast<T>(bytes);
  }

  std::string_view rest_;
  bool swap_;
  std::uint64_t size_;
};

// The values of one element; each list is a vector.
template <class Body>
class ElementReader {
 public:
  ElementReader(Body& body, const Element& element, MemoryUse& memory)
      : body_(body),
        element_(element),
        memory_(memory),
        scalars_(element.properties.size()),
        lists_(element.properties.size()) {}

  void next() {
    for (std::size_t i = 0; i < element_.properties.size(); ++i) {
      const Property& property = element_.properties[i];
      if (!property.count_type) {
        scalars_[i] = body_.next(property.type);
        continue;
      }
      const double count = body_.next(*property.count_type);
      if (!(count >= 0) || count != std::floor(count)) {
        throw DamagedMesh(
            fmt::format("expected a whole number as the length of a list '{}', found {}", property.name, count));
      }
      std::vector<double>& list = lists_[i];
      list.clear();
      for (double k = 0; k < count; ++k) {
        memory_.make_room(list, 1);
        list.push_back(body_.next(property.type));
      }
    }
  }
  [[nodiscard]] double scalar(std::size_t property) const { return scalars_[property]; }
  [[nodiscard]] const std::vector<double>& list(std::size_t property) const { return lists_[property]; }

 private:
  Body& body_;
  const Element& element_;
  MemoryUse& memory_;
  std::vector<double> scalars_;
  std::vector<std::vector<double>> lists_;
};

// A vertex attribute, and the properties that form its components.
struct AttributeColumns {
  mesh::Attribute kind;
  std::vector<std::size_t> columns;
};

bool can_be_color(ComponentType type) {
  return type == ComponentType::u8 || type == ComponentType::u16 || type == ComponentType::f32;
}

std::optional<AttributeColumns> find_color(const Element& element) {
  AttributeColumns color;
  color.kind.name = "color";
  color.kind.role = mesh::AttributeRole::color;
  for (const char* name : {"red", "green", "blue", "alpha"}) {
    const auto found = element.find(name);
    const Property* property = found ? &element.properties[*found] : nullptr;
    const bool fits = property != nullptr && !property->count_type && can_be_color(property->type.type) &&
                      (color.columns.empty() || property->type.type == color.kind.type);
    if (!fits && color.columns.size() < 3) return std::nullopt;
    if (!fits) break;
    color.kind.type = property->type.type;
    color.columns.push_back(*found);
  }
  color.kind.components = color.columns.size();
  color.kind.normalized = color.kind.type != ComponentType::f32;
  return color;
}

std::vector<AttributeColumns> find_attributes(const Element& element, Notes& notes) {
  std::vector<AttributeColumns> found;
  std::vector<bool> taken(element.properties.size());
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz"}) {
    if (const auto column = element.find(name)) taken[*column] = true;
  }
  if (auto color = find_color(element)) {
    for (const std::size_t column : color->columns) taken[column] = true;
    found.push_back(std::move(*color));
  }
  for (std::size_t i = 0; i < taken.size(); ++i) {
    const Property& property = element.properties[i];
    if (taken[i]) continue;
    if (property.count_type) {
      notes.push_back(
          {NoteId::data_left_out, fmt::format("the reader skips the lists '{}' of the vertices", property.name)});
      continue;
    }
    std::string stem = property.name;
    std::size_t count = 1;
    if (stem.ends_with("_0")) {
      stem.resize(stem.size() - 2);
      const auto follows = [&](std::size_t next) {
        return next < taken.size() && !taken[next] && !element.properties[next].count_type &&
               element.properties[next].type.type == property.type.type &&
               element.properties[next].name == fmt::format("{}_{}", stem, next - i);
      };
      while (follows(i + count)) ++count;
    }
    const bool together = count > 1 && count <= mesh::kMaxComponents;
    AttributeColumns attribute;
    attribute.kind.name = together ? stem : property.name;
    attribute.kind.type = property.type.type;
    attribute.kind.components = together ? count : 1;
    for (std::size_t c = 0; c < attribute.kind.components; ++c) {
      attribute.columns.push_back(i + c);
      taken[i + c] = true;
    }
    found.push_back(std::move(attribute));
  }
  return found;
}

// Appends the number as type T. Returns false if T cannot represent it.
template <class T>
bool append(std::vector<std::byte>& values, double number) {
  using Range = std::numeric_limits<T>;
  const bool inside = number >= static_cast<double>(Range::lowest()) && number <= static_cast<double>(Range::max());
  if constexpr (std::is_integral_v<T>) {
    if (!inside || number != std::floor(number)) return false;
  } else {
    if (!inside && std::isfinite(number)) return false;
  }
  const auto bytes = std::bit_cast<std::array<std::byte, sizeof(T)>>(static_cast<T>(number));
  values.insert(values.end(), bytes.begin(), bytes.end());
  return true;
}

bool append(std::vector<std::byte>& values, ComponentType type, double number) {
  switch (type) {
    case ComponentType::i8: return append<std::int8_t>(values, number);
    case ComponentType::u8: return append<std::uint8_t>(values, number);
    case ComponentType::i16: return append<std::int16_t>(values, number);
    case ComponentType::u16: return append<std::uint16_t>(values, number);
    case ComponentType::i32: return append<std::int32_t>(values, number);
    case ComponentType::u32: return append<std::uint32_t>(values, number);
    case ComponentType::f32: return append<float>(values, number);
    case ComponentType::f64: break;
  }
  return append<double>(values, number);
}

// Returns the columns of nx, ny and nz if all exist and are not lists.
std::optional<std::array<std::size_t, 3>> find_normals(const Element& element) {
  std::array<std::size_t, 3> columns{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto found = element.find(std::string{'n', "xyz"[axis]});
    if (!found || element.properties[*found].count_type) return std::nullopt;
    columns[axis] = *found;
  }
  return columns;
}

template <class Body>
void read_vertices(Body& body, const Element& element, const MeshSource& source, FileSurface& surface) {
  MemoryUse& memory = source.memory;
  std::array<std::size_t, 3> columns{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::string_view name = std::string_view("xyz").substr(axis, 1);
    const auto found = element.find(name);
    if (!found || element.properties[*found].count_type) {
      throw DamagedMesh(fmt::format("expected a numeric vertex property '{}' in the header, found none", name));
    }
    columns[axis] = *found;
  }
  require_vertex_count(element.count);
  memory.make_room(surface.positions, element.count);
  std::vector<AttributeColumns> attributes = find_attributes(element, surface.notes);
  surface.has_normals = element.find("nx").has_value();
  if (surface.has_normals) surface.left_out.insert("normals");
  const std::size_t first = surface.attributes.size();
  for (AttributeColumns& attribute : attributes) {
    surface.attributes.push_back({std::move(attribute.kind), {}});
    memory.make_room(surface.attributes.back().values, element.count * surface.attributes.back().kind.stride());
  }
  const auto normals = source.with_normals ? find_normals(element) : std::nullopt;
  if (normals) memory.make_room(surface.normals.values, element.count);
  ElementReader reader(body, element, memory);
  for (std::uint64_t v = 0; v < element.count; ++v) {
    reader.next();
    surface.positions.emplace_back(reader.scalar(columns[0]), reader.scalar(columns[1]), reader.scalar(columns[2]));
    if (normals) {
      const auto [x, y, z] = *normals;
      surface.normals.values.emplace_back(reader.scalar(x), reader.scalar(y), reader.scalar(z));
    }
    for (std::size_t a = 0; a < attributes.size(); ++a) {
      FileAttribute& attribute = surface.attributes[first + a];
      for (const std::size_t column : attributes[a].columns) {
        if (append(attribute.values, attribute.kind.type, reader.scalar(column))) continue;
        throw DamagedMesh(fmt::format("expected a value of type {} for the property '{}' of vertex {}, found {}",
                                      element.properties[column].type.name, element.properties[column].name, v,
                                      reader.scalar(column)));
      }
    }
  }
}

template <class Body>
void read_faces(Body& body, const Element& element, MemoryUse& memory, FileSurface& surface) {
  auto column = element.find("vertex_indices");
  if (!column) column = element.find("vertex_index");
  if (!column || !element.properties[*column].count_type) {
    throw DamagedMesh("expected a face property 'vertex_indices', a list, in the header, found none");
  }
  memory.make_room(surface.triangles, element.count);
  ElementReader reader(body, element, memory);
  std::vector<std::uint32_t> corners;
  for (std::uint64_t f = 0; f < element.count; ++f) {
    reader.next();
    corners.clear();
    memory.make_room(corners, reader.list(*column).size());
    for (const double index : reader.list(*column)) {
      if (!(index >= 0 && index <= std::numeric_limits<std::uint32_t>::max()) || index != std::floor(index)) {
        throw DamagedMesh(fmt::format("expected the index of a vertex in face {}, found {}", f, index));
      }
      corners.push_back(static_cast<std::uint32_t>(index));
    }
    if (corners.size() < 3) {
      throw DamagedMesh(fmt::format("expected at least 3 corners of face {}, found {}", f, corners.size()));
    }
    add_polygon(surface.triangles, corners, memory);
  }
}

template <class Body>
void read_body(Body body, const Header& header, const MeshSource& source, FileSurface& surface) {
  MemoryUse& memory = source.memory;
  std::uint64_t left = body.size();
  for (const Element& element : header.elements) {
    const std::uint64_t least = element.least_bytes(header.encoding == BodyEncoding::text);
    const auto bytes = checked_product(element.count, least);
    // Text has no blank after the last number.
    if (!bytes || *bytes > left + 1) {
      throw DamagedMesh(
          fmt::format("expected {} elements '{}' of at least {} bytes each, found {} bytes left in the file",
                      element.count, element.name, least, left));
    }
    left -= std::min(left, *bytes);
    if (element.count > 0 && element.properties.empty()) {
      throw DamagedMesh(fmt::format("expected properties of the element '{}' in the header, found none", element.name));
    }
    if (element.name == "vertex") {
      read_vertices(body, element, source, surface);
    } else if (element.name == "face") {
      read_faces(body, element, memory, surface);
    } else {
      ElementReader reader(body, element, memory);
      for (std::uint64_t i = 0; i < element.count; ++i) reader.next();
      surface.notes.push_back(
          {NoteId::data_left_out, fmt::format("the reader skips {} elements '{}'", element.count, element.name)});
    }
  }
  if (!body.left().empty())
    surface.notes.push_back({NoteId::extra_bytes, "the reader skips the data after the last element"});
}

}  // namespace

FileSurface read_ply(const MeshSource& source) {
  const std::string_view text = source.text();
  if (!text.starts_with("ply")) {
    throw DamagedMesh(fmt::format("expected 'ply' at the start of a PLY file, found '{}'", files::printable(text, 16)));
  }
  const Header header = read_header(text, source.memory);
  FileSurface surface;
  surface.format = header.encoding == BodyEncoding::text ? "PLY, text" : "PLY, binary";
  surface.is_by_isoextract = header.is_by_isoextract;
  surface.placement = header.placement;
  const std::string_view body = text.substr(header.bytes);
  if (header.encoding == BodyEncoding::text) {
    read_body(TextBody(body), header, source, surface);
  } else {
    read_body(BinaryBody(body, header.encoding == BodyEncoding::big), header, source, surface);
  }
  return surface;
}

}  // namespace isoextract::mesh_io
