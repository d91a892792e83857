#include "mesh_io/animation_writer.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <limits>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "mesh_io/mesh_reader.hpp"
#include "support/hints.hpp"
#include "support/sample_attributes.hpp"
#include "support/sample_meshes.hpp"
#include "unit/mesh_io/mesh_file_parsers.hpp"
#include "unit/mesh_io/played_glb.hpp"
#include "unit/mesh_io/written_mesh.hpp"

namespace isoextract::mesh_io {
namespace {

using namespace test;
using Names = std::set<std::string>;

mesh::Mesh nothing() { return make_mesh("nothing", {}, {}); }

mesh::Mesh triangle(float size = 1) {
  return make_mesh("surface", {{0, 0, 0}, {size, 0, 0}, {0, size, 0}}, {{0, 1, 2}});
}

std::string name_of(std::int64_t frame) { return fmt::format("frame {}", frame); }

class Animation : public testing::Test {
 protected:
  AnimationWriter writer(double fps = 24, std::uint64_t frames = 10, std::uint64_t largest = kLargestGlb,
                         const MeshWriteOptions& options = {}) {
    return {path_, options, fps, frames, Context(), largest};
  }

  static void must_add(AnimationWriter& writer, std::int64_t frame, const mesh::Mesh& mesh = triangle()) {
    const auto added = writer.add(name_of(frame), frame, mesh);
    ASSERT_TRUE(added) << added.error().message;
  }

  static MeshWriteResult must_finish(AnimationWriter& writer) {
    auto result = writer.finish();
    if (!result) throw std::runtime_error(result.error().message);
    return std::move(*result);
  }

  PlayedGlb play(double fps, const std::vector<std::int64_t>& frames) {
    AnimationWriter writer = this->writer(fps);
    for (const std::int64_t frame : frames) must_add(writer, frame);
    must_finish(writer);
    return PlayedGlb(path_);
  }

