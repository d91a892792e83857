// Tests that the atlas holds the samples of every visible cell and no invisible brick.
#include <limits>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "render/detail/volume_nodes.hpp"
#include "unit/render/drawing.hpp"

namespace isoextract::render::detail {
namespace {

struct Listed {
  std::unique_ptr<VolumeSamples> samples;
  std::optional<VolumeBricks> bricks;
  VolumeNodes nodes;
  glm::ivec3 first;
  glm::ivec3 last;
};

Listed list(const Volume& volume, bool skipping) {
  const Context context;
  Listed listed;
  listed.samples = std::make_unique<VolumeSamples>(VolumeSamples::open(volume, context).value());
  if (skipping) listed.bricks.emplace(VolumeBricks::measure(*listed.samples, context).value());
  const field::Box box = volume_box(*volume.field).value();
  listed.first = glm::ivec3(box.min);
  listed.last = glm::ivec3(box.max) - 1;
  listed.nodes =
      VolumeNodes::list(*listed.samples, skipping ? &*listed.bricks : nullptr, listed.first, listed.last, context)
          .value();
  return listed;
}

// Finds a brick's slot as the shader does.
std::int32_t slot_of(const VolumeNodes& nodes, const glm::ivec3& brick) {
  const glm::ivec3 at = (brick >> 4) - nodes.first();
  const glm::ivec3& dims = nodes.dims();
  const std::int32_t node = nodes.nodes()[static_cast<std::size_t>(at.x + dims.x * (at.y + dims.y * at.z))];
  if (node == VolumeNodes::kInvisible) return node;
  if (node < 0) return ~node - 1;
  const glm::ivec3 b = brick & 15;
  return nodes.bricks()[static_cast<std::size_t>(node << 12 | b.x << 8 | b.y << 4 | b.z)];
}

// Checks every brick of the cells: only invisible ones may be missing, the others have the right samples. Returns the
// number of bricks present.
std::size_t expect_samples(const Listed& listed) {
  std::size_t there = 0;
  SampleReader<float> here(*listed.samples);
  SampleReader<float> stored(*listed.samples);
  const glm::ivec3 first = listed.first >> 3;
  const glm::ivec3 last = listed.last >> 3;
  for (int z = first.z; z <= last.z; ++z) {
    for (int y = first.y; y <= last.y; ++y) {
      for (int x = first.x; x <= last.x; ++x) {
        const glm::ivec3 brick(x, y, z);
        const std::int32_t slot = slot_of(listed.nodes, brick);
        const bool seen = !listed.bricks || listed.bricks->is_visible(brick);
        EXPECT_EQ(slot >= 0, seen) << x << " " << y << " " << z;
        if (slot < 0) continue;
        ++there;
        const glm::ivec3& origin = listed.nodes.slots()[static_cast<std::size_t>(slot)];
        for (int n = 0; n < 729; ++n) {
          const glm::ivec3 in_brick(n % 9, n / 9 % 9, n / 81);
          const glm::ivec3 p = 8 * brick + in_brick;
          if (glm::any(glm::greaterThan(p, listed.last + 1))) continue;
          if (here(p) != stored(origin + in_brick)) {
            ADD_FAILURE() << x << " " << y << " " << z << ": sample " << n;
            break;
          }
        }
      }
    }
  }
  return there;
}

TEST(VolumeNodes, AssignsSlotToEachVisibleDenseBrick) {
  const auto field = test::ball(140);  // more than a node along each axis
  const Volume volume{&field, field.index_to_world, test::rising_transfer(0.2, 0.3), 1};
  const Listed listed = list(volume, true);
  const std::size_t there = expect_samples(listed);
  EXPECT_EQ(listed.nodes.slots().size(), there);
  EXPECT_EQ(there, listed.bricks->count() - listed.bricks->count_invisible());
  EXPECT_LT(there, listed.bricks->count() / 2);
  EXPECT_EQ(list(volume, false).nodes.slots().size(), 18U * 18 * 18);
}

TEST(VolumeNodes, SharesSlotsOfConstantSparseBricks) {
  // A leaf, a tile of eight nodes next to it, and background.
  field::ScalarField field;
  field.source = "test field";
  const auto values = std::make_shared<std::vector<float>>();
  for (int n = 0; n < 512; ++n) values->push_back(0.5F + static_cast<float>(n) / 1024);
  field::SparseSamples samples;
  samples.background = 0.25;
  samples.blocks = {{{-8, 0, 0}, values->data()}};
  samples.tiles = {{{-40, 8, 0}, 8, 0.75}, {{0, 0, 0}, 256, 0.75}};
  samples.active_box = {{-40, 0, 0}, {255, 255, 255}};
  samples.owner = values;
  field.samples = samples;
  const auto seen = test::constant_transfer({1, 1, 1}, 0.5);
  const Listed all = list({&field, field.index_to_world, seen, 1}, true);
  const std::size_t there = expect_samples(all);
  EXPECT_GT(there, 30000U);
  // Inside the large tile and in the far background values are constant; in between two values meet.
  const std::set<std::int32_t> inside{slot_of(all.nodes, {3, 3, 3}), slot_of(all.nodes, {20, 20, 20}),
                                      slot_of(all.nodes, {20, 3, 11})};
  EXPECT_EQ(inside.size(), 1U);
  EXPECT_EQ(slot_of(all.nodes, {-4, 20, 20}), slot_of(all.nodes, {-5, 30, 3}));
  EXPECT_LT(all.nodes.slots().size(), there / 4);

  // Neither the tile's value nor the background is visible on its own.
  const std::array points{ControlPoint{0, {1, 1, 1}, 0}, ControlPoint{0.8, {1, 1, 1}, 0},
                          ControlPoint{1, {1, 1, 1}, 0.5}};
  const Listed leaf = list({&field, field.index_to_world, TransferFunction::create(points).value(), 1}, true);
  expect_samples(leaf);
  EXPECT_GE(leaf.nodes.slots().size(), 1U);
  EXPECT_LE(leaf.nodes.slots().size(), 8U);
}

TEST(VolumeNodes, FailsIfMemoryIsShort) {
  const auto field = test::ball(40);
  const Volume volume{&field, field.index_to_world, test::rising_transfer(0.2, 0.3), 1};
  const Context small(MemoryBudget(1000));
  const auto samples = VolumeSamples::open(volume, Context());
  const auto nodes = VolumeNodes::list(*samples, nullptr, glm::ivec3(0), glm::ivec3(38), small);
  ASSERT_FALSE(nodes);
  EXPECT_EQ(nodes.error().code, ErrorCode::out_of_memory);
  EXPECT_EQ(nodes.error().hint, Hint(Remedy::raise, Setting::memory_limit));
}

}  // namespace
}  // namespace isoextract::render::detail
