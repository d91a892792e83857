// Conversions in which one allocation fails, on any thread: one run for each allocation. Each run ends with an error
// about memory, or writes the same files in another way. It leaves no partial file, and leaks neither memory nor open
// or mapped files. Add each new stage of a conversion to one of these conversions.
#include <cstdint>
#include <exception>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <string>

#include <gtest/gtest.h>

#include "allocation/failing_allocations.hpp"
#include "convert/conversion.hpp"
#include "mesh_io/mesh_reader.hpp"
#include "support/sample_attributes.hpp"
#include "support/sample_meshes.hpp"
#include "support/temp_folder.hpp"
#include "volume_io/label_table.hpp"

namespace isoextract::convert {
namespace {

using Files = std::map<std::string, std::string>;  // by name

ConversionJob job_of(const std::string& input, double iso, mesh_io::MeshFormat format) {
  ConversionJob job;
  job.source.input = input;
  job.file = MeshFileOptions{format};
  job.outputs = {{"", {iso}}};
  return job;
}

std::string sample(const char* name) { return std::string(ISOEXTRACT_SOURCE_DIR) + "/samples/" + name; }

// Returns the number of open files and of mapped files in the test folders.
std::size_t held_files() {
  const std::filesystem::directory_iterator all("/proc/self/fd");
  auto count = static_cast<std::size_t>(std::distance(begin(all), end(all)));
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);)
    count += line.find("/isoextract-test-") != std::string::npos ? 1 : 0;
  return count;
}

class Allocation : public testing::Test {
 protected:
  using Work = std::function<Result<void>()>;

  Allocation() { message_.reserve(std::size_t{1} << 16U); }

  // Runs the work with that allocation failing. Returns false if it makes fewer allocations. Stores its result without
  // allocating memory, so that blocks can be counted.
  bool run(const Work& work, std::uint64_t number) {
    const std::int64_t before = test::live_allocations();
    bool reached = false;
    message_.clear();
    try {
      test::fail_allocation(number);
      const Result<void> done = work();
      reached = test::allocation_reached();
      done_ = done.has_value();
      if (!done_) {
        code_ = done.error().code;
        message_.assign(done.error().message);
      }
    } catch (const std::exception& thrown) {
      reached = test::allocation_reached();
      done_ = false;
      message_.assign("it was thrown, not told: ").append(thrown.what());
    }
    lost_ = test::live_allocations() - before;
    return reached;
  }

  Files take_files() {
    Files files;
    for (const std::string& name : out_.names()) {
      files[name] = test::read_bytes(out_ / name);
      std::filesystem::remove(out_ / name);
    }
    return files;
  }

  void expect_all_are_told(const Work& work) {
    run(work, 0);  // first run: creates what a process creates once
    ASSERT_TRUE(done_) << message_;
    const Files expected = take_files();
    const std::size_t held_before = held_files();
    std::uint64_t number = 1;
    std::uint64_t errors = 0;
    for (; run(work, number); ++number) {
      const testing::ScopedTrace at(__FILE__, __LINE__, "allocation " + std::to_string(number) + ": " + message_);
      EXPECT_EQ(lost_, 0) << "blocks";
      EXPECT_EQ(held_files(), held_before);
      EXPECT_EQ(context_.memory().reserved(), 0U);
      const Files files = take_files();
      if (done_) {
        EXPECT_TRUE(files == expected) << "other files, and no error";
      } else {
        ++errors;
        // A failure after a file was written completely does not remove that file.
        EXPECT_TRUE(files.empty() || files == expected) << "a part of a file, or a temporary one";
        EXPECT_EQ(code_, ErrorCode::out_of_memory);
        EXPECT_NE(message_.find("memory"), std::string::npos);
      }
      ASSERT_FALSE(HasFailure());
    }
    EXPECT_TRUE(done_) << message_;
    EXPECT_GT(errors, 10U);
  }

  void expect_all_are_told(ConversionJob job) {
    job.outputs[0].path = (out_ / "out").string();
    expect_all_are_told([this, &job]() -> Result<void> {
      Events events;
      Outcome outcome = convert::run(job, context_, events, {.mesh_facts = true});
      if (!outcome.done()) return tl::unexpected(std::move(*outcome.error));
      return {};
    });
  }

  const Context context_;
  test::TempFolder out_;
  test::TempFolder in_;
  bool done_ = false;
  ErrorCode code_ = ErrorCode::usage;
  std::string message_;
  std::int64_t lost_ = 0;
};

TEST_F(Allocation, FailsCleanlyForDenseSamples) {
  expect_all_are_told(job_of("demo:sphere?size=6", 0, mesh_io::MeshFormat::glb));
}

