// Shared by the tests of particles: files made by hand, and comparisons of what a reader returns.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "particle_io/particle_reader.hpp"
#include "support/hints.hpp"
#include "unit/volume_io/volume_files.hpp"

namespace isoextract::test {

// A file's name and bytes; written to a temporary folder and read under its name there.
struct ParticleInput {
  std::string name;
  std::string bytes;
};

inline Result<particle_io::ParticleFile> try_particles(const ParticleInput& input,
                                                       const particle_io::ParticleReadOptions& options = {},
                                                       const Context& context = Context()) {
  const TempFolder folder;
  write_bytes(folder / input.name, input.bytes);
  return particle_io::read_particles((folder / input.name).string(), options, context);
}

inline particle_io::ParticleFile must_read_particles(const ParticleInput& input,
                                                     const particle_io::ParticleReadOptions& options = {}) {
  auto read = try_particles(input, options);
  if (!read) throw std::runtime_error(read.error().message + "\n" + test::text_of(read.error().hint));
  return std::move(*read);
}

inline Error particle_refusal(const ParticleInput& input, const particle_io::ParticleReadOptions& options = {},
                              const Context& context = Context()) {
  const auto read = try_particles(input, options, context);
  if (read) throw std::runtime_error(input.name + " was read");
  EXPECT_NE(read.error().message.find(input.name), std::string::npos) << read.error().message;
  EXPECT_EQ(context.memory().reserved(), 0U);
  return read.error();
}

inline particle_io::ParticleInfo must_inform(const ParticleInput& input,
                                             const particle_io::ParticleReadOptions& options = {}) {
  const TempFolder folder;
  write_bytes(folder / input.name, input.bytes);
  auto info = particle_io::list_particles((folder / input.name).string(), options, Context());
  if (!info) throw std::runtime_error(info.error().message + "\n" + test::text_of(info.error().hint));
  return std::move(*info);
}

inline particle_io::ParticleReadOptions with_attributes(std::vector<std::string> names) {
  particle_io::ParticleReadOptions options;
  options.attributes = std::move(names);
  return options;
}

inline particle_io::ParticleReadOptions with_all() {
  particle_io::ParticleReadOptions options;
  options.all_attributes = true;
  return options;
}

inline particle_io::ParticleReadOptions of_frame(std::int64_t frame) {
  particle_io::ParticleReadOptions options;
  options.frame = frame;
  return options;
}

inline void expect_positions(const points::ParticleSet& set, const std::vector<glm::dvec3>& expected) {
  ASSERT_EQ(set.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(set.positions[i].x, expected[i].x) << i;
    EXPECT_EQ(set.positions[i].y, expected[i].y) << i;
    EXPECT_EQ(set.positions[i].z, expected[i].z) << i;
  }
}

inline const points::ParticleAttribute& attribute_named(const points::ParticleSet& set, std::string_view name) {
  for (const points::ParticleAttribute& attribute : set.attributes) {
    if (attribute.name == name) return attribute;
  }
  throw std::runtime_error("no attribute " + std::string(name));
}

inline void expect_attribute(const points::ParticleSet& set, std::string_view name, std::size_t components,
                             const std::vector<float>& expected) {
  const points::ParticleAttribute& attribute = attribute_named(set, name);
  EXPECT_EQ(attribute.components, components);
  EXPECT_EQ(std::vector<float>(attribute.values.begin(), attribute.values.end()), expected) << name;
}

// Returns "name:components type [unit]" for each quantity; in brackets if not numeric.
inline std::vector<std::string> quantities_of(const particle_io::ParticleInfo& info) {
  std::vector<std::string> lines;
  for (const particle_io::ParticleQuantity& q : info.quantities) {
    std::string line = fmt::format("{}:{} {}", q.name, q.components, q.type);
    if (!q.unit.empty()) line += " in " + q.unit;
    lines.push_back(q.numeric ? line : "(" + line + ")");
  }
  return lines;
}

// All particle files here have three particles at (1,2,3), (4,5,6) and (7,8,9.5), with additional data of their format.
inline std::string ply_header(std::string_view format, std::string_view more = {}, std::size_t count = 3) {
  return fmt::format(
      "ply\nformat {} 1.0\ncomment made by hand\nelement vertex {}\nproperty float x\nproperty float y\n"
      "property double z\nproperty uchar kind\nproperty float vx\nproperty float vy\nproperty float vz\n{}end_header\n",
      format, count, more);
}

inline std::string ply_body(std::endian endian) {
  std::string body;
  for (int i = 0; i < 3; ++i) {
    const auto f = static_cast<float>(3 * i);
    body += pack(f + 1, endian) + pack(f + 2, endian) + pack(i == 2 ? 9.5 : static_cast<double>(f) + 3, endian);
    body += pack(static_cast<std::uint8_t>(200 + i));
    body += pack(-f, endian) + pack(0.5F, endian) + pack(f + 0.25F, endian);
  }
  return body;
}

// BGEO of Houdini up to version 11: big-endian.
inline std::string bgeo_classic(std::size_t count = 3) {
  constexpr auto kBig = std::endian::big;
  const auto whole = [&](std::size_t value) { return pack(static_cast<std::int32_t>(value), kBig); };
  const auto name = [&](const std::string& text) { return pack(static_cast<std::uint16_t>(text.size()), kBig) + text; };
  const auto size = [&](int value) { return pack(static_cast<std::uint16_t>(value), kBig); };
  std::string bytes = "BgeoV" + whole(5) + whole(count) + whole(0) + whole(0) + whole(0) + whole(3);
  bytes += whole(0) + whole(0) + whole(0);
  bytes += name("id") + size(1) + whole(1) + whole(0);
  bytes += name("tag") + size(1) + whole(4) + whole(2) + name("a") + name("bc");
  bytes += name("velocity") + size(3) + whole(5) + std::string(12, '\0');
  for (int i = 0; i < 3; ++i) {
    const auto f = static_cast<float>(3 * i);
    bytes += pack(f + 1, kBig) + pack(f + 2, kBig) + pack(i == 2 ? 9.5F : f + 3, kBig) + pack(1.0F, kBig);
    bytes += whole(std::size_t{70} + static_cast<std::size_t>(i)) + whole(1);
    bytes += pack(-f, kBig) + pack(0.5F, kBig) + pack(f + 0.25F, kBig);
  }
  return bytes + std::string("\0\0", 2);
}

// Tokens of Houdini's binary JSON.
class HoudiniBytes {
 public:
  explicit HoudiniBytes(std::endian endian = std::endian::little)
      : endian_(endian),
        bytes_(endian == std::endian::little ? "\x7FNSJb"
                                             : "\x7F"
                                               "bJSN") {}

