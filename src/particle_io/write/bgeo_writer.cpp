// Binary JSON of Houdini's geometry, in the machine's byte order (formats/houdini_json.hpp reads it). The members of
// the document and their order: https://www.sidefx.com/docs/houdini/io/formats/geo.html
#include <array>
#include <bit>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "base/version.hpp"
#include "particle_io/formats/houdini_json.hpp"
#include "particle_io/write/structured_writers.hpp"

namespace isoextract::particle_io {
namespace {

constexpr std::string_view kHoudiniMagic =
    std::endian::native == std::endian::little ? kHoudiniMagicLittle : kHoudiniMagicBig;
constexpr std::uint64_t kPageSize = 1024;  // elements; Houdini's own page size

// Codes of numbers in an array.
enum class NumberCode : char { int32 = 0x13, fpreal32 = 0x19, fpreal64 = 0x1a };

// Builds a sequence of tokens. An array that stands for a map alternates names and values.
class JsonText {
 public:
  JsonText& begin() { return code('['); }
  JsonText& end() { return code(']'); }
  JsonText& begin_map() { return code('{'); }
  JsonText& end_map() { return code('}'); }
  JsonText& text(std::string_view value) {
    code('\x27');
    length(value.size());
    bytes_ += value;
    return *this;
  }
  JsonText& whole(std::uint64_t value) {
    code('\x14');
    return raw(static_cast<std::int64_t>(value));
  }
  JsonText& no() { return code('\x30'); }
  // Begins an array of `count` numbers, whose bytes follow.
  JsonText& numbers(NumberCode type, std::uint64_t count) {
    code('\x40').code(static_cast<char>(type));
    length(count);
    return *this;
  }
  [[nodiscard]] const std::string& bytes() const { return bytes_; }

 private:
  JsonText& code(char value) {
    bytes_ += value;
    return *this;
  }
  template <class T>
  JsonText& raw(T value) {
    const auto bytes = std::bit_cast<std::array<char, sizeof(T)>>(value);
    bytes_.append(bytes.begin(), bytes.end());
    return *this;
  }
  void length(std::uint64_t count) {
    constexpr std::uint64_t kShort = 0xf0;
    if (count <= kShort) {
      code(static_cast<char>(count));
    } else {
      code('\xf8').raw(count);
    }
  }

  std::string bytes_;
};

// Returns Houdini's word for the kind of an attribute; empty for plain numbers.
std::string_view kind_word(std::optional<AttributeKind> kind) {
  if (kind == AttributeKind::vector) return "vector";
  if (kind == AttributeKind::normal) return "normal";
  if (kind == AttributeKind::point) return "point";
  if (kind == AttributeKind::color) return "color";
  return {};
}

// Adds an attribute up to its numbers, which follow.
void begin_attribute(JsonText& json, std::string_view name, std::string_view kind, std::uint64_t size, bool doubles,
                     std::uint64_t points) {
  const std::string_view storage = doubles ? "fpreal64" : "fpreal32";
  json.begin().begin().text("scope").text("public").text("type").text("numeric").text("name").text(name);
  json.text("options").begin_map();
  if (!kind.empty()) {
    json.text("type").begin_map().text("type").text("string").text("value").text(kind).end_map();
  }
  json.end_map().end().begin().text("size").whole(size).text("storage").text(storage);
  json.text("defaults").begin().text("size").whole(1).text("storage").text("fpreal64").text("values").begin();
  json.whole(0).end().end();
  json.text("values").begin().text("size").whole(size).text("storage").text(storage);
  json.text("packing").begin().whole(size).end().text("pagesize").whole(kPageSize);
  json.text("rawpagedata").numbers(doubles ? NumberCode::fpreal64 : NumberCode::fpreal32, points * size);
}

void end_attribute(JsonText& json) { json.end().end().end(); }

// Adds words up to their indices, which follow.
void begin_words(JsonText& json, const points::ParticleWords& words) {
  json.begin().begin().text("scope").text("public").text("type").text("string").text("name").text(words.name);
  json.text("options").begin_map().end_map().end();
  json.begin().text("size").whole(1).text("storage").text("int32").text("strings").begin();
  for (const std::string& word : words.words) json.text(word);
  json.end().text("indices").begin().text("size").whole(1).text("storage").text("int32");
  json.text("arrays").begin().numbers(NumberCode::int32, words.indices.size());
}

void end_words(JsonText& json) { json.end().end().end().end(); }

}  // namespace

Result<void> write_bgeo(files::OutputFile& file, const points::ParticleSet& particles) {
  const std::uint64_t points = particles.size();
  JsonText json;
  json.begin().text("fileversion").text("18.5.0").text("hasindex").no().text("pointcount").whole(points);
  json.text("vertexcount").whole(0).text("primitivecount").whole(0);
  json.text("info").begin_map().text("software").text(generator()).end_map();
  json.text("topology").begin().text("pointref").begin().text("indices").begin().end().end().end();
  json.text("attributes").begin().text("pointattributes").begin();
  begin_attribute(json, "P", "point", 3, true, points);
  TRY(file.write(kHoudiniMagic));
  TRY(file.write(std::string_view(json.bytes())));
  static_assert(sizeof(glm::dvec3) == 3 * sizeof(double));
  TRY(file.write(std::as_bytes(particles.positions.span())));
  for (const points::ParticleAttribute& attribute : particles.attributes) {
    JsonText next;
    end_attribute(next);
    begin_attribute(next, attribute.name, kind_word(attribute.kind), attribute.components, false, points);
    TRY(file.write(std::string_view(next.bytes())));
    TRY(file.write(std::as_bytes(attribute.values.span())));
  }
  JsonText end;
  end_attribute(end);
  TRY(file.write(std::string_view(end.bytes())));
  for (const points::ParticleWords& words : particles.words) {
    JsonText head;
    begin_words(head, words);
    TRY(file.write(std::string_view(head.bytes())));
    static_assert(sizeof(std::uint32_t) == sizeof(std::int32_t));  // at most kMaxDistinctWords words
    TRY(file.write(std::as_bytes(words.indices.span())));
    JsonText tail;
    end_words(tail);
    TRY(file.write(std::string_view(tail.bytes())));
  }
  JsonText last;
  last.end().end().text("primitives").begin().end().end();
  return file.write(std::string_view(last.bytes()));
}

}  // namespace isoextract::particle_io
