// Tests animations whose frames start at given times.
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "mesh_io/animation_writer.hpp"
#include "support/sample_meshes.hpp"
#include "support/temp_folder.hpp"
#include "unit/mesh_io/played_glb.hpp"

namespace isoextract::mesh_io {
namespace {

using Names = std::set<std::string>;

TEST(AnimationTimes, ShowsFramesFromGivenTimes) {
  const test::TempFolder folder;
  const auto make = [&] { return AnimationWriter(folder / "water.glb", {MeshFormat::glb}, 10, 4, Context()); };
  const std::vector<std::int64_t> frames{3, 4, 5, 8};
  const mesh::Mesh triangle = test::make_mesh("surface", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}});
  AnimationWriter writer = make();
  writer.set_span(3, 8);
  writer.set_starts(frames, std::vector{0.0, 0.05, 0.4, 0.5});
  ASSERT_TRUE(writer.check_times(frames));
  for (const std::int64_t frame : {3, 4, 8}) ASSERT_TRUE(writer.add(std::to_string(frame), frame, triangle));
  ASSERT_TRUE(writer.finish());
  const test::PlayedGlb played(folder / "water.glb");
  EXPECT_EQ(played.seen_at(0), Names{"3"});
  EXPECT_EQ(played.seen_at(0.049), Names{"3"});
  EXPECT_EQ(played.seen_at(0.05), Names{"4"});
  EXPECT_EQ(played.seen_at(0.49), Names{"4"}) << "frame 5 is missing";
  EXPECT_EQ(played.seen_at(0.5), Names{"8"});
  EXPECT_NEAR(played.duration(), 0.6, 1e-6);
  AnimationWriter dense = make();
  dense.set_starts(frames, std::vector{0.0, 1e6, 1e6 + 1e-3, 2e6});
  const auto refused = dense.check_times(frames);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find(" seconds; float32 cannot separate it from a neighbor frame"),
            std::string::npos)
      << refused.error().message;
  EXPECT_EQ(refused.error().hint,
            Hint("the input states the time of each frame: give the frames times that are farther apart"));
}

}  // namespace
}  // namespace isoextract::mesh_io