  HoudiniBytes& text(const std::string& value) {
    bytes_ += '\x27';
    bytes_ += static_cast<char>(value.size());
    bytes_ += value;
    return *this;
  }
  // Defines a text once and refers to it afterward.
  HoudiniBytes& name(char id, const std::string& value) {
    bytes_ += '\x2b';
    bytes_ += id;
    bytes_ += static_cast<char>(value.size());
    bytes_ += value;
    return ref(id);
  }
  HoudiniBytes& ref(char id) {
    bytes_ += '\x26';
    bytes_ += id;
    return *this;
  }
  HoudiniBytes& whole(std::int32_t value) {
    bytes_ += '\x13';
    bytes_ += pack(value, endian_);
    return *this;
  }
  HoudiniBytes& begin() { return raw("["); }
  HoudiniBytes& end() { return raw("]"); }
  HoudiniBytes& raw(const std::string& bytes) {
    bytes_ += bytes;
    return *this;
  }
  template <class T>
  HoudiniBytes& numbers(char code, const std::vector<T>& values) {
    bytes_ += '\x40';
    bytes_ += code;
    bytes_ += '\xf2';
    bytes_ += pack(static_cast<std::uint16_t>(values.size()), endian_);
    for (const T value : values) bytes_ += pack(value, endian_);
    return *this;
  }
  [[nodiscard]] const std::string& bytes() const { return bytes_; }

