// Tests shared behavior of the particle readers: detection, damaged files, memory.
#include <filesystem>

#include "support/hints.hpp"
#include "unit/particle_io/particle_files.hpp"

namespace isoextract::test {
namespace {

std::vector<ParticleInput> all_kinds() {
  return {{"a.ply", ply_header("binary_little_endian") + ply_body(std::endian::little)},
          {"b.ply", ply_header("ascii") + "1 2 3 200 0 0.5 0.25\n4 5 6 201 -3 0.5 3.25\n7 8 9.5 202 -6 0.5 6.25\n"},
          {"a.bgeo", bgeo_classic()},
          {"b.bgeo", houdini_geometry()},
          {"c.bgeo", gzip(bgeo_classic())},
          {"a.npy", npy_bytes("'<f4'", "(2, 3)", std::string(24, '\1'))},
          {"b.npy",
           npy_bytes("[('a', '<f4', (3,)), ('x', '<f4'), ('y', '<f4'), ('z', '<f4')]", "(2,)", std::string(48, '\1'))},
          {"a.xyz", std::string(kExtendedXyz)},
          {"a.csv", "x,y,z,\"a b\"\n1,2,3,4\n4,5,6,7\n"},
          {"a.dump", std::string(kLammpsDump)},
          {"a.gro", std::string(kGromacs)},
          {"a.pdb", std::string(kProteinDataBank)}};
}

// Largest reservation while reading: a block of the file, and the particles.
constexpr std::uint64_t kMost = (std::uint64_t{2} << 20) + 4096;

void read_damaged(const std::filesystem::path& path, const std::string& bytes) {
  std::filesystem::remove(path);  // some file systems wait for the disk when a file is overwritten
  write_bytes(path, bytes);
  const bool has_frames = path.extension() == ".xyz" || path.extension() == ".dump" || path.extension() == ".gro" ||
                          path.extension() == ".pdb";
  for (const bool frame : {false, true}) {
    if (frame && !has_frames) break;
    particle_io::ParticleReadOptions options = with_all();
    if (frame) options.frame = 1;
    const Context context = with_memory(kMost);
    {
      const auto read = particle_io::read_particles(path.string(), options, context);
      EXPECT_TRUE(read || !read.error().message.empty());
      static_cast<void>(particle_io::list_particles(path.string(), options, context));
    }
    EXPECT_LE(context.memory().peak(), kMost);
    EXPECT_EQ(context.memory().reserved(), 0U);
  }
}

TEST(ParticlesDamage, RejectsTruncationAtEveryByte) {
  for (const ParticleInput& input : all_kinds()) {
    SCOPED_TRACE(input.name);
    const TempFolder folder;
    for (std::size_t length = 1; length <= input.bytes.size(); ++length) {
      read_damaged(folder / input.name, input.bytes.substr(0, length));
    }
  }
}

TEST(ParticlesDamage, SurvivesChangesOfEveryByte) {
  for (const ParticleInput& input : all_kinds()) {
    SCOPED_TRACE(input.name);
    const TempFolder folder;
    for (std::size_t at = 0; at < input.bytes.size(); ++at) {
      for (const int change : {0x01, 0x80}) {
        std::string bytes = input.bytes;
        bytes[at] = static_cast<char>(bytes[at] ^ change);
        read_damaged(folder / input.name, bytes);
      }
    }
  }
}

TEST(ParticlesDamage, ReservesMemoryBeforeAllocating) {
  // Zeros compress well: 100000 points of 40 bytes fit into a few KiB.
  std::string bytes = bgeo_classic(100000);
  bytes.resize(bytes.size() + std::size_t{36} * 100000);
  const ParticleInput bomb{"a.bgeo", gzip(bytes)};
  ASSERT_LT(bomb.bytes.size(), 20000U);
  const Error error = particle_refusal(bomb, {}, with_memory(std::uint64_t{4} << 20));
  expect_in(error.message, "100000 particles");
  EXPECT_EQ(error.hint, Hint(Remedy::raise, Setting::memory_limit));
  const Context enough = with_memory(std::uint64_t{8} << 20);
  const auto read = try_particles(bomb, with_attributes({"velocity"}), enough);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->particles.memory.bytes(), 100000U * (24 + 12));
  EXPECT_EQ(enough.memory().reserved(), 100000U * (24 + 12));
  // A constant page of Houdini describes many points with few bytes: the memory limit must still hold.
  const Error constant = particle_refusal({"a.bgeo", houdini_geometry(std::endian::little, 0x7fffffff)});
  EXPECT_FALSE(constant.message.empty());
}

// Memory of a header must be limited, however well the file compresses.
TEST(ParticlesDamage, LimitsHeaders) {
  std::string elements = "ply\nformat ascii 1.0\n";
  for (int e = 0; e < 1000; ++e) {
    elements += "element a 0\n";
    for (int p = 0; p < 100; ++p) elements += "property char b\n";
  }
  const Error ply = particle_refusal({"a.ply.gz", gzip(elements)});
  expect_in(ply.message, "expected 'end_header' within 1048576 bytes");

  std::string bgeo = bgeo_classic();
  const std::size_t name = bgeo.find("velocity");
  bgeo.replace(name - 2, 10, pack(static_cast<std::uint16_t>(1025), std::endian::big) + std::string(1025, 'v'));
  expect_in(particle_refusal({"a.bgeo", bgeo}).message, " has 1025 bytes; expected at most 1024");
}

// Returns a file whose P has many components, each its own sub-vector with a flag for each one-element page, and no
// data.
std::string flags_of_pages(std::size_t parts, int pages) {
  HoudiniBytes h;
  h.begin().text("pointcount").whole(pages).text("attributes").begin().text("pointattributes").begin();
  h.begin().begin().text("type").text("numeric").text("name").text("P").end().begin();
  h.text("size").whole(static_cast<std::int32_t>(parts)).text("values").begin().text("packing").begin();
  for (std::size_t p = 0; p < parts; ++p) h.whole(1);
  h.end().text("pagesize").whole(1).text("constantpageflags").begin();
  const std::string flags = std::string("@\x10\xf4", 3) + pack(static_cast<std::uint32_t>(pages)) +
                            std::string(static_cast<std::size_t>(pages + 31) / 32 * 4, '\0');
  for (std::size_t p = 0; p < parts; ++p) h.raw(flags);
  h.end().end().end().end().end().end().end();  // up to the end of the file
  return h.bytes();
}

TEST(ParticlesDamage, ReservesPageFlags) {
  const std::string bytes = flags_of_pages(1000, 100000);
  // Positions need 2.4 MB, flags 12.5 MB.
  const Error error = particle_refusal({"a.bgeo", gzip(bytes)}, {}, with_memory(std::uint64_t{8} << 20));
  expect_in(error.message, "flags of pages");
  EXPECT_EQ(error.hint, Hint(Remedy::raise, Setting::memory_limit));
  // With enough memory the error is the missing data.
  expect_in(particle_refusal({"a.bgeo", gzip(bytes)}).message, "expected the values of an attribute");
}

TEST(ParticlesFormat, DetectsByContentThenByName) {
  const auto detect = [](const ParticleInput& input) {
    const TempFolder folder;
    write_bytes(folder / input.name, input.bytes);
    const auto found = particle_io::detect_particles((folder / input.name).string(), {}, Context());
    if (!found) throw std::runtime_error(found.error().message);
    return *found ? (*found)->id : "none";
  };
  EXPECT_EQ(detect({"a.vti", bgeo_classic()}), "bgeo");
  EXPECT_EQ(detect({"a.csv", houdini_geometry()}), "bgeo");
  EXPECT_EQ(detect({"a.bin", ply_header("ascii")}), "ply");
  EXPECT_EQ(detect({"a.txt", std::string(kLammpsDump)}), "lammps");
  EXPECT_EQ(detect({"a.txt", std::string(kExtendedXyz)}), "xyz");
  EXPECT_EQ(detect({"A.CSV", "1 2 3\n"}), "csv");
  EXPECT_EQ(detect({"a.csv.gz", gzip("1 2 3\n")}), "csv");
  EXPECT_EQ(detect({"a.npy", npy_bytes("'<f4'", "(2, 3)", std::string(24, '\0'))}), "npy");
  // These are volumes.
  EXPECT_EQ(detect({"a.npy", npy_bytes("'<f4'", "(2, 3, 2)", std::string(48, '\0'))}), "none");
  EXPECT_EQ(detect({"a.nrrd", "NRRD0004\n"}), "none");

  const Error unknown = particle_refusal({"a.what", "hello, this is nothing"});
  expect_in(unknown.message, "not a particle format that isoextract reads; the file starts with 'hello, this is n'");
  expect_in(test::text_of(unknown.hint), "LAMMPS");
  particle_io::ParticleReadOptions options;
  options.format = "csv";
  EXPECT_EQ(must_read_particles({"a.what", "1 2 3\n"}, options).particles.size(), 1U);
  options.format = "cvs";
  EXPECT_EQ(particle_refusal({"a.csv", "1 2 3\n"}, options).code, ErrorCode::usage);
}

TEST(ParticlesFormat, RejectsOptionsOfOtherFormats) {
  const Error frame = particle_refusal({"a.csv", "1 2 3\n"}, of_frame(0));
  EXPECT_EQ(frame.code, ErrorCode::usage);
  EXPECT_EQ(frame.hint, Hint(Remedy::leave_out, Setting::volume, "the file has one frame"));
  particle_io::ParticleReadOptions options;
  options.columns = {"1", "2", "3"};
  const Error columns = particle_refusal({"a.bgeo", bgeo_classic()}, options);
  EXPECT_EQ(columns.code, ErrorCode::usage);
  EXPECT_FALSE(columns.hint.empty());
  for (const particle_io::ParticleFormatDescription& about : particle_io::particle_format_descriptions()) {
    EXPECT_FALSE(about.id.empty() || about.title.empty() || about.extensions.empty());
  }
}

TEST(ParticlesFormat, HandlesCancellationAndEmptyFiles) {
  const Context context;
  context.cancel();
  const auto cancelled = try_particles({"a.csv", "1 2 3\n"}, {}, context);
  ASSERT_FALSE(cancelled);
  EXPECT_EQ(cancelled.error().code, ErrorCode::cancelled);
  expect_in(particle_refusal({"a.csv", ""}).message, "the file is empty");
  EXPECT_EQ(must_read_particles({"a.csv", "x,y,z\n"}).particles.size(), 0U);
  EXPECT_EQ(must_read_particles({"a.ply", ply_header("ascii", {}, 0)}, with_all()).particles.size(), 0U);
  EXPECT_EQ(must_read_particles({"a.xyz", "0\n\n"}).particles.size(), 0U);
  EXPECT_EQ(must_read_particles({"a.npy", npy_bytes("'<f4'", "(0, 3)", "")}).particles.size(), 0U);
}

}  // namespace
}  // namespace isoextract::test
