// Tests PLY, BGEO and NPY: records, and arrays of numbers.
#include <chrono>
#include <filesystem>

#include "particle_io/formats/houdini_geometry.hpp"
#include "unit/particle_io/particle_files.hpp"

namespace isoextract::test {
namespace {

const std::vector<glm::dvec3> kThree{{1, 2, 3}, {4, 5, 6}, {7, 8, 9.5}};
const std::vector<float> kVelocities{-0.0F, 0.5F, 0.25F, -3, 0.5F, 3.25F, -6, 0.5F, 6.25F};

// Returns the kind of an attribute that the file states.
std::optional<AttributeKind> stated_kind(const points::ParticleSet& particles, const std::string& name) {
  for (const points::ParticleAttribute& attribute : particles.attributes) {
    if (attribute.name == name) return attribute.kind;
  }
  ADD_FAILURE() << "no attribute " << name;
  return std::nullopt;
}

TEST(ParticlesPly, ReadsBinaryAndText) {
  const std::string text_body = "1 2 3 200 0 0.5 0.25\n4 5 6 201 -3 0.5 3.25\n7 8 9.5 202 -6 0.5 6.25\n";
  const ParticleInput little{"a.ply", ply_header("binary_little_endian") + ply_body(std::endian::little)};
  const ParticleInput big{"a.ply", ply_header("binary_big_endian") + ply_body(std::endian::big)};
  for (const ParticleInput& input : {little, big, ParticleInput{"a.ply", ply_header("ascii") + text_body},
                                     ParticleInput{"named.otherwise", gzip(little.bytes)}}) {
    const particle_io::ParticleFile file = must_read_particles(input, with_attributes({"v", "kind", "vy"}));
    EXPECT_EQ(file.format, "ply");
    expect_positions(file.particles, kThree);
    expect_attribute(file.particles, "v", 3, kVelocities);
    expect_attribute(file.particles, "kind", 1, {200, 201, 202});
    expect_attribute(file.particles, "vy", 1, {0.5F, 0.5F, 0.5F});
    const particle_io::ParticleInfo info = must_inform(input);
    EXPECT_EQ(info.particles, 3U);
    EXPECT_EQ(quantities_of(info), (std::vector<std::string>{"kind:1 u8", "v:3 f32"}));
  }
}

TEST(ParticlesPly, SkipsOtherElementsAndLists) {
  for (const std::endian endian : {std::endian::little, std::endian::big}) {
    const std::string header = fmt::format(
        "ply\nformat binary_{}_endian 1.0\nelement cell 2\nproperty list uchar int ids\nproperty short s\n"
        "element box 2\nproperty double w\nelement vertex 2\nproperty float x\nproperty list ushort float near\n"
        "property float y\nproperty float z\nelement face 0\nproperty list uchar int vertex_index\nend_header\n",
        endian == std::endian::big ? "big" : "little");
    std::string body =
        pack(std::uint8_t{2}) + std::string(8, 'i') + "ss" + pack(std::uint8_t{0}) + "ss" + std::string(16, 'w');
    for (const float f : {1.0F, 4.0F}) {
      body += pack(f, endian) + pack(std::uint16_t{3}, endian) + std::string(12, 'n') + pack(f + 1, endian) +
              pack(f + 2, endian);
    }
    const particle_io::ParticleFile file = must_read_particles({"a.ply", header + body});
    expect_positions(file.particles, {{1, 2, 3}, {4, 5, 6}});
    ASSERT_EQ(file.notes.size(), 1U);
    expect_in(file.notes.front().text, "'near'");
  }
  const std::string text =
      "ply\nformat ascii 1.0\nelement cell 1\nproperty int a\nelement vertex 2\nproperty list uchar int near\n"
      "property float x\nproperty float y\nproperty float z\nend_header\n9\n3 7 8 9 1 2 3\n0 4 5 6\n";
  expect_positions(must_read_particles({"a.ply", text}).particles, {{1, 2, 3}, {4, 5, 6}});
}

TEST(ParticlesPly, DistinguishesMeshes) {
  const std::string mesh = ply_header("ascii", "element face 1\nproperty list uchar int vertex_index\n") + "1 2 3\n";
  const Error error = particle_refusal({"a.ply", mesh});
  expect_in(error.message, "expected particles, found a mesh: a PLY file with 1 faces");
  EXPECT_FALSE(error.hint.empty());
}

TEST(ParticlesPly, RejectsInvalidFiles) {
  const std::string body = ply_body(std::endian::little);
  const auto without = [](std::string text, const std::string& part) {
    return text.erase(text.find(part), part.size());
  };
  const std::string header = ply_header("binary_little_endian");
  const struct {
    std::string bytes;
    const char* message;
  } bad[]{
      {header + body.substr(1), "3 particles or entries need at least 87 bytes; the file has at most 86 after byte"},
      {ply_header("binary_little_endian", {}, 4294967296) + body,
       "4294967296 particles or entries need at least 124554051584"},
      {ply_header("binary_little_endian", {}, 18446744073709551615U) + body, "need at least 2^64 bytes"},
      {ply_header("binary_middle_endian") + body, "line 2: expected ascii, binary_little_endian or"},
      {without(header, "format binary_little_endian 1.0\n") + body, "expected a line 'format ...'"},
      {without(header, "property float x\n") + body, "expected columns x, y and z"},
      {without(header, "end_header\n"), "expected 'end_header'"},
      {without(header, "element vertex 3\n") + body, "expected an element before its properties"},
      {"ply\nformat ascii 1.0\nelement vertex -1\n", "line 3: expected a number of elements, found '-1'"},
      {"ply\nformat ascii 1.0\nelement vertex 1\nproperty quad x\n", "expected a type such as float"},
      {"ply\nformat ascii 1.0\nelement vertex 1\nproperty float\n", "expected a type and a name of a property"},
      {"ply\nformat ascii 1.0\nelement face 0\nend_header\n", "expected the element 'vertex'"},
      {"ply\nformat ascii 1.0\nwhat is this\n", "line 3: expected format, element, property or comment"},
      {ply_header("ascii") + "1 2 3 4 5 6 7\n1 x 3 4 5 6 7\n1 2 3 4 5 6 7\n",
       "line 14: expected a number as 'y', found 'x'"},
      {ply_header("ascii") + "1 2 3 4 5 6 7\n1 2 3 4 5 6\n1 2 3 4 5 6 7\n", "expected 7 values of a particle (not 6)"}};
  for (const auto& [bytes, message] : bad) {
    SCOPED_TRACE(message);
    expect_in(particle_refusal({"a.ply", bytes}).message, message);
  }
}

TEST(ParticlesBgeo, ReadsClassicFiles) {
  for (const ParticleInput& input :
       {ParticleInput{"a.bgeo", bgeo_classic()}, ParticleInput{"a.bgeo.gz", gzip(bgeo_classic())}}) {
    const particle_io::ParticleFile file = must_read_particles(input, with_all());
    expect_positions(file.particles, kThree);
    EXPECT_EQ(file.particles.attributes.size(), 2U);
    expect_attribute(file.particles, "id", 1, {70, 71, 72});
    expect_attribute(file.particles, "velocity", 3, kVelocities);
    ASSERT_EQ(file.notes.size(), 1U);
    expect_in(file.notes.front().text, "'tag'");
    const particle_io::ParticleInfo info = must_inform(input);
    EXPECT_EQ(info.format, "bgeo");
    EXPECT_EQ(quantities_of(info), (std::vector<std::string>{"id:1 i32", "(tag:1 text)", "velocity:3 f32"}));
    EXPECT_EQ(stated_kind(file.particles, "velocity"), AttributeKind::vector);
    EXPECT_EQ(stated_kind(file.particles, "id"), std::nullopt);
  }
}

TEST(ParticlesBgeo, RejectsInvalidClassicFiles) {
  const std::string good = bgeo_classic();
  const auto changed = [&](std::size_t at, std::int32_t value) {
    std::string bytes = good;
    put(bytes, at, value, std::endian::big);
    return bytes;
  };
  std::string odd_type = good;
  put(odd_type, 41 + 2 + 2 + 2, std::int32_t{2}, std::endian::big);
  const struct {
    std::string bytes;
    const char* message;
  } bad[]{{changed(5, 6), "expected BGEO version 5, found 6"},
          {changed(9, -3), "expected the number of points (0 or more) before byte 13, found -3"},
          {changed(9, 0x7fffffff), "2147483647 particles or entries need at least 77309411292 bytes"},
          {changed(25, 0x7fffffff), "particles or entries need at least"},
          {odd_type, "found type 2"},
          {good.substr(0, good.size() - 3),
           "3 particles or entries need at least 108 bytes; the file has at most 107 after byte"},
          {good.substr(0, 30), "found 1"},
          {"scf1" + good, "blosc compression"},
          {"hello", "not BGEO: expected 'BgeoV'"},
          {gzip(good).substr(0, 100), "the gzip data is damaged or cut off"}};
  for (const auto& [bytes, message] : bad) {
    SCOPED_TRACE(message);
    expect_in(particle_refusal({"a.bgeo", bytes}).message, message);
  }
}

TEST(ParticlesBgeo, ReadsNewFiles) {
  for (const std::string& bytes : {houdini_geometry(), houdini_geometry(std::endian::big), gzip(houdini_geometry())}) {
    const particle_io::ParticleFile file = must_read_particles({"a.bgeo", bytes}, with_all());
    expect_positions(file.particles, kThree);
    EXPECT_EQ(file.particles.attributes.size(), 3U);
    expect_attribute(file.particles, "heat", 1, {5, 5, 6});
    expect_attribute(file.particles, "v", 3, kVelocities);
    EXPECT_EQ(stated_kind(file.particles, "v"), AttributeKind::normal);  // for any name
    EXPECT_EQ(stated_kind(file.particles, "heat"), std::nullopt);
    expect_attribute(file.particles, "id", 1, {70, 71, 72});
    ASSERT_EQ(file.particles.words.size(), 1U);
    EXPECT_EQ(file.particles.words[0].name, "tag");
    EXPECT_EQ(file.particles.words[0].words, (std::vector<std::string>{"b", "a"}));
    EXPECT_EQ(file.particles.words[0].indices[2], 0U);
    ASSERT_EQ(file.notes.size(), 1U);
    expect_in(file.notes[0].text, "'odd'");
    const particle_io::ParticleInfo info = must_inform({"a.bgeo", bytes});
    EXPECT_EQ(info.particles, 3U);
    EXPECT_EQ(quantities_of(info), (std::vector<std::string>{"v:3 fpreal32", "heat:1 fpreal32", "id:1 int32",
                                                             "(tag:1 text)", "(odd:1 hologram)"}));
    expect_positions(must_read_particles({"a.bgeo", bytes}).particles, kThree);
  }
}

TEST(ParticlesBgeo, NamesTheCreatorOrTheFormat) {
  EXPECT_EQ(must_read_particles({"a.bgeo", bgeo_classic()}).creator, "Houdini's format");
  EXPECT_EQ(must_read_particles({"a.bgeo", houdini_geometry()}).creator, "Houdini's format");
  for (const auto& [software, creator] :
       {std::pair{"Houdini 18.0.499", "Houdini 18.0.499"}, std::pair{"partio", "Houdini's format"}}) {
    std::string bytes = houdini_geometry();
    const std::size_t first_entry = bytes.find("info{") + 5;
    bytes.insert(first_entry, HoudiniBytes().text("software").text(software).bytes().substr(5));
    EXPECT_EQ(must_read_particles({"a.bgeo", bytes}).creator, creator);
  }
}

TEST(ParticlesBgeo, RejectsInvalidNewFiles) {
  const std::string good = houdini_geometry();
  const auto replaced = [&](const std::string& from, const std::string& to) {
    std::string bytes = good;
    const std::size_t at = bytes.find(from);
    if (at == std::string::npos) throw std::runtime_error("no " + from);
    return bytes.replace(at, from.size(), to);
  };
  const struct {
    std::string bytes;
    const char* message;
  } bad[]{{houdini_geometry(std::endian::little, 2), "expected one flag per page"},
          {houdini_geometry(std::endian::little, 4), "expected"},
          {houdini_geometry(std::endian::little, 5), "expected more data of pages"},
          {houdini_geometry(std::endian::little, -1), "expected the number of points, a whole number from 0"},
          {replaced("pagesize\x13\2", std::string("pagesize\x13\0", 10)), "expected the size of pages before"},
          {replaced("rawpagedata@\x19\xf2\x09", "rawpagedata@\x19\xf2\x08"), "expected"},
          {replaced("rawpagedata@\x19", "rawpagedata@\x55"), "expected a type of the elements of an array"},
          {replaced("\x27\1P", "\x27\1Q"), "expected the attribute P of points, found none"},
          {good.substr(0, good.size() / 2), "expected"}};
  for (const auto& [bytes, message] : bad) {
    SCOPED_TRACE(message);
    expect_in(particle_refusal({"a.bgeo", bytes}).message, message);
  }
}

// With a repeated name, counts and attributes would apply to only a part of the file.
TEST(ParticlesBgeo, RejectsRepeatedNames) {
  const std::string good = houdini_geometry();
  const auto inserted = [&](const std::string& before, const std::string& more) {
    std::string bytes = good;
    const std::size_t at = bytes.find(before);
    if (at == std::string::npos) throw std::runtime_error("no " + before);
    return bytes.insert(at, more);
  };
  const std::string primitives = std::string("\x27\x0a", 2) + "primitives";
  const auto count = [](std::int32_t value) {
    return HoudiniBytes().text("pointcount").whole(value).bytes().substr(5);
  };
  // The first pass would allocate for the last count, while the second would write by the count before the attributes.
  expect_in(particle_refusal({"a.bgeo", inserted(primitives, count(0))}, with_all()).message,
            "expected each key of a JSON map once, found 'pointcount' again before byte");
  expect_in(particle_refusal({"a.bgeo", inserted(primitives, count(1))}, with_all()).message, "'pointcount' again");
  const std::string info = std::string("\x27\x04", 2) + "info";
  expect_in(particle_refusal({"a.bgeo", inserted(info, count(1))}, with_all()).message, "'pointcount' again");
  const std::string points = HoudiniBytes().text("attributes").begin().end().bytes().substr(5);
  expect_in(particle_refusal({"a.bgeo", inserted(primitives, points)}).message, "'attributes' again");
  const std::string paging = HoudiniBytes().text("pagesize").whole(1).bytes().substr(5);
  expect_in(particle_refusal({"a.bgeo", inserted("\x27\x07packing", paging)}).message, "'pagesize' again");
  const std::string size = HoudiniBytes().text("size").whole(1).bytes().substr(5);
  expect_in(particle_refusal({"a.bgeo", inserted("\x27\x08"
                                                 "defaults",
                                                 size)})
                .message,
            "'size' again");
}

// Returns a file with the attribute P of three points, and these names and values in its second map.
std::string position_only(const HoudiniBytes& map) {
  HoudiniBytes h;
  h.begin().text("pointcount").whole(3).text("attributes").begin().text("pointattributes").begin().begin();
  h.begin().text("type").text("numeric").text("name").text("P").end();
  h.begin().raw(map.bytes().substr(5)).end().end().end().end().end();
  return h.bytes();
}

TEST(ParticlesBgeo, RequiresValuesOfAttributes) {
  HoudiniBytes values;
  values.text("values").begin().text("arrays").numbers<float>('\x19', {1, 4, 7, 2, 5, 8, 3, 6, 9.5F}).end();
  HoudiniBytes size_last = values;
  size_last.text("size").whole(3);
  expect_positions(must_read_particles({"a.bgeo", position_only(size_last)}).particles, kThree);
  // Positions without values would be uninitialized memory.
  expect_in(particle_refusal({"a.bgeo", position_only(HoudiniBytes().text("size").whole(3))}).message,
            "expected the values of the attribute 'P'");
}

// Another program may write to the file between the two passes.
TEST(ParticlesBgeo, DetectsChangesBetweenPasses) {
  const TempFolder folder;
  const std::string path = folder / "a.bgeo";
  const std::string three = houdini_geometry();
  const auto read_after = [&](const std::string& changed) {
    write_bytes(path, three);
    const auto file = files::InputFile::open(path, Context());
    if (!file) throw std::runtime_error(file.error().message);
    const particle_io::HoudiniFile surveyed = particle_io::scan_houdini(*file);
    write_bytes(path, changed);
    std::filesystem::last_write_time(path, std::filesystem::last_write_time(path) + std::chrono::seconds(2));
    try {
      static_cast<void>(particle_io::read_houdini(*file, surveyed, with_all()));
    } catch (const particle_io::InvalidParticleFile& damaged) {
      return std::string(damaged.what());
    } catch (const particle_io::Refused& refused) {
      return refused.error.message;
    }
    return std::string("read");
  };
  expect_in(read_after(houdini_geometry(std::endian::little, 4)),
            "the number of points changed while the program read the file");
  std::string renamed = three;
  renamed.replace(renamed.find("\x27\2id"), 4, "\x27\2ID");
  expect_in(read_after(renamed), "an attribute changed while the program read the file");
  // The values do not reveal the change; the file's time does.
  expect_in(read_after(three), "a.bgeo: the file changed while the program read it");
}

// Protects against any wrong count in a file.
TEST(ParticlesColumns, RejectParticlesBeyondTheLast) {
  points::ParticleSet set;
  set.positions = Buffer<glm::dvec3>(2);
  set.attributes.push_back({"heat", 1, Buffer<float>(2)});
  particle_io::ColumnChoice choice;
  choice.position = {0, 1, 2};
  choice.attributes = {{"heat", {3}}};
  const std::vector<particle_io::ColumnSink> sinks = particle_io::sinks_of(set, choice);
  ASSERT_EQ(sinks.size(), 4U);
  for (const particle_io::ColumnSink& sink : sinks) {
    EXPECT_NO_THROW(sink.put(1, 0.5));
    EXPECT_THROW(sink.put(2, 0.5), particle_io::InvalidParticleFile);
    EXPECT_THROW(sink.put(~std::size_t{0} / 2, 0.5), particle_io::InvalidParticleFile);
  }
}

TEST(ParticlesNpy, ReadsRowsInBothOrders) {
  for (const std::endian endian : {std::endian::little, std::endian::big}) {
    std::string rows;
    std::string columns;
    for (const glm::dvec3& p : kThree)
      rows += pack(p.x, endian) + pack(p.y, endian) + pack(p.z, endian) + pack(-p.x, endian);
    for (int axis = 0; axis < 4; ++axis) {
      for (const glm::dvec3& p : kThree) columns += pack(axis == 3 ? -p.x : p[axis], endian);
    }
    const std::string descr = endian == std::endian::big ? "'>f8'" : "'<f8'";
    for (const std::string& bytes : {npy_bytes(descr, "(3, 4)", rows), npy_bytes(descr, "(3, 4)", columns, true)}) {
      const particle_io::ParticleFile file = must_read_particles({"a.npy", bytes}, with_attributes({"column 4"}));
      expect_positions(file.particles, kThree);
      expect_attribute(file.particles, "column 4", 1, {-1, -4, -7});
      ASSERT_EQ(file.notes.size(), 1U);
      expect_in(file.notes.front().text, "the first three of 4 columns");
      particle_io::ParticleReadOptions options;
      options.columns = {"4", "3", "2"};
      const particle_io::ParticleFile turned = must_read_particles({"a.npy", bytes}, options);
      expect_positions(turned.particles, {{-1, 3, 2}, {-4, 6, 5}, {-7, 9.5, 8}});
      EXPECT_TRUE(turned.notes.empty());
    }
  }
}

TEST(ParticlesNpy, ReadsAllNumberTypes) {
  const auto read = [](const std::string& descr, const std::string& data) {
    return must_read_particles({"a.npy", npy_bytes("'" + descr + "'", "(1, 3)", data)}).particles.positions[0];
  };
  const auto data = []<class T>(T) { return pack(T(1)) + pack(T(2)) + pack(static_cast<T>(100)); };
  EXPECT_EQ(read("|u1", data(std::uint8_t{})), glm::dvec3(1, 2, 100));
  EXPECT_EQ(read("|i1", pack(std::int8_t{-1}) + pack(std::int8_t{2}) + pack(std::int8_t{-100})),
            glm::dvec3(-1, 2, -100));
  EXPECT_EQ(read("<u2", data(std::uint16_t{})), glm::dvec3(1, 2, 100));
  EXPECT_EQ(read("<i4", data(std::int32_t{})), glm::dvec3(1, 2, 100));
  EXPECT_EQ(read("<u8", data(std::uint64_t{})), glm::dvec3(1, 2, 100));
  EXPECT_EQ(read("<i8", pack(std::int64_t{-1}) + pack(std::int64_t{2}) + pack(std::int64_t{1} << 40)),
            glm::dvec3(-1, 2, 1099511627776.0));
  EXPECT_EQ(read("<f2", pack(field::Half(1.5F)) + pack(field::Half(-2.0F)) + pack(field::Half(0.25F))),
            glm::dvec3(1.5, -2, 0.25));
  EXPECT_EQ(read("<f4", data(float{})), glm::dvec3(1, 2, 100));
}

TEST(ParticlesNpy, ReadsStructuredArrays) {
  std::string tuples;
  std::string singles;
  for (int i = 0; i < 3; ++i) {
    const glm::dvec3& p = kThree[static_cast<std::size_t>(i)];
    const std::size_t at = 3 * static_cast<std::size_t>(i);
    const std::string velocity = pack(kVelocities[at]) + pack(kVelocities[at + 1]) + pack(kVelocities[at + 2]);
    tuples += pack(std::int64_t{70 + i}) + "name" + pack(p.x) + pack(p.y) + pack(p.z) + velocity;
    singles += pack(p.x) + pack(p.y) + pack(p.z, std::endian::big) + velocity;
  }
  const ParticleInput first{
      "a.npy", npy_bytes("[('id', '<i8'), ('tag', '|S4'), ('pos', '<f8', (3,)), ('v', '<f4', (3,))]", "(3,)", tuples)};
  const particle_io::ParticleFile file = must_read_particles(first, with_all());
  expect_positions(file.particles, kThree);
  EXPECT_EQ(file.particles.attributes.size(), 2U);
  expect_attribute(file.particles, "id", 1, {70, 71, 72});
  expect_attribute(file.particles, "v", 3, kVelocities);
  EXPECT_EQ(quantities_of(must_inform(first)), (std::vector<std::string>{"id:1 i64", "(tag:1 |S4)", "v:3 f32"}));
  const ParticleInput second{"a.npy",
                             npy_bytes("[('x', '<f8'), ('y', '<f8'), ('z', '>f8'), ('vx', '<f4'), ('vy', '<f4'), "
                                       "('vz', '<f4')]",
                                       "(3,)", singles)};
  const particle_io::ParticleFile flat = must_read_particles(second, with_attributes({"v"}));
  expect_positions(flat.particles, kThree);
  expect_attribute(flat.particles, "v", 3, kVelocities);
}

// Bytes of texts, dates and complex numbers were read as coordinates, and types without bytes past the end.
TEST(ParticlesNpy, RejectsPositionsThatAreNotNumbers) {
  const auto of_type = [](const std::string& type, std::size_t bytes) {
    return npy_bytes(fmt::format("[('x', '{0}'), ('y', '{0}'), ('z', '{0}')]", type), "(2,)",
                     std::string(6 * bytes, 'a'));
  };
  const std::vector<std::pair<std::string, std::size_t>> others{{"|S4", 4},   {"|V8", 8},     {"<U1", 4}, {"<c8", 8},
                                                                {"<c16", 16}, {"<M8[ns]", 8}, {"<m8", 8}, {"<f16", 16}};
  for (const auto& [type, bytes] : others) {
    SCOPED_TRACE(type);
    const Error error = particle_refusal({"a.npy", of_type(type, bytes)});
    expect_in(error.message, fmt::format("expected numbers for x, y and z, found {} in the column 'x'", type));
    EXPECT_EQ(must_inform({"a.npy", of_type(type, bytes)}).particles, 2U);
    particle_io::ParticleReadOptions options;
    options.columns = {"x", "y", "z"};
    expect_in(particle_refusal({"a.npy", of_type(type, bytes)}, options).message, "expected numbers for x, y and z");
  }
  for (const std::string type : {"|V0", "|S0", "<U0", "<f0", "<f1", "<i0", "<i3", "<f5", "<c4", "<c0", "|O",
                                 "|S9999999", "<M4", "<M8ns", "<m8[", "|S4x", "|S-4", "<q8", "?"}) {
    SCOPED_TRACE(type);
    expect_in(particle_refusal({"a.npy", of_type(type, 4)}).message,
              fmt::format("expected numbers, found the type {}", type));
    const std::string beside =
        npy_bytes(fmt::format("[('pos', '<f4', (3,)), ('more', '{}', (3,))]", type), "(2,)", std::string(48, 'a'));
    expect_in(particle_refusal({"a.npy", beside}).message, fmt::format("expected numbers, found the type {}", type));
  }
}

TEST(ParticlesColumns, RejectFieldsOutsideTheirRecord) {
  points::ParticleSet set;
  set.positions = Buffer<glm::dvec3>(1);
  const std::vector<particle_io::ColumnSink> sinks = particle_io::sinks_of(set, {{0, 1, 2}, {}, {}, {}, {}});
  const std::vector<std::byte> record(12);
  particle_io::RecordLayout layout{12, {}};
  for (std::size_t i = 0; i < 3; ++i)
    layout.fields.push_back({particle_io::NumberType::f32, 4 * i, std::endian::little});
  EXPECT_NO_THROW(particle_io::deliver_records(layout, record, 0, sinks));
  layout.fields[2].offset = 9;
  EXPECT_THROW(particle_io::deliver_records(layout, record, 0, sinks), particle_io::InvalidParticleFile);
  layout.fields[2] = {std::nullopt, 8, std::endian::little};
  EXPECT_THROW(particle_io::deliver_records(layout, record, 0, sinks), particle_io::InvalidParticleFile);
}

TEST(ParticlesNpy, RejectsInvalidArrays) {
  const std::string data(72, '\0');
  const struct {
    std::string bytes;
    const char* message;
  } bad[]{{npy_bytes("'<f8'", "(3, 3)", data.substr(1)),
           "3 particles or entries need at least 72 bytes; the file has at most 71 after byte"},
          {npy_bytes("'<f8'", "(3, 3)", data + "x"), "found 1 more bytes"},
          {npy_bytes("'<f8'", "(4294967296, 3)", data), "4294967296 particles or entries need at least"},
          {npy_bytes("'<f8'", "(18446744073709551615, 3)", data), "need at least 2^64 bytes"},
          {npy_bytes("'<f8'", "(3, 2)", data), "expected a row for each particle"},
          {npy_bytes("'<f8'", "(3, 3, 1)", data), "found shape (3, 3, 1)"},
          {npy_bytes("'<f8'", "(3, 100000)", data), "expected a row for each particle"},
          {npy_bytes("'|O'", "(3, 3)", data), "expected numbers, found the type |O"},
          {npy_bytes("[('x', '|O')]", "(3,)", data), "expected numbers, found the type |O"},
          {npy_bytes("[('x', '<f8', (99999999999,))]", "(3,)", data), "expected at most 4096 components in field 'x'"},
          {npy_bytes("[('x', '<f8')]", "(9,)", data), "expected columns x, y and z"},
          {npy_bytes("[('x', [('y', '<f8')])]", "(9,)", data), "found shape (9) of a structure"},
          {gzip(npy_bytes("'<f8'", "(3, 3)", data)), "found a gzip file"}};
  for (const auto& [bytes, message] : bad) {
    SCOPED_TRACE(message);
    expect_in(particle_refusal({"a.npy", bytes}).message, message);
  }
}

}  // namespace
}  // namespace isoextract::test