TEST_F(Allocation, FailsCleanlyForAttributesAndColors) {
  ConversionJob job = job_of("demo:sphere?size=4", 0, mesh_io::MeshFormat::glb);
  job.source.attributes = {{"heat", "demo:torus?size=4", true}};
  job.color = ColorChoice{"heat", edit::Colormap::turbo, {}};
  expect_all_are_told(job);
}

TEST_F(Allocation, FailsCleanlyWhileSimplifying) {
  ConversionJob job = job_of("demo:sphere?size=4", 0, mesh_io::MeshFormat::ply);
  job.edits.simplify = SimplifyChoice{SimplifyBound{0.2, false}, {}};
  expect_all_are_told(job);
}

TEST_F(Allocation, FailsCleanlyForNormalsAndCaps) {
  ConversionJob job = job_of("demo:sphere?size=5", 0, mesh_io::MeshFormat::obj);
  job.source.roi = field::Box{{-2, -2, -2}, {2, 2, 0.2}};
  job.surface.cap = true;
  expect_all_are_told(job);
}

TEST_F(Allocation, FailsCleanlyWhileResampling) {
  ConversionJob job = job_of("demo:sphere?size=4", 0, mesh_io::MeshFormat::ply);
  job.source.resolution = glm::ivec3(5, 4, 4);
  job.error = field::Interpolation::tricubic;
  expect_all_are_told(job);
}

TEST_F(Allocation, FailsCleanlyForPackedSamples) {
  ConversionJob job = job_of(sample("gyroid.nrrd"), 128, mesh_io::MeshFormat::gltf);
  job.source.read.kind = field::FieldKind::level_set;
  job.source.roi = field::Box{{2, 2, 2}, {6, 6, 6}};
  job.source.placement.space = Space::index;
  job.normals = Normals::flat;
  expect_all_are_told(job);
}

TEST_F(Allocation, FailsCleanlyForSparseSamples) {
  ConversionJob job = job_of(sample("metaballs.vdb"), 0.5, mesh_io::MeshFormat::obj);
  job.source.placement = {Space::world, UpAxis::y, false, false, 2, "", "", std::nullopt};
  expect_all_are_told(job);
}

TEST_F(Allocation, FailsCleanlyForMappedSamples) {
  std::string bytes;
  for (int i = 0; i < 5 * 6 * 7; ++i) bytes.push_back(static_cast<char>(i * 37 % 101));
  test::write_bytes(in_ / "v.raw", bytes);
  ConversionJob job = job_of(in_ / "v.raw", 50, mesh_io::MeshFormat::stl);
  job.source.read.raw = volume_io::RawLayout{{5, 6, 7}, field::SampleType::u8, std::endian::little, 0};
  job.surface = {extract::Method::mt, extract::NanPolicy::error, true};
  job.normals = Normals::none;
  job.file = MeshFileOptions{mesh_io::MeshFormat::stl, true};
  expect_all_are_told(job);
}

TEST_F(Allocation, FailsCleanlyForLabelMaps) {
  std::string bytes;
  for (int i = 0; i < 4 * 3 * 3; ++i) bytes.push_back(static_cast<char>(i * 37 % 101 % 3));
  test::write_bytes(in_ / "v.raw", bytes);
  test::write_bytes(in_ / "lut.txt", "1 one 255 0 0 0\n2 two 0 255 0 0\n");
  ConversionJob job = job_of(in_ / "v.raw", 0, mesh_io::MeshFormat::glb);
  job.outputs.front().isos = {IsoChoice::all_labels()};
  job.source.read.raw = volume_io::RawLayout{{4, 3, 3}, field::SampleType::u8, std::endian::little, 0};
  job.surface.method = extract::Method::surface_nets;
  job.normals = Normals::none;
  job.label_names = LabelTableFile{(in_ / "lut.txt").string(),
                                   volume_io::LabelTable::read((in_ / "lut.txt").string(), Context())->hash()};
  expect_all_are_told(job);
}

TEST_F(Allocation, FailsCleanlyWhileReadingMeshes) {
  mesh::Mesh mesh = test::tetrahedron("mesh", {1e3, 0, 0});
  test::add_color(mesh, mesh::ComponentType::u8, 4);
  for (const mesh_io::MeshFormatInfo& info : mesh_io::mesh_formats()) {
    const auto path = in_ / ("mesh." + std::string(info.name));
    ASSERT_TRUE(mesh_io::write_meshes({&mesh, 1}, path, {info.format, false, false}, Context()));
    expect_all_are_told([this, &path]() -> Result<void> {
      auto read = TRY(mesh_io::read_mesh(path, context_));
      return {};
    });
  }
}

}  // namespace
}  // namespace isoextract::convert
