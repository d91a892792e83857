// Tests volume plug-ins: found by their tables, opened on demand, with validated results.
#include "volume_io/detail/plugin_volumes.hpp"

#include <limits>

#include "plugin_host/plugin_samples.hpp"
#include "unit/volume_io/volume_files.hpp"

namespace isoextract::test {
namespace {

const std::filesystem::path kPlugins = TEST_PLUGINS;

const volume_io::VolumeFormat& text_format(const std::string& id = "text") {
  static const auto formats = volume_io::find_plugin_formats({"/nowhere", kPlugins});
  const auto found = std::ranges::find_if(formats, [&](const auto& format) { return format->about().id == id; });
  if (found == formats.end()) throw std::runtime_error("no plug-in " + id);
  return **found;
}

Error refused(const std::string& text, const volume_io::VolumeFormat& format = text_format(),
              const Context& context = Context()) {
  const TempFolder folder;
  write_bytes(folder / "v.tvol", text);
  const auto field = format.open((folder / "v.tvol").string(), {}, context);
  if (field) throw std::runtime_error("it was read");
  return field.error();
}

TEST(PluginHost, FindsTables) {
  const volume_io::FormatDescription& about = text_format().about();
  EXPECT_EQ(about.title, "volumes as text");
  EXPECT_EQ(about.extensions, (std::vector<std::string>{".tvol", ".textvol"}));
  EXPECT_TRUE(about.has_grids);
}

TEST(PluginHost, ReadsAGridByName) {
  const TempFolder folder;
  write_bytes(folder / "v.tvol", "textvolume\nfirst 1 1 1\n7\nsecond 2 1 3\n1 2 3 4 5 6\n");
  volume_io::ReadOptions options;
  options.grid = "second";
  const Context context;
  {
    const auto field = text_format().open((folder / "v.tvol").string(), options, context);
    ASSERT_TRUE(field) << field.error().message;
    EXPECT_EQ(field->name, "second");
    EXPECT_EQ(field->format, "text");
    EXPECT_EQ(field->world_space, "lab");
    EXPECT_EQ(field->grids, 2U);
    EXPECT_EQ(field->kind, field::FieldKind::level_set);
    EXPECT_EQ(dense_value<float>(*field, 1, 0, 2), 6.0F);
    expect_near(field->index_to_world({2, 4, 6}), {11, 2, 3});
    EXPECT_EQ(context.memory().reserved(), 6 * sizeof(float));
  }
  EXPECT_EQ(context.memory().reserved(), 0U);
  const auto grids = text_format().list((folder / "v.tvol").string(), {}, context);
  ASSERT_TRUE(grids);
  ASSERT_EQ(grids->size(), 2U);
  EXPECT_EQ(grids->back().voxels, 6U);
}

TEST(PluginHost, ReportsBadFilesAsInputErrors) {
  EXPECT_EQ(refused("something else").code, ErrorCode::input);
  expect_in(refused("something else").message, "not a file of the format text; it starts with 'something else'");
  expect_in(refused("textvolume\n").message, "v.tvol: expected a grid, found none");
  expect_in(refused("textvolume\nv 0 1 1\n").message, "found 0x1x1");
}

TEST(PluginHost, ValidatesPluginResults) {
  expect_in(refused("textvolume\nshort 2 1 1\n1 2\n").message, "returns 4 bytes, expected 8");
}

TEST(PluginHost, ReservesMemoryBeforeReading) {
  EXPECT_EQ(refused("textvolume\nv 2 1 1\n1 2\n", text_format(), with_memory(7)).hint,
            Hint(Remedy::raise, Setting::memory_limit));
}

TEST(PluginHost, ReportsAFailedAllocationAsLackOfMemory) {
  const plugin_host::PluginMemory memory(Context(MemoryBudget(UINT64_MAX)), "v.tvol");
  const isoextract_plugin_host& host = memory.host();
  EXPECT_EQ(host.allocate(host.self, PTRDIFF_MAX), nullptr);
  const Error error = memory.refusal_or({ErrorCode::input, "damaged", {}});
  EXPECT_EQ(error.code, ErrorCode::out_of_memory);
  expect_in(error.message, "v.tvol: not enough memory");
}

TEST(PluginHost, DropsTilesOfTheBackground) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double background : {5.0, nan}) {
    const std::vector<isoextract_sparse_tile> tiles{{{0, 0, 0}, 8, background}, {{8, 0, 0}, 8, 7}};
    const isoextract_sparse_samples given{ISOEXTRACT_F32, nullptr,   0,          tiles.data(), tiles.size(),
                                          background,     {0, 0, 0}, {15, 7, 7}, 1024};
    const auto samples = plugin_host::sparse_samples_of(given, nullptr);
    ASSERT_TRUE(samples) << samples.error();
    ASSERT_EQ(samples->tiles.size(), 1U);
    EXPECT_EQ(samples->tiles.front().value, 7);
  }
}

TEST(PluginHost, RejectsOtherVersions) {
  const Error error = refused("textvolume\nv 1 1 1\n1\n", text_format("newer"));
  EXPECT_EQ(error.code, ErrorCode::unavailable);
  expect_in(error.message, "has version 5 of the interface, expected 4");
}

TEST(PluginHost, ListsSearchedFoldersForAMissingPlugin) {
  const TempFolder folder;
  write_bytes(folder / "isoextract-volume-absent.txt", "extensions: .abs\n");
  const auto formats = volume_io::find_plugin_formats({folder.path(), "/nowhere"});
  ASSERT_EQ(formats.size(), 1U);
  const Error error = refused("text", *formats.front());
  EXPECT_EQ(error.code, ErrorCode::unavailable);
  expect_in(error.message,
            "isoextract-volume-absent.so, which is in none of the folders " + folder.path().string() + ", /nowhere");
}

}  // namespace
}  // namespace isoextract::test
