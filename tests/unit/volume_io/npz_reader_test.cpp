// Tests NumPy's archives: the choice of an array, and ZIP files with wrong entries.
#include "support/hints.hpp"
#include "unit/volume_io/npz_files.hpp"

namespace isoextract::test {
namespace {

const std::string kRamp = npy_array("<f4", "(5, 4, 3)", ramp_bytes<float>());

volume_io::ReadOptions grid(const std::string& name) {
  volume_io::ReadOptions options;
  options.grid = name;
  return options;
}

void write_zip(const std::filesystem::path& path, const std::vector<ZipPart>& parts) {
  write_bytes(path, zip_bytes(parts));
}

TEST(NpzReader, ReadsStoredAndCompressedMembers) {
  for (const bool packed : {false, true}) {
    for (const bool zip64 : {false, true}) {
      const TempFolder folder;
      ZipPart part = zip_part("rho.npy", kRamp, packed);
      part.zip64 = zip64;
      write_bytes(folder / "v.npz", zip_bytes({part}, "a comment with PK\5\6 in it"));
      const field::ScalarField field = must_read(folder / "v.npz");
      expect_ramp<float>(field);
      EXPECT_EQ(field.name, "rho");
      EXPECT_EQ(field.format, "NPZ");
      EXPECT_EQ(field.grids, 1U);
      EXPECT_EQ(field.grid, "rho");
    }
  }
}

TEST(NpzReader, DistinguishesOtherZipFiles) {
  const TempFolder folder;
  write_zip(folder / "v.bin", {zip_part("rho.npy", kRamp, true)});
  expect_ramp<float>(must_read(folder / "v.bin"));
  write_zip(folder / "w.bin", {zip_part("document.xml", "text", false)});
  expect_in(refusal(folder / "w.bin").message, "not a volume format");
}

TEST(NpzReader, SelectsAnArrayByName) {
  const TempFolder folder;
  std::string doubled;
  for (int k = 0; k < 60; ++k) doubled += pack(2.0 * k);
  write_zip(folder / "v.npz", {zip_part("a.npy", kRamp, true), zip_part("note.txt", "no array", false),
                               zip_part("b/c.npy", npy_array("<f8", "(5, 4, 3)", doubled), false),
                               zip_part("flat.npy", npy_array("<f8", "(60,)", doubled), true),
                               zip_part("text.npy", npy_array("<U4", "(2, 2, 2)", std::string(128, '\0')), true)});
  const auto grids = volume_io::list_grids((folder / "v.npz").string(), {}, Context());
  ASSERT_TRUE(grids) << grids.error().message;
  ASSERT_EQ(grids->size(), 4U);
  EXPECT_EQ((*grids)[0].label, "a");
  EXPECT_EQ((*grids)[1].label, "b/c");
  EXPECT_EQ((*grids)[1].voxels, 60U);
  EXPECT_TRUE((*grids)[1].scalar);
  EXPECT_FALSE((*grids)[2].scalar);
  EXPECT_EQ((*grids)[2].type, "<f8 (60)");
  EXPECT_FALSE((*grids)[3].scalar);

  expect_ramp<float>(must_read(folder / "v.npz", grid("a")));
  EXPECT_EQ(dense_value<double>(must_read(folder / "v.npz", grid("b/c")), 2, 3, 4), 118);
  EXPECT_TRUE(test::has_step(refusal(folder / "v.npz").hint, Remedy::choose, Setting::grid));
  EXPECT_TRUE(test::has_step(refusal(folder / "v.npz", grid("note")).hint, Remedy::choose, Setting::grid));
  expect_in(refusal(folder / "v.npz", grid("flat")).message, "'flat.npy': expected an array with 3 axes");
  expect_in(refusal(folder / "v.npz", grid("text")).message, "found <U4");
}

TEST(NpzReader, ReadsVolumesComponentsAndAxisOrders) {
  std::string two;
  for (int t = 0; t < 2; ++t) {
    for (int i = 0; i < 60; ++i) two += pack(static_cast<std::int16_t>(1000 * t + i), std::endian::big);
  }
  // The same 120 numbers as 3 x 4 x 5 vectors of 2, and in Fortran order.
  for (const bool packed : {false, true}) {
    const TempFolder folder;
    write_zip(folder / "v.npz", {zip_part("t.npy", npy_array(">i2", "(2, 5, 4, 3)", two), packed),
                                 zip_part("v.npy", npy_array(">i2", "(5, 4, 3, 2)", two), packed),
                                 zip_part("f.npy", npy_array(">i2", "(5, 4, 3, 2)", two, true), packed)});
    volume_io::ReadOptions options = grid("t");
    options.volume = 1;
    EXPECT_EQ(dense_value<std::int16_t>(must_read(folder / "v.npz", options), 2, 3, 4), 1059);
    EXPECT_EQ(volume_io::count_volumes((folder / "v.npz").string(), options, Context()).value(), 2U);
    options = grid("v");
    options.component = volume_io::ComponentChoice{1};
    const field::ScalarField vectors = must_read(folder / "v.npz", options);
    EXPECT_EQ(dense_value<std::int16_t>(vectors, 0, 0, 0), 1);
    EXPECT_EQ(dense_value<std::int16_t>(vectors, 2, 3, 4), 1059);
    options.grid = "f";
    // z is the fastest there, then y, x and the component.
    const field::ScalarField turned = must_read(folder / "v.npz", options);
    EXPECT_EQ(dense_value<std::int16_t>(turned, 0, 0, 1), 1001);
    EXPECT_EQ(dense_value<std::int16_t>(turned, 0, 1, 0), 1005);
    EXPECT_EQ(dense_value<std::int16_t>(turned, 1, 0, 0), 1020);
  }
}

TEST(NpzReaderMemory, ReservesTheDecompressedSize) {
  const TempFolder folder;
  // 8 MB of zeros in a few KB.
  const std::string zeros(std::size_t{8} << 20, '\0');
  write_zip(folder / "v.npz", {zip_part("a.npy", npy_array("|u1", "(128, 256, 256)", zeros), true)});
  EXPECT_LT(std::filesystem::file_size(folder / "v.npz"), 20000U);
  expect_in(refusal(folder / "v.npz", {}, with_memory(std::uint64_t{7} << 20)).message, "256x256x128 u8 samples");
  const Context enough = with_memory(std::uint64_t{9} << 20);
  {
    const field::ScalarField field = must_read(folder / "v.npz", {}, enough);
    EXPECT_EQ(enough.memory().reserved(), zeros.size());
  }
  EXPECT_EQ(enough.memory().reserved(), 0U);
}

// Directory entries that contradict the file.
TEST(NpzReaderBad, RejectsWrongSizesAndPositions) {
  const auto with = [](bool packed, const auto& change) {
    ZipPart part = zip_part("a.npy", kRamp, packed);
    change(part);
    return zip_bytes({part});
  };
  const std::string good = zip_bytes({zip_part("a.npy", kRamp, true)});
  const std::string huge = npy_array("|u1", "(1024, 1024, 1024)", std::string(100000, '\0'));
  ZipPart bomb = zip_part("a.npy", huge, true);
  bomb.inflated = 0xfffffff0;
  std::string moved = good;
  put(moved, moved.size() - 6, static_cast<std::uint32_t>(moved.size()));
  std::string long_directory = good;
  put(long_directory, long_directory.size() - 10, std::uint32_t{0x7fffffff});
  std::string no_extra = zip_bytes({zip_part("a.npy", kRamp, true)});
  put(no_extra, no_extra.find(std::string("PK\1\2", 4)) + 24, std::uint32_t{0xffffffff});
  expect_all_refused(
      "v.npz",
      {{"empty file", "", "empty"},
       {"text", "this is some text that is long enough\n", "there is no directory at its end"},
       {"short", "PK\5\6", "it has 4 bytes"},
       {"no arrays", zip_bytes({zip_part("a.txt", "text", false)}), "there is no grid in the file"},
       {"nothing", zip_bytes({}), "there is no grid in the file"},
       {"no directory", good.substr(0, good.size() - 1), "there is no directory at its end"},
       {"directory elsewhere", moved, "its directory has"},
       {"long directory", long_directory, "its directory has"},
       {"64 bits missing", no_extra, "lacks its sizes of 64 bits"},
       {"encrypted", with(true, [](ZipPart& part) { part.flags = 1; }), "is encrypted"},
       {"bzip2", with(true, [](ZipPart& part) { part.method = 12; }), "has compression method 12"},
       {"header elsewhere", with(true, [](ZipPart& part) { part.header_moved_by = 7; }),
        "its directory gives a wrong position for '"},
       {"header outside", with(true, [](ZipPart& part) { part.header_moved_by = 1 << 30; }),
        "begins after the end of the file"},
       {"more bytes than there are", with(true, [](ZipPart& part) { part.packed = 1 << 30; }),
        "has 1073741824 bytes from byte"},
       {"stored in fewer", with(false, [](ZipPart& part) { part.packed -= 1; }), "has method 0 (stored), but"},
       {"stored, cut off",
        with(false,
             [](ZipPart& part) {
               part.packed -= 1;
               part.inflated -= 1;
             }),
        "found 239"},
       {"longer than it says", with(true, [](ZipPart& part) { part.inflated -= 1; }), "found 239"},
       {"shorter than it says", with(true, [](ZipPart& part) { part.inflated += 1; }), "the ZIP directory states 369"},
       {"packed bytes missing", with(true, [](ZipPart& part) { part.packed -= 1; }), "its compressed bytes end"},
       {"packed bytes too many",
        with(true,
             [](ZipPart& part) {
               part.packed += 1;
               part.stored += 'x';
             }),
        "ends before its compressed size, which the ZIP directory states"},
       {"stored, checksum", with(false, [](ZipPart& part) { part.crc ^= 1; }), "is damaged: its checksum is"},
       {"checksum", with(true, [](ZipPart& part) { part.crc ^= 1; }), "its checksum is"},
       {"garbage", with(true, [](ZipPart& part) { part.stored.assign(part.stored.size(), '\xff'); }),
        "damaged or cut off"},
       {"bomb", zip_bytes({bomb}), "bytes of packed data cannot decompress to 1073741952 bytes"}});
}

TEST(NpzReaderBad, SurvivesTruncationsAndFlippedBits) {
  const TempFolder folder;
  const std::string good = zip_bytes({zip_part("a.npy", kRamp, true), zip_part("b.npy", kRamp, false)});
  for (std::size_t length = 1; length < good.size(); ++length) {
    write_bytes(folder / "v.npz", good.substr(0, length));
    refusal(folder / "v.npz");
  }
  const Context context = with_memory(std::uint64_t{4} << 20);
  for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
    std::string bytes = good;
    bytes[bit / 8] = static_cast<char>(bytes[bit / 8] ^ (1 << (bit % 8)));
    write_bytes(folder / "v.npz", bytes);
    for (const char* name : {"a", "b"}) {
      static_cast<void>(volume_io::read_volume((folder / "v.npz").string(), grid(name), context));
    }
  }
  EXPECT_EQ(context.memory().reserved(), 0U);
}

}  // namespace
}  // namespace isoextract::test
