// The placement that an animation stores, of frames with several.
#include <string>

#include <gtest/gtest.h>

#include "mesh_io/animation_writer.hpp"
#include "support/sample_meshes.hpp"
#include "support/temp_folder.hpp"
#include "unit/mesh_io/played_glb.hpp"

namespace isoextract::mesh_io {
namespace {

using namespace test;

class AnimationPlacement : public testing::Test {
 protected:
  [[nodiscard]] Result<void> add(std::int64_t frame, const mesh::Mesh& mesh, const std::string& placement) {
    return writer_.add("frame", frame, {&mesh, 1}, {}, R"({"space":")" + placement + R"("})");
  }
  // Returns the asset of the file.
  [[nodiscard]] std::string asset() const { return PlayedGlb(folder_ / "a.glb").model()["asset"].dump(); }

  TempFolder folder_;
  AnimationWriter writer_{folder_ / "a.glb", {}, 24, 3, Context(), 10'000};
  mesh::Mesh small_ = make_mesh("small", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}});
};

TEST_F(AnimationPlacement, FollowsTheFirstAcceptedFrame) {
  ASSERT_FALSE(add(0, sphere(40, false), "refused")) << "it fits into 10,000 bytes";
  ASSERT_TRUE(add(1, small_, "accepted"));
  ASSERT_TRUE(add(2, small_, "accepted"));
  const auto done = writer_.finish();
  ASSERT_TRUE(done) << done.error().message;
  EXPECT_TRUE(done->notes.empty()) << done->notes.front().text;
  EXPECT_NE(asset().find("accepted"), std::string::npos) << asset();
  EXPECT_EQ(asset().find("refused"), std::string::npos) << asset();
}

TEST_F(AnimationPlacement, IsNotedIfFramesDiffer) {
  ASSERT_TRUE(add(1, small_, "first"));
  ASSERT_TRUE(add(2, small_, "second"));
  const auto done = writer_.finish();
  ASSERT_TRUE(done) << done.error().message;
  ASSERT_EQ(done->notes.size(), 1U);
  EXPECT_EQ(done->notes[0].id, NoteId::placement_differs);
  EXPECT_NE(asset().find("first"), std::string::npos) << asset();
}

TEST_F(AnimationPlacement, LeavesNoFileIfAllFramesAreRefused) {
  ASSERT_FALSE(add(0, sphere(40, false), "refused"));
  EXPECT_FALSE(writer_.has_failed());
  EXPECT_FALSE(writer_.finish());
  EXPECT_TRUE(folder_.names().empty());
}

}  // namespace
}  // namespace isoextract::mesh_io