  TempFolder folder_;
  fs::path path_ = folder_ / "water.glb";
};

TEST_F(Animation, ShowsEachFrameOnlyDuringItsTime) {
  for (const double fps : {1.0, 24.0, 25.0, 29.97, 60.0}) {
    const PlayedGlb played = play(fps, {1, 2, 3, 4, 5, 6, 7});
    for (int i = 0; i < 7; ++i) {
      const Names expected{name_of(i + 1)};
      EXPECT_EQ(played.seen_at(i / fps), expected) << fps;
      EXPECT_EQ(played.seen_at(static_cast<float>(i / fps)), expected) << "whichever way it is rounded";
      EXPECT_EQ(played.seen_at((i + 0.5) / fps), expected);
      EXPECT_EQ(played.seen_at((i + 0.9999) / fps), expected);
    }
    EXPECT_NEAR(played.duration(), 7 / fps, 1e-6);
    EXPECT_LE(static_cast<double>(played.duration()), 7 / fps);
    EXPECT_EQ(played.seen_at(played.duration()), Names{name_of(7)}) << "also at the very end";
  }
}

TEST_F(Animation, ShowsFirstFrameAtRest) {
  EXPECT_EQ(play(24, {5, 6, 7}).seen_at_rest(), Names{name_of(5)});
  EXPECT_EQ(play(24, {5}).seen_at_rest(), Names{name_of(5)});
}

TEST_F(Animation, HasOneNodeAndChannelPerFrame) {
  const PlayedGlb played = play(24, {1, 2, 3});
  EXPECT_EQ(played.model()["nodes"].size(), 3U);
  EXPECT_EQ(played.model()["scenes"][0]["nodes"], (nlohmann::json{0, 1, 2}));
  EXPECT_EQ(played.model()["animations"][0]["channels"].size(), 3U);
  EXPECT_EQ(played.model()["animations"][0]["name"], "sequence");
  EXPECT_EQ(played.model()["materials"].size(), 1U);
  EXPECT_EQ(played.model()["meshes"].size(), 3U);
  EXPECT_EQ(played.model()["scene"], 0);
  EXPECT_EQ(played.model()["asset"]["version"], "2.0");
  EXPECT_EQ(played.model()["buffers"][0]["byteLength"], played.binary().size());
}

TEST_F(Animation, ShowsPreviousFrameDuringGaps) {
  const PlayedGlb played = play(10, {-3, -2, 2, 4});
  const auto at = [&](double frame) { return played.seen_at((frame + 3) / 10); };
  EXPECT_EQ(at(-3), Names{name_of(-3)});
  EXPECT_EQ(at(-2), Names{name_of(-2)});
  EXPECT_EQ(at(1.9), Names{name_of(-2)});
  EXPECT_EQ(at(2), Names{name_of(2)});
  EXPECT_EQ(at(3.9), Names{name_of(2)});
  EXPECT_EQ(at(4), Names{name_of(4)});
  EXPECT_NEAR(played.duration(), 0.8, 1e-6);
}

TEST_F(Animation, ShowsNothingForEmptyFrame) {
  AnimationWriter writer = this->writer(1);
  for (const std::int64_t frame : {0, 1, 4, 7, 8}) must_add(writer, frame, frame % 4 == 0 ? nothing() : triangle());
  ASSERT_TRUE(writer.add("no surface", 9, std::span<const mesh::Mesh>()));
  must_finish(writer);
  const PlayedGlb played(path_);
  const std::vector<Names> expected{{}, {name_of(1)}, {name_of(1)}, {name_of(1)}, {}, {}, {}, {name_of(7)}, {}, {}};
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(played.seen_at(static_cast<double>(i)), expected[i]) << i;
  }
  EXPECT_EQ(played.duration(), 10);
  EXPECT_EQ(played.seen_at_rest(), Names{name_of(1)});
  EXPECT_EQ(played.model()["nodes"].size(), 2U);
}

TEST_F(Animation, WritesNoDataIfAllFramesAreEmpty) {
  AnimationWriter writer = this->writer();
  must_add(writer, 1, nothing());
  must_add(writer, 2, nothing());
  const auto result = must_finish(writer);
  const PlayedGlb played(path_);
  EXPECT_FALSE(played.model().contains("animations") || played.model().contains("buffers"));
  EXPECT_TRUE(played.model()["scenes"][0].is_object());
  EXPECT_EQ(played.model()["asset"]["version"], "2.0");
  EXPECT_EQ(result.files[0].bytes, fs::file_size(path_));
}

TEST_F(Animation, WritesFramesLikeSingleFiles) {
  mesh::Mesh colored = sphere(12, true, "colored", {1000.0 + 1.0 / 3, -7, 0});
  add_color(colored, mesh::ComponentType::u8, 3);
  add_attribute(colored, "label", mesh::ComponentType::u8, 1);
  for (const bool flat : {false, true}) {
    if (flat) colored.normals = {};
    const MeshWriteOptions options{MeshFormat::glb, flat, false};
    must_write(std::span(&colored, 1), folder_ / "single.glb", options);
    AnimationWriter writer = this->writer(24, 3, kLargestGlb, options);
    must_add(writer, 1, tetrahedron());
    must_add(writer, 2, colored);
    must_add(writer, 3, triangle());
    const auto result = must_finish(writer);
    const auto single = load_gltf((folder_ / "single.glb").string());
    const auto found = load_gltf(path_.string());
    ASSERT_EQ(found.size(), 3U);
    EXPECT_EQ(found[1].name, name_of(2));
    EXPECT_EQ(found[1].origin, single[0].origin);
    EXPECT_EQ(found[1].positions, single[0].positions);
    EXPECT_EQ(found[1].normals, single[0].normals);
    EXPECT_EQ(found[1].triangles, single[0].triangles);
    const PlayedGlb played(path_);
    EXPECT_EQ(played.model()["materials"].size(), 2U) << "with and without colors";
    EXPECT_TRUE(played.model()["meshes"][1]["primitives"][0]["attributes"].contains("COLOR_0"));
    EXPECT_TRUE(played.model()["meshes"][1]["primitives"][0]["attributes"].contains("_label"));
    EXPECT_EQ(played.model()["meshes"][1]["name"], "colored");
    EXPECT_EQ(result.notes.size(), flat ? 1U : 0U) << "once, not for each frame";
  }
}

TEST_F(Animation, ShowsAllSurfacesOfFrameTogether) {
  AnimationWriter writer = this->writer(1);
  must_add(writer, 0);
  std::vector<mesh::Mesh> surfaces;
  surfaces.push_back(sphere(4, false, "iso 1", {5, 0, 0}));
  surfaces.push_back(nothing());
  surfaces.push_back(tetrahedron("iso 2"));
  ASSERT_TRUE(writer.add(name_of(1), 1, surfaces));
  must_finish(writer);
  const PlayedGlb played(path_);
  EXPECT_EQ(played.seen_at(1.5), Names{name_of(1)});
  const auto& nodes = played.model()["nodes"];
  ASSERT_EQ(nodes.size(), 4U);
  const auto& frame = nodes[played.model()["scenes"][0]["nodes"][1].get<std::size_t>()];
  EXPECT_FALSE(frame.contains("mesh"));
  ASSERT_EQ(frame["children"].size(), 2U);
  const auto& child = nodes[frame["children"][0].get<std::size_t>()];
  EXPECT_EQ(child["name"], "iso 1");
  EXPECT_EQ(child["translation"], (nlohmann::json{5.0, 0.0, 0.0}));
  EXPECT_FALSE(child.contains("scale"));
}

TEST_F(Animation, KeepsDistinctKeysOnLongTimeLines) {
  for (const double fps : {23.976, 24.0, 30.0, 60.0, 120.0}) {
    AnimationWriter writer = this->writer(fps);
    std::vector<std::int64_t> frames{0};
    for (std::int64_t frame = 99'900; frame < 100'000; ++frame) frames.push_back(frame);
    for (const std::int64_t frame : frames) must_add(writer, frame);
    must_finish(writer);
    const PlayedGlb played(path_);
    for (const std::int64_t frame : frames) {
      const double time = static_cast<double>(frame) / fps;
      ASSERT_EQ(played.seen_at(time), Names{name_of(frame)});
      ASSERT_EQ(played.seen_at(time + 0.9 / fps).size(), 1U);
    }
  }
}

TEST_F(Animation, RefusesFrameWhoseTimeFloatCannotDistinguish) {
  AnimationWriter writer = this->writer(24);
  must_add(writer, 0);
  const auto refused = writer.add("far", std::int64_t{1} << 40, triangle());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::output);
  EXPECT_NE(refused.error().message.find("float32"), std::string::npos);
  must_add(writer, 1);
  EXPECT_FALSE(writer.add("farther", std::numeric_limits<std::int64_t>::max(), triangle()));
  must_finish(writer);
  EXPECT_EQ(PlayedGlb(path_).seen_at(1.0 / 24), Names{name_of(1)});
}