 private:
  std::endian endian_;
  std::string bytes_;
};

// Pages have two elements. P is packed as x and y, then z; z is constant on the second page, which has one element.
inline std::string houdini_geometry(std::endian endian = std::endian::little, std::int32_t count = 3) {
  HoudiniBytes h(endian);
  h.begin().text("fileversion").text("18.5").text("hasindex").raw("0").name(1, "pointcount").whole(count);
  h.text("info").raw("{").text("a").begin().whole(1).end().raw("}").text("topology").begin();
  h.numbers<std::int32_t>('\x13', {0, 1, 2}).end().text("attributes").begin().text("vertexattributes").begin().end();
  h.text("pointattributes").begin();
  // P
  h.begin().begin().text("scope").text("public").name(2, "type").name(3, "numeric").name(4, "name").text("P");
  h.end().begin().name(5, "size").raw(std::string("\x11\x03", 2)).name(6, "storage").name(7, "fpreal32");
  h.text("defaults").begin().ref(5).whole(1).end().name(8, "values").begin().ref(5).whole(3).ref(6).ref(7);
  h.text("packing").begin().whole(2).whole(1).end().text("pagesize").whole(2);
  h.text("constantpageflags")
      .begin()
      .begin()
      .end()
      .raw(std::string("@\x10\x02", 3))
      .raw(pack(std::uint32_t{2}, endian))
      .end();
  h.text("rawpagedata").numbers<float>('\x19', {1, 2, 4, 5, 3, 6, 7, 8, 9.5F}).end().end().end();
  // velocity, one tuple after the other
  h.begin().begin().ref(2).ref(3).ref(4).text("v").text("options").raw("{").text("type").raw("{");
  h.text("type").text("string").text("value").text("normal").raw("}}").end().begin().ref(5).whole(3).ref(6).ref(7);
  h.ref(8).begin().ref(5).whole(3).ref(6).ref(7).text("tuples").begin();
  for (int i = 0; i < 3; ++i) {
    const auto f = static_cast<float>(3 * i);
    h.numbers<float>('\x19', {-f, 0.5F, f + 0.25F});
  }
  h.end().end().end().end();
  // A number that is constant on the first page.
  h.begin().begin().ref(2).ref(3).ref(4).text("heat").end().begin().ref(5).whole(1).ref(6).ref(7);
  h.ref(8).begin().ref(5).whole(1).ref(6).ref(7).text("pagesize").whole(2);
  h.text("constantpageflags").begin().begin().raw("10").end().end().text("rawpagedata");
  h.numbers<float>('\x19', {5, 6}).end().end().end();
  // id, in one array; a text, and a member of a later version
  h.begin().begin().ref(2).ref(3).ref(4).text("id").end().begin().ref(5).whole(1).ref(6).text("int32");
  h.ref(8).begin().ref(5).whole(1).ref(6).text("int32").text("arrays").begin();
  h.numbers<std::int32_t>('\x13', {70, 71, 72}).end().end().end().end();
  h.begin().begin().ref(2).text("string").ref(4).text("tag").end().begin().ref(5).whole(1).text("strings").begin();
  h.text("a").text("b").end().text("indices").begin().ref(5).whole(1).ref(6).text("int32").text("arrays").begin();
  h.numbers<std::int32_t>('\x13', {1, 0, 1}).end().end().end().end();
  h.begin().begin().ref(2).text("hologram").ref(4).text("odd").end().begin().text("depth").raw(std::string(1, '\0'));
  h.end().end().end().end().text("primitives").begin().end().end();
  return h.bytes();
}

inline std::string npy_bytes(const std::string& descr, const std::string& shape, const std::string& data,
                             bool fortran = false) {
  const std::string text =
      fmt::format("{{'descr': {}, 'fortran_order': {}, 'shape': {}, }}\n", descr, fortran ? "True" : "False", shape);
  return std::string("\x93NUMPY\1\0", 8) + pack(static_cast<std::uint16_t>(text.size())) + text + data;
}

inline constexpr std::string_view kLammpsDump =
    "ITEM: UNITS\nmetal\nITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS pp pp pp\n0 10\n0 10\n0 10\n"
    "ITEM: ATOMS id type x y z vx vy vz element\n1 1 1 2 3 -1 0 1 Cu\n2 1 4 5 6 -2 0 2 Cu\n"
    "ITEM: TIMESTEP\n100\nITEM: NUMBER OF ATOMS\n3\nITEM: BOX BOUNDS pp pp pp\n-1 9\n0 20\n0 10\n"
    "ITEM: ATOMS id xs ys zs\n3 0.5 0.25 1\n1 0 0 0\n2 1.5 -0.5 0.125\n";

inline constexpr std::string_view kGromacs =
    "Water in a box, t= 0.5\n    3\n"
    "    1SOL     OW    1   1.000   2.000   3.000 -1.0000  0.0000  1.0000\n"
    "    1SOL    HW1    2   4.000   5.000   6.000 -2.0000  0.0000  2.0000\n"
    "    2SOL     OW    3   7.000   8.000   9.500  0.2500  0.0000  0.0000\n   9.00000   9.00000   9.00000\n"
    "More digits, t= 1.5\n1\n    1SOL     OW    1   7.00000   8.00000   9.50000\n   9.00000   9.00000   9.00000\n";

inline constexpr std::string_view kProteinDataBank =
    "HEADER    MADE BY HAND\nCRYST1   30.000   30.000   30.000  90.00  90.00  90.00 P 1           1\nMODEL        1\n"
    "ATOM      1  N   ALA A   1       1.000   2.000   3.000  1.00 20.50           N  \n"
    "ANISOU    1  N   ALA A   1     2406   1892   1614    198    519   -328       N  \n"
    "HETATM    2 CL    CL B   2       4.000   5.000   6.000  0.50  0.00          CL  \n"
    "ATOM  *****  HG11VAL A  -3       7.000   8.000   9.500\nTER\nENDMDL\nMODEL        2\n"
    "ATOM      1  CA  ALA A   1       7.000   8.000   9.500  1.00 20.50\nENDMDL\nEND\n";

inline constexpr std::string_view kExtendedXyz =
    "2\nLattice=\"5 0 0 0 5 0 0 0 5\" Properties=species:S:1:pos:R:3:forces:R:3:tag:I:1:fixed:L:1 Time=0.5\n"
    "Si 1 2 3 -1 0 1 7 T\nSi 4 5 6 -2 0 2 8 F\n1\nProperties=species:S:1:pos:R:3\nO 7 8 9.5\n";

}  // namespace isoextract::test
