// Points of Houdini's geometry files: the BGEO format before version 12, still written by other programs ("BgeoV",
// big-endian), and its successor (houdini_geometry). Both may be gzip.
#include <algorithm>
#include <bit>

#include <fmt/format.h>

#include "base/printable.hpp"
#include "files/file_start.hpp"
#include "particle_io/detail/particle_columns.hpp"
#include "particle_io/formats/houdini_geometry.hpp"
#include "particle_io/formats/houdini_json.hpp"

namespace isoextract::particle_io {
namespace {

constexpr std::string_view kBgeoMagic = "BgeoV";
constexpr std::size_t kMaxNameBytes = 1024;  // Houdini's own names are far shorter

std::uint32_t bgeo_whole(ContentReader& content, std::size_t bytes, std::string_view what) {
  std::uint32_t value = 0;
  for (const std::byte b : content.take(bytes, what)) value = value << 8 | std::to_integer<std::uint32_t>(b);
  return value;
}

// Reads a size or a count.
std::uint32_t bgeo_count(ContentReader& content, std::string_view what) {
  const std::uint32_t value = bgeo_whole(content, 4, what);
  if (value > 0x7fffffff) {
    throw InvalidParticleFile(fmt::format("expected the number of {} (0 or more) before byte {}, found {}", what,
                                          content.position(), std::bit_cast<std::int32_t>(value)));
  }
  return value;
}

std::string bgeo_text(ContentReader& content, std::string_view what) {
  const std::size_t length = bgeo_whole(content, 2, what);
  const auto bytes = content.take(length, what);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

struct BgeoFile {
  std::uint64_t points = 0;
  ParticleTable table;
  RecordLayout layout;
  Notes notes;
};

// Reads the definition of a point attribute and its default; adds its columns and their byte offsets in a record.
void read_bgeo_attribute(ContentReader& content, BgeoFile& bgeo) {
  const std::string name = bgeo_text(content, "the name of an attribute");
  if (name.size() > kMaxNameBytes) {
    throw InvalidParticleFile(fmt::format("the attribute name that ends at byte {} has {} bytes; expected at most {}",
                                          content.position(), name.size(), kMaxNameBytes));
  }
  const std::size_t size = bgeo_whole(content, 2, "the size of an attribute");
  const std::uint32_t type = bgeo_whole(content, 4, "the type of an attribute");
  constexpr std::uint32_t kFloat = 0;
  constexpr std::uint32_t kInteger = 1;
  constexpr std::uint32_t kIndex = 4;  // index of a text
  constexpr std::uint32_t kVector = 5;
  if (type != kFloat && type != kInteger && type != kIndex && type != kVector) {
    throw InvalidParticleFile(fmt::format(
        "expected type 0 (float), 1 (integer), 4 (text) or 5 (vector) of the attribute '{}', found type {}, "
        "whose size is unknown",
        printable(name, 80), type));
  }
  if (bgeo.table.columns.size() + size > kMaxParticleColumns)
    throw InvalidParticleFile(fmt::format("expected at most {} numbers per particle, found more", kMaxParticleColumns));
  if (type == kIndex) {
    const std::uint32_t texts = bgeo_count(content, "texts");
    check_count(content, texts, 2);
    for (std::uint32_t i = 0; i < texts; ++i) static_cast<void>(bgeo_text(content, "a text"));
  } else {
    content.skip(4 * size, "the default of an attribute");
  }
  const bool is_whole = type == kInteger || type == kIndex;
  // By Houdini's convention, vectors named N are normals.
  const std::optional<AttributeKind> kind =
      type != kVector ? std::nullopt : std::optional(name == "N" ? AttributeKind::normal : AttributeKind::vector);
  add_tuple(bgeo.table, name, type == kIndex ? "text" : is_whole ? "i32" : "f32", size, type != kIndex, kind);
  for (std::size_t i = 0; i < size; ++i) {
    bgeo.layout.fields.push_back({is_whole ? NumberType::i32 : NumberType::f32, bgeo.layout.bytes, std::endian::big});
    bgeo.layout.bytes += 4;
  }
}

// Reads up to the first point.
BgeoFile read_bgeo_header(ContentReader& content) {
  static_cast<void>(content.take(kBgeoMagic.size(), "the magic"));
  const std::uint32_t version = bgeo_whole(content, 4, "the version");
  if (version != 5) throw InvalidParticleFile(fmt::format("expected BGEO version 5, found {}", version));
  BgeoFile bgeo;
  bgeo.points = bgeo_count(content, "points");
  const std::uint32_t primitives = bgeo_count(content, "primitives");
  static_cast<void>(bgeo_count(content, "groups of points"));
  static_cast<void>(bgeo_count(content, "groups of primitives"));
  const std::uint32_t attributes = bgeo_count(content, "attributes of points");
  static_cast<void>(bgeo_count(content, "attributes of vertices"));
  static_cast<void>(bgeo_count(content, "attributes of primitives"));
  static_cast<void>(bgeo_count(content, "attributes"));
  if (primitives > 0) {
    bgeo.notes.push_back(
        {NoteId::data_left_out, fmt::format("the reader skips {} primitives and reads their points", primitives)});
  }
  // The fourth number of a position is its spline weight.
  add_tuple(bgeo.table, "position", "f32", 3);
  bgeo.table.position = {0, 1, 2};
  for (std::size_t i = 0; i < 3; ++i) bgeo.layout.fields.push_back({NumberType::f32, 4 * i, std::endian::big});
  bgeo.layout.bytes = 16;
  check_count(content, attributes, 8);
  for (std::uint32_t i = 0; i < attributes; ++i) read_bgeo_attribute(content, bgeo);
  make_group_names_unique(bgeo.table);
  return bgeo;
}

class BgeoParticles final : public ParticleFormat {
 public:
  BgeoParticles()
      : ParticleFormat({.id = "bgeo",
                        .title = "Houdini geometry, points and their attributes, plain or gzip",
                        .extensions = {".bgeo", ".bgeo.sc"}}) {}

  [[nodiscard]] bool probe(const files::FileStart& start) const override {
    return files::starts_with(start.bytes, kBgeoMagic) || is_houdini(start.bytes);
  }

  [[nodiscard]] ParticleInfo info(const files::InputFile& file, const ParticleReadOptions& options) const override {
    if (is_newer(file)) return houdini_info(file, options);
    ContentReader content(file);
    const BgeoFile bgeo = read_bgeo_header(content);
    ParticleInfo info;
    info.particles = bgeo.points;
    info.notes = bgeo.notes;
    describe_table(bgeo.table, options, info);
    return info;
  }

  [[nodiscard]] ParticleFile read(const files::InputFile& file, const ParticleReadOptions& options) const override {
    if (is_newer(file)) return read_houdini(file, scan_houdini(file), options);
    ContentReader content(file);
    BgeoFile bgeo = read_bgeo_header(content);
    const ColumnChoice choice = choose_columns(bgeo.table, options);
    check_count(content, bgeo.points, bgeo.layout.bytes);
    ParticleFile result;
    result.particles = make_particles(file.context(), file.name(), bgeo.points, choice);
    read_records(content, bgeo.layout, bgeo.points, sinks_of(result.particles, choice));
    result.creator = kHoudiniFormat;
    result.notes = std::move(bgeo.notes);
    result.notes.insert(result.notes.end(), choice.notes.begin(), choice.notes.end());
    return result;
  }

 private:
  static bool is_houdini(std::span<const std::byte> start) {
    return files::starts_with(start, kHoudiniMagicLittle) || files::starts_with(start, kHoudiniMagicBig);
  }

  // Returns whether the content is the newer format. Throws if it has neither format.
  static bool is_newer(const files::InputFile& file) {
    const auto start = must(files::first_bytes(file, 16));
    if (is_houdini(start)) return true;
    if (files::starts_with(start, kBgeoMagic)) return false;
    if (files::starts_with(start, "scf1")) {
      throw InvalidParticleFile(
          "expected BGEO, plain or gzip, found blosc compression (.bgeo.sc), which the reader does not support",
          "save it as .bgeo or .bgeo.gz");
    }
    throw InvalidParticleFile(
        fmt::format("not BGEO: expected 'BgeoV' or '\\x7fNSJb' at the start, found '{}'", printable(start, 16)));
  }
};

}  // namespace

const ParticleFormat& bgeo_particles() {
  static const BgeoParticles format;
  return format;
}

}  // namespace isoextract::particle_io