TEST_F(Animation, RefusesFrameNumbersThatDoNotGrow) {
  AnimationWriter writer = this->writer();
  must_add(writer, 2);
  for (const std::int64_t frame : {2, 1}) {
    const auto refused = writer.add("again", frame, triangle());
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::usage);
  }
  must_add(writer, 3);
  must_finish(writer);
  EXPECT_EQ(PlayedGlb(path_).model()["nodes"].size(), 2U);
}

// The writer computes sizes in advance: for any limit, no file exceeds it and each frame is in one file.
TEST_F(Animation, SplitsBeforeFileIsTooLarge) {
  constexpr int kFrames = 24;
  std::size_t max_parts = 0;
  for (std::uint64_t largest = 6'000; largest < 60'000; largest += largest / 7 / 4 * 4 + 4) {
    for (const std::uint64_t announced : {1, kFrames, 100'000}) {
      const TempFolder folder;
      path_ = folder / "water.glb";
      AnimationWriter writer = this->writer(24, announced, largest);
      for (int i = 0; i < kFrames; ++i) must_add(writer, 100 + i, sphere(3, false));
      const auto result = must_finish(writer);
      max_parts = std::max(max_parts, result.files.size());
      std::vector<PlayedGlb> parts;
      Names names;
      for (std::size_t p = 0; p < result.files.size(); ++p) {
        const fs::path path = folder / (p == 0 ? "water.glb" : fmt::format("water.part{}.glb", p + 1));
        names.insert(path.filename().string());
        EXPECT_EQ(result.files[p].path, path.string());
        EXPECT_EQ(path_of_animation_part(path_, p + 1), path);
        EXPECT_EQ(result.files[p].bytes, fs::file_size(path));
        ASSERT_LE(fs::file_size(path), largest);
        parts.emplace_back(path);
        EXPECT_FALSE(parts.back().seen_at_rest().empty());
        EXPECT_NEAR(parts.back().duration(), kFrames / 24.0, 1e-6) << "so that they play side by side";
      }
      EXPECT_EQ(folder.names(), names);
      for (int i = 0; i < kFrames; ++i) {
        for (const double within : {0.0, 0.5}) {
          Names seen;
          for (const PlayedGlb& part : parts) seen.merge(part.seen_at((i + within) / 24));
          EXPECT_EQ(seen, Names{name_of(100 + i)});
        }
      }
      EXPECT_EQ(result.notes.size(), parts.size() > 1 ? 1U : 0U);
      if (parts.size() > 1) {
        EXPECT_NE(result.notes[0].text.find("frames 100 to "), std::string::npos) << result.notes[0].text;
        EXPECT_NE(result.notes[0].text.find("in water.part2.glb"), std::string::npos) << result.notes[0].text;
      }
    }
  }
  EXPECT_GT(max_parts, 4U);
}

TEST_F(Animation, RefusesFrameLargerThanFile) {
  AnimationWriter writer = this->writer(24, 3, 10'000);
  const auto first = writer.add("large", 0, sphere(40, false));
  ASSERT_FALSE(first);
  EXPECT_NE(first.error().message.find("frame 0 does not fit"), std::string::npos) << first.error().message;
  must_add(writer, 1);
  EXPECT_FALSE(writer.add("large", 2, sphere(40, false)));
  must_add(writer, 3);
  must_finish(writer);
  EXPECT_EQ(folder_.names(), Names{"water.glb"});
  const PlayedGlb played(path_);
  EXPECT_EQ(played.seen_at(0), Names{name_of(1)}) << "the time line begins with the first frame that is there";
  EXPECT_EQ(played.seen_at(1.5 / 24), Names{name_of(1)});
  EXPECT_EQ(played.seen_at(2.5 / 24), Names{name_of(3)});
}

TEST_F(Animation, RefusesFrameTooFarFromOrigin) {
  AnimationWriter writer = this->writer();
  must_add(writer, 1);
  const auto refused = writer.add("far", 2, sphere(30, false, "far", {1e17, 0, 0}));
  ASSERT_FALSE(refused);
  EXPECT_TRUE(test::has_step(refused.error().hint, Remedy::use, Setting::position));
  must_add(writer, 3);
  must_finish(writer);
}

// The space that is reserved for the JSON is an estimate.
TEST_F(Animation, MovesDataIfReservedSpaceIsTooSmall) {
  AnimationWriter writer = this->writer(24, 1);
  must_add(writer, 0);
  const std::string name(3000, '"');  // twice as long in JSON
  for (int i = 1; i < 100; ++i) ASSERT_TRUE(writer.add(name + name_of(i), i, triangle(static_cast<float>(i))));
  must_finish(writer);
  const auto found = load_gltf(path_.string());
  ASSERT_EQ(found.size(), 100U);
  EXPECT_EQ(found[57].name, name + name_of(57));
  EXPECT_TRUE(same_local_positions(triangle(57), found[57]));
  EXPECT_EQ(PlayedGlb(path_).seen_at(50.5 / 24), Names{name + name_of(50)});
}

TEST_F(Animation, RemovesUnusedReservedSpace) {
  AnimationWriter writer = this->writer(24, 50'000);
  must_add(writer, 0);
  must_add(writer, 1, triangle(7));
  must_finish(writer);
  EXPECT_LT(fs::file_size(path_), 10'000U);
  EXPECT_TRUE(same_local_positions(triangle(7), load_gltf(path_.string()).at(1)));
}

double seconds_of_processor() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

TEST_F(Animation, WritesTenThousandFramesInLinearTime) {
  std::vector<double> seconds;
  for (const int frames : {2'500, 10'000}) {
    AnimationWriter writer = this->writer(24, static_cast<std::uint64_t>(frames));
    const double start = seconds_of_processor();
    for (int i = 0; i < frames; ++i) ASSERT_TRUE(writer.add(name_of(i), i, triangle()));
    must_finish(writer);
    seconds.push_back(seconds_of_processor() - start);
    const std::string bytes = read_bytes(path_);
    EXPECT_LT(bytes.size(), static_cast<std::size_t>(frames) * 2'500);
    EXPECT_EQ(take_apart(bytes).model["nodes"].size(), static_cast<std::size_t>(frames));
  }
  EXPECT_LT(seconds[1], 4 * 2.5 * seconds[0]) << "four times as much work";
}

TEST_F(Animation, RefusesStreamsBeforeWriting) {
  ASSERT_EQ(::mkfifo((folder_ / "pipe").c_str(), 0600), 0);  // has no reader: opening it would block
  for (const fs::path& path : {fs::path("-"), fs::path("/dev/null"), folder_ / "pipe"}) {
    AnimationWriter writer(path, {}, 24, 1, Context());
    for (const auto& result : {writer.check(), writer.add("a", 1, triangle())}) {
      ASSERT_FALSE(result) << path;
      EXPECT_EQ(result.error().code, ErrorCode::usage);
      EXPECT_NE(result.error().message.find("stream"), std::string::npos);
    }
    EXPECT_FALSE(writer.finish());
  }
  EXPECT_EQ(folder_.names(), Names{"pipe"});
}

TEST_F(Animation, RefusesInvalidOptions) {
  for (const double fps : {0.0, -24.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    const auto possible = writer(fps).check();
    ASSERT_FALSE(possible);
    EXPECT_EQ(possible.error().code, ErrorCode::usage);
  }
  for (const MeshFormat format : {MeshFormat::gltf, MeshFormat::ply}) {
    const auto possible = writer(24, 1, kLargestGlb, {format, false, false}).check();
    ASSERT_FALSE(possible);
    EXPECT_TRUE(test::has_step(possible.error().hint, Remedy::set, Setting::mesh_format));
  }
  EXPECT_FALSE(writer(24, 1, kLargestGlb, {MeshFormat::glb, false, true}).check());
  EXPECT_TRUE(writer().check());
  EXPECT_FALSE(writer(1e-300).add("at no time", 0, triangle()));
  AnimationWriter none = writer();
  const auto finished = none.finish();
  ASSERT_FALSE(finished);
  EXPECT_EQ(finished.error().code, ErrorCode::output);
  EXPECT_TRUE(folder_.names().empty());
}

TEST_F(Animation, LeavesNoFileWithoutFinish) {
  write_bytes(path_, "old");
  {
    AnimationWriter writer = this->writer(24, 20, 8'000);
    for (int i = 0; i < 20; ++i) must_add(writer, i, sphere(3, false));
    EXPECT_EQ(folder_.names(), Names{"water.glb"});
  }
  EXPECT_EQ(folder_.names(), Names{"water.glb"});
  EXPECT_EQ(read_bytes(path_), "old");
}

TEST_F(Animation, CommitsAllPartsOrNone) {
  write_bytes(path_, "old");
  AnimationWriter writer = this->writer(24, 20, 8'000);
  for (int i = 0; i < 20; ++i) must_add(writer, i, sphere(3, false));
  fs::create_directories(folder_ / "water.part2.glb" / "in the way");
  EXPECT_FALSE(writer.finish());
  EXPECT_FALSE(writer.finish()) << "a failure stays";
  EXPECT_EQ(folder_.names(), (Names{"water.glb", "water.part2.glb"}));
  EXPECT_EQ(read_bytes(path_), "old");
}

TEST_F(Animation, NotesLeftoverPartOfEarlierRun) {
  write_bytes(folder_ / "water.part2.glb", "old");
  AnimationWriter writer = this->writer();
  must_add(writer, 1);
  const auto result = must_finish(writer);
  ASSERT_EQ(result.notes.size(), 1U);
  EXPECT_NE(result.notes[0].text.find("water.part2.glb existed before"), std::string::npos);
  EXPECT_EQ(read_bytes(folder_ / "water.part2.glb"), "old");
}

TEST_F(Animation, NamesPartsWithoutExtension) {
  EXPECT_EQ(path_of_animation_part("a.b/water", 2), "a.b/water.part2");
  EXPECT_EQ(path_of_animation_part("water.v1.glb", 12), "water.v1.part12.glb");
}

TEST_F(Animation, StopsWhenCancelled) {
  const Context context;
  AnimationWriter writer(path_, {}, 24, 10, context);
  must_add(writer, 1);
  context.cancel();
  const auto added = writer.add("later", 2, triangle());
  ASSERT_FALSE(added);
  EXPECT_EQ(added.error().code, ErrorCode::cancelled);
  EXPECT_FALSE(writer.finish());
  EXPECT_TRUE(folder_.names().empty());
}

TEST_F(Animation, WritesPackedFramesLikePackedFiles) {
  MeshPacking draco;
  draco.compression = Compression::draco;
  MeshPacking meshopt;
  meshopt.compression = Compression::meshopt;
  meshopt.quantize = meshopt.optimize_order = true;
  const mesh::Mesh ball = sphere(16, true);
  for (MeshPacking packing : {draco, meshopt}) {
    packing.box = mesh::Bounds{glm::dvec3(-2), glm::dvec3(2)};
    const auto alone =
        must_write(std::span(&ball, 1), folder_ / "single.glb", {MeshFormat::glb, false, false, packing});
    AnimationWriter writer = this->writer();
    const mesh::Mesh other = sphere(8, true);
    const mesh::Mesh flat = triangle();
    ASSERT_TRUE(writer.add(name_of(1), 1, std::span(&ball, 1), packing));
    ASSERT_EQ(writer.packed().size(), 1U);
    EXPECT_EQ(writer.packed()[0].positions->step, alone.packed[0].positions->step);
    EXPECT_EQ(writer.packed()[0].bytes_after, alone.packed[0].bytes_after);
    ASSERT_TRUE(writer.add(name_of(2), 2, std::span(&other, 1), packing));
    ASSERT_TRUE(writer.add(name_of(3), 3, flat));
    EXPECT_TRUE(writer.packed().empty());
    ASSERT_TRUE(writer.add(name_of(4), 4, std::span(&ball, 1), packing));
    must_finish(writer);
    const PlayedGlb played(path_);
    for (int frame = 1; frame <= 4; ++frame) EXPECT_EQ(played.seen_at((frame - 0.5) / 24), Names{name_of(frame)});
    const auto single = read_mesh(folder_ / "single.glb", Context());
    const auto first = read_mesh(path_, Context());
    ASSERT_TRUE(single && first) << first.error().message;
    EXPECT_TRUE(std::ranges::equal(first->mesh.positions.span(), single->mesh.positions.span()));
    EXPECT_TRUE(std::ranges::equal(first->mesh.triangles.span(), single->mesh.triangles.span()));
    EXPECT_EQ(first->mesh.origin, single->mesh.origin);
    const auto& model = played.model();
    EXPECT_EQ(model["extensionsRequired"].size(), packing.quantize ? 2U : 1U) << model["extensionsRequired"];
    ASSERT_EQ(model["buffers"].size(), packing.quantize ? 2U : 1U);
    // The packed mesh's own scale is on another node than the animated scale.
    EXPECT_EQ(model["nodes"].size(), packing.quantize ? 7U : 4U);
  }
}

TEST_F(Animation, RequiresBoxAroundQuantizedPositions) {
  AnimationWriter writer = this->writer();
  MeshPacking packing;
  packing.quantize = true;
  const mesh::Mesh ball = sphere(8, true);
  const auto boxless = writer.add(name_of(1), 1, std::span(&ball, 1), packing);
  ASSERT_FALSE(boxless);
  EXPECT_EQ(boxless.error().code, ErrorCode::usage);
  packing.box = mesh::Bounds{glm::dvec3(5), glm::dvec3(7)};
  const auto outside = writer.add(name_of(1), 1, std::span(&ball, 1), packing);
  ASSERT_FALSE(outside);
  EXPECT_EQ(outside.error().code, ErrorCode::output);
  EXPECT_NE(outside.error().message.find("water.glb: expected vertices in the quantization box"), std::string::npos)
      << outside.error().message;
  must_add(writer, 2);
  must_finish(writer);
  EXPECT_EQ(PlayedGlb(path_).seen_at(0), Names{name_of(2)}) << "as if the others had not come";
}

TEST_F(Animation, ReadsBackFirstFrame) {
  AnimationWriter writer = this->writer();
  const glm::dvec3 origin(1e5 + 1.0 / 3, 0, 0);
  must_add(writer, 1, nothing());
  must_add(writer, 2, sphere(10, false, "first", origin));
  must_add(writer, 3, sphere(20, false, "second"));
  must_add(writer, 4, sphere(20, false, "third"));
  must_finish(writer);
  const auto read = read_mesh(path_, Context());
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->mesh.origin, origin);
  EXPECT_EQ(read->mesh.positions.size(), sphere(10, false).positions.size());
  EXPECT_EQ(read->mesh.triangles.size(), sphere(10, false).triangles.size());
  ASSERT_EQ(read->notes.size(), 1U);
  EXPECT_NE(read->notes[0].text.find("the reader skips 2 surfaces"), std::string::npos) << read->notes[0].text;
}

}  // namespace
}  // namespace isoextract::mesh_io
