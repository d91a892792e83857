#include "unit/volume_io/volume_files.hpp"

namespace isoextract::test {
namespace {

// Makes a header from lines; the sizes are kDims unless `fields` states others.
std::string nrrd(const std::string& fields, const std::string& samples, const std::string& type = "uint8") {
  std::string header = "NRRD0005\n# a comment\n";
  if (type != "-") header += "type: " + type + "\n";
  if (fields.find("dimension:") != 0) header += "dimension: 3\nsizes: 3 4 5\n";
  header += fields;
  if (header.find("encoding:") == std::string::npos) header += "encoding: raw\n";
  return header + "\n" + samples;
}

const std::string kSamples = ramp_bytes<std::uint8_t>();

field::ScalarField read_nrrd(const std::string& bytes) {
  const TempFolder folder;
  write_bytes(folder / "v.nrrd", bytes);
  return must_read(folder / "v.nrrd");
}

template <class T>
class NrrdReader : public testing::Test {};
using AllTypes =
    testing::Types<std::uint8_t, std::int8_t, std::uint16_t, std::int16_t, std::uint32_t, std::int32_t, float, double>;
TYPED_TEST_SUITE(NrrdReader, AllTypes);

template <class T>
std::vector<std::string> nrrd_names() {
  if constexpr (std::is_same_v<T, std::uint8_t>) return {"unsigned char", "uchar", "uint8", "uint8_t"};
  if constexpr (std::is_same_v<T, std::int8_t>) return {"signed char", "int8"};
  if constexpr (std::is_same_v<T, std::uint16_t>) return {"unsigned short", "ushort", "uint16"};
  if constexpr (std::is_same_v<T, std::int16_t>) return {"short", "int16_t"};
  if constexpr (std::is_same_v<T, std::uint32_t>) return {"unsigned int", "uint32"};
  if constexpr (std::is_same_v<T, std::int32_t>) return {"int", "int32"};
  if constexpr (std::is_same_v<T, float>) return {"float"};
  if constexpr (std::is_same_v<T, double>) return {"double"};
}

TYPED_TEST(NrrdReader, ReadsBothByteOrdersRawAndGzip) {
  for (const std::string& name : nrrd_names<TypeParam>()) {
    for (const std::endian endian : {std::endian::little, std::endian::big}) {
      const std::string order = endian == std::endian::little ? "endian: little\n" : "endian: big\n";
      const std::string samples = ramp_bytes<TypeParam>(endian);
      expect_ramp<TypeParam>(read_nrrd(nrrd(order + "encoding: raw\n", samples, name)));
      expect_ramp<TypeParam>(read_nrrd(nrrd(order + "encoding: gzip\n", gzip(samples), name)));
      expect_ramp<TypeParam>(read_nrrd(nrrd(order + "encoding: gz\n", gzip(samples), name)));
    }
  }
}

TEST(NrrdReaderData, ReadsGzipWithSeveralMembers) {
  const std::string samples = ramp_bytes<std::uint8_t>();
  const std::string packed = gzip(samples.substr(0, 17)) + gzip(samples.substr(17, 20)) + gzip(samples.substr(37));
  expect_ramp<std::uint8_t>(read_nrrd(nrrd("encoding: gzip\n", packed)));
}

TEST(NrrdReaderData, AppliesLineAndByteSkips) {
  expect_ramp<std::uint8_t>(read_nrrd(nrrd("line skip: 2\nbyte skip: 3\n", "one\ntwo\nabc" + kSamples)));
  expect_ramp<std::uint8_t>(read_nrrd(nrrd("byte skip: -1\n", "any number of bytes" + kSamples)));
  expect_ramp<std::uint8_t>(read_nrrd(nrrd("byte skip: -4\n", "any number of bytes" + kSamples + "abc")));
  expect_ramp<std::uint8_t>(
      read_nrrd(nrrd("encoding: gzip\nline skip: 1\nbyte skip: 3\n", "one\n" + gzip("abc" + kSamples))));
}

TEST(NrrdReaderData, NotesBytesAfterTheSamples) {
  EXPECT_TRUE(has_note(read_nrrd(nrrd("", kSamples + "abc")), "3 bytes after the samples"));
  EXPECT_TRUE(has_note(read_nrrd(nrrd("encoding: gzip\n", gzip(kSamples + "abc"))), "bytes after the samples"));
}

TEST(NrrdReaderData, ReadsHeadersWithCarriageReturns) {
  std::string text = nrrd("space origin: (1,2,3)\n", "");
  text.replace(text.find("space origin"), 0, "space dimension: 3\n");
  std::string windows;
  for (const char c : text) windows += c == '\n' ? std::string("\r\n") : std::string(1, c);
  expect_ramp<std::uint8_t>(read_nrrd(windows + kSamples));
}

TEST(NrrdReaderData, ReadsDetachedFilesBesideAndBelowTheHeader) {
  for (const std::string name : {"data.raw", "./data.raw", "sub/data.raw", "sub/../data.raw", "a name.raw"}) {
    const TempFolder folder;
    std::filesystem::create_directory(folder / "sub");
    write_bytes(folder / name, kSamples);
    for (const std::string field : {"data file: ", "datafile: ", "Data File:   "}) {
      write_bytes(folder / "v.nhdr", nrrd(field + name + "\n", ""));
      expect_ramp<std::uint8_t>(must_read(folder / "v.nhdr"));
    }
    // By its absolute path, and without the empty line at the end.
    write_bytes(folder / "v.nhdr", "NRRD0004\ndimension: 3\ntype: uint8\nsizes: 3 4 5\nencoding: raw\ndata file: " +
                                       (folder / name).string());
    expect_ramp<std::uint8_t>(must_read(folder / "v.nhdr"));
  }
}

TEST(NrrdReaderData, AppliesSkipsToDetachedFiles) {
  const TempFolder folder;
  write_bytes(folder / "data.raw", "line\nabc" + kSamples);
  write_bytes(folder / "v.nhdr", nrrd("data file: data.raw\nline skip: 1\nbyte skip: 3\n", ""));
  expect_ramp<std::uint8_t>(must_read(folder / "v.nhdr"));
}

TEST(NrrdReaderData, ReadsListsAndNumberedFiles) {
  const TempFolder folder;
  std::string list;
  for (int k = 0; k < 5; ++k) {
    const std::string slice = ramp_bytes<std::uint8_t>().substr(static_cast<std::size_t>(12 * k), 12);
    write_bytes(folder / ("s0" + std::to_string(2 * k) + ".raw"), slice);
    write_bytes(folder / ("t" + std::to_string(9 - k) + ".gz"), gzip(slice));
    list += "s0" + std::to_string(2 * k) + ".raw\n";
  }
  write_bytes(folder / "list.nhdr", nrrd("", "").substr(0, nrrd("", "").size() - 1) + "data file: LIST\n" + list);
  expect_ramp<std::uint8_t>(must_read(folder / "list.nhdr"));
  write_bytes(folder / "list2.nhdr", nrrd("", "").substr(0, nrrd("", "").size() - 1) + "data file: LIST 2\n" + list);
  expect_ramp<std::uint8_t>(must_read(folder / "list2.nhdr"));
  write_bytes(folder / "pattern.nhdr", nrrd("data file: s%02d.raw 0 8 2\n", ""));
  expect_ramp<std::uint8_t>(must_read(folder / "pattern.nhdr"));
  write_bytes(folder / "down.nhdr", nrrd("encoding: gzip\ndata file: t%d.gz 9 5 -1 2\n", ""));
  expect_ramp<std::uint8_t>(must_read(folder / "down.nhdr"));

  write_bytes(folder / "few.nhdr", nrrd("data file: s%02d.raw 0 6 2\n", ""));
  expect_in(refusal(folder / "few.nhdr").message,
            "expected 5 data files, one for each index along the axes that the files do not contain, found 4");
  write_bytes(folder / "none.nhdr", nrrd("", "").substr(0, nrrd("", "").size() - 1) + "data file: LIST\n");
  expect_in(refusal(folder / "none.nhdr").message, "found 0");
  write_bytes(folder / "s04.raw", "short");
  expect_in(volume_io::read_volume((folder / "pattern.nhdr").string(), {}, Context()).error().message,
            "expected 12 bytes (one of 5 parts");
}

TEST(NrrdReaderData, RejectsDetachedFilesElsewhere) {
  const TempFolder folder;
  std::filesystem::create_directory(folder / "in");
  std::filesystem::create_directory(folder / "in" / "sub");
  std::filesystem::create_directory(folder / "in2");
  write_bytes(folder / "out.raw", kSamples);
  write_bytes(folder / "in2" / "data.raw", kSamples);
  std::filesystem::create_symlink(folder / "out.raw", folder / "in" / "link.raw");
  std::filesystem::create_directory_symlink(folder / "in2", folder / "in" / "linked");
  const auto header = folder / "in" / "v.nhdr";
  for (const std::string& name :
       {std::string("../out.raw"), std::string("sub/../../out.raw"), (folder / "out.raw").string(),
        std::string("link.raw"), std::string("linked/data.raw"), std::string("/etc/passwd"),
        std::string("../in2/data.raw"), std::string("../nowhere.raw"), std::string("..")}) {
    write_bytes(header, nrrd("data file: " + name + "\n", ""));
    const Error error = refusal(header);
    EXPECT_EQ(error.code, ErrorCode::input);
    expect_in(error.message, "names the data file '" + name + "', which is outside the folder of the header");
    EXPECT_FALSE(error.hint.empty());
    write_bytes(header, nrrd("", "").substr(0, nrrd("", "").size() - 1) + "data file: LIST 3\n" + name + "\n");
    expect_in(refusal(header).message, "outside the folder of the header");
  }
  write_bytes(header, nrrd("data file: ../out%d.raw 0 4 1\n", ""));
  expect_in(refusal(header).message, "outside the folder of the header");
  // A link to a file in the folder is accepted.
  std::filesystem::create_symlink("sub/data.raw", folder / "in" / "inner.raw");
  write_bytes(folder / "in" / "sub" / "data.raw", kSamples);
  write_bytes(header, nrrd("data file: inner.raw\n", ""));
  expect_ramp<std::uint8_t>(must_read(header));
}

TEST(NrrdReaderData, ReportsUnreadableDetachedFiles) {
  const TempFolder folder;
  const auto header = folder / "v.nhdr";
  const auto message = [&](const std::string& name) {
    write_bytes(header, nrrd("data file: " + name + "\n", ""));
    return volume_io::read_volume(header.string(), {}, Context()).error().message;
  };
  expect_in(message("missing.raw"),
            "the header names the data file 'missing.raw', but finding it failed: No such file");
  std::filesystem::create_directory(folder / "folder");
  expect_in(message("folder"), "found a folder");
  write_bytes(folder / "empty.raw", "");
  expect_in(message("empty.raw"), "is empty");
  write_bytes(folder / "short.raw", kSamples.substr(1));
  expect_in(message("short.raw"), "expected 60 bytes (3x4x5 u8 samples) from byte 0 on, found 59");
  expect_in(message("-"), "names the data file '-'");
  expect_in(message("%09999999d.raw 0 4 1"), "names the data file");
  expect_in(message(std::string(5000, 'a')), "names the data file");
}

void expect_placed(const std::string& fields, const glm::ivec3& index, const glm::dvec3& world) {
  SCOPED_TRACE(fields);
  expect_near(read_nrrd(nrrd(fields, kSamples)).index_to_world(index), world);
}

TEST(NrrdReaderPlace, ReadsSpaceDirectionsAsColumns) {
  const field::ScalarField field = read_nrrd(
      nrrd("space: left-posterior-superior\nspace directions: (0,2,0) (-3,0,0.5) (0,0,4)\nspace origin: (10,20,30)\n"
           "kinds: domain domain space\ncenters: cell cell cell\n",
           kSamples));
  EXPECT_EQ(field.world_space, "left-posterior-superior");
  expect_near(field.index_to_world({0, 0, 0}), {10, 20, 30});
  expect_near(field.index_to_world({1, 0, 0}), {10, 22, 30});
  expect_near(field.index_to_world({2, 3, 4}), {10 - 9, 20 + 4, 30 + 1.5 + 16});
}

TEST(NrrdReaderPlace, ReadsOtherFrames) {
  expect_placed("", {1, 2, 3}, {1, 2, 3});
  expect_placed("spacings: 0.5 2 -3\n", {1, 2, 3}, {0.5, 4, -9});
  // A space without directions: spacings along its axes.
  expect_placed("space: RAS\nspace origin: (1,2,3)\nspacings: 2 3 4\n", {1, 1, 1}, {3, 5, 7});
  // Node-centered axes start at their first sample, cell-centered ones half a spacing before it.
  expect_placed("spacings: 2 2 2\naxis mins: 10 20 30\ncenters: node node node\n", {1, 1, 1}, {12, 22, 32});
  expect_placed("spacings: 2 2 2\naxis mins: 10 20 30\ncenters: cell cell cell\n", {1, 1, 1}, {13, 23, 33});
  expect_placed("axis mins: 10 20 30\naxis maxs: 14 26 38\ncenters: node node node\n", {1, 1, 1}, {12, 22, 32});
  expect_placed("axis mins: 10 20 30\naxis maxs: 16 28 40\ncenters: cell cell cell\n", {1, 1, 1}, {13, 23, 33});
}

TEST(NrrdReaderPlace, NotesAssumptions) {
  EXPECT_TRUE(has_note(read_nrrd(nrrd("", kSamples)), "no spacings"));
  const std::string no_origin = nrrd("space: LPS\nspace directions: (1,0,0) (0,1,0) (0,0,1)\n", kSamples);
  EXPECT_TRUE(has_note(read_nrrd(no_origin), "no space origin"));
  const field::ScalarField only_origin = read_nrrd(nrrd("space: LPS\nspace origin: (1,2,3)\n", kSamples));
  EXPECT_TRUE(has_note(only_origin, "no spacings"));
  expect_near(only_origin.index_to_world({1, 1, 1}), {2, 3, 4});
  EXPECT_TRUE(read_nrrd(nrrd("spacings: 1 1 1\n", kSamples)).notes.empty());
  // Options that replace the assumed part leave no note.
  const TempFolder folder;
  volume_io::ReadOptions spacing;
  spacing.spacing = glm::dvec3(2, 2, 2);
  volume_io::ReadOptions origin;
  origin.origin = glm::dvec3(1, 1, 1);
  write_bytes(folder / "v.nrrd", nrrd("", kSamples));
  EXPECT_FALSE(has_note(must_read(folder / "v.nrrd", spacing), "no spacings"));
  EXPECT_TRUE(has_note(must_read(folder / "v.nrrd", origin), "no spacings"));
  write_bytes(folder / "v.nrrd", no_origin);
  EXPECT_TRUE(has_note(must_read(folder / "v.nrrd", spacing), "no space origin"));
  EXPECT_FALSE(has_note(must_read(folder / "v.nrrd", origin), "no space origin"));
}

TEST(NrrdReaderPlace, RequiresASpacingForInvalidFrames) {
  for (const std::string fields :
       {"spacings: 1 nan 1\n", "spacings: nan nan nan\n", "space: LPS\nspace directions: (1,0,0) none (0,0,1)\n",
        "space: LPS\nspace directions: (1,0,0) (nan,nan,nan) (0,0,1)\nspace origin: (0,0,0)\n",
        "space dimension: 2\nspace directions: (1,0) (0,1) (1,1)\n",
        "space: LPS\nspace directions: (1,0,0) (2,0,0) (0,0,1)\nspace origin: (0,0,0)\n",
        "space: LPS\nspace directions: (0,0,0) (0,1,0) (0,0,1)\nspace origin: (0,0,0)\n"}) {
    SCOPED_TRACE(fields);
    const TempFolder folder;
    write_bytes(folder / "v.nrrd", nrrd(fields, kSamples));
    const Error error = refusal(folder / "v.nrrd");
    EXPECT_EQ(error.code, ErrorCode::input);
    EXPECT_EQ(error.hint, Hint(Remedy::give, Setting::spacing_and_origin));
    volume_io::ReadOptions options;
    options.spacing = glm::dvec3(2, 3, 4);
    options.origin = glm::dvec3(1, 1, 1);
    expect_near(must_read(folder / "v.nrrd", options).index_to_world({1, 1, 1}), {3, 4, 5});
  }
}

TEST(NrrdReaderPlace, ReplacesARotatedFrameBySpacingWithANote) {
  const TempFolder folder;
  write_bytes(folder / "v.nrrd",
              nrrd("space: LPS\nspace directions: (0,2,0) (-3,0,0) (0,0,4)\nspace origin: (5,6,7)\n", kSamples));
  volume_io::ReadOptions options;
  options.spacing = glm::dvec3(1, 1, 2);
  const field::ScalarField field = must_read(folder / "v.nrrd", options);
  expect_near(field.index_to_world({1, 1, 1}), {6, 7, 9});
  EXPECT_TRUE(has_note(field, "the given spacing replaces the rotated"));
  options.spacing.reset();
  options.origin = glm::dvec3(0, 0, 0);
  expect_near(must_read(folder / "v.nrrd", options).index_to_world({1, 0, 0}), {0, 2, 0});
}

TEST(NrrdReaderAxes, DropsAxesOfLengthOne) {
  for (const std::string fields :
       {"dimension: 4\nsizes: 1 3 4 5\n", "dimension: 4\nsizes: 3 4 5 1\n", "dimension: 5\nsizes: 3 1 4 5 1\n",
        "dimension: 4\nsizes: 1 3 4 5\nkinds: vector domain domain domain\n",
        "dimension: 4\nsizes: 3 4 5 1\nkinds: domain domain domain time\n"}) {
    SCOPED_TRACE(fields);
    const field::ScalarField field = read_nrrd(nrrd(fields, kSamples));
    expect_ramp<std::uint8_t>(field);
    EXPECT_TRUE(has_note(field, ", which has length 1"));
  }
  const field::ScalarField field =
      read_nrrd(nrrd("dimension: 4\nsizes: 1 3 4 5\nspace: LPS\nspace directions: none (2,0,0) (0,3,0) (0,0,4)\nspace "
                     "origin: (1,1,1)\n",
                     kSamples));
  expect_near(field.index_to_world({1, 1, 1}), {3, 4, 5});
}

TEST(NrrdReaderAxes, RequiresAChoiceForVectorsColorsAndSeries) {
  const std::string samples(600, 'x');
  expect_all_refused(
      "v.nrrd",
      {{"color", nrrd("dimension: 4\nsizes: 3 3 4 5\nkinds: RGB-color domain domain domain\n", samples),
        "found 3 components"},
       {"vectors last", nrrd("dimension: 4\nsizes: 3 4 5 2\nkinds: domain domain domain vector\n", samples),
        "found 2 components"},
       {"series", nrrd("dimension: 4\nsizes: 3 4 5 2\nkinds: domain domain domain time\n", samples),
        "because the file has 2 volumes"},
       {"color image", nrrd("dimension: 3\nsizes: 3 4 5\nkinds: vector domain domain\n", samples),
        "expected three spatial axes, found 2"},
       {"two axes of components",
        nrrd("dimension: 5\nsizes: 2 3 3 4 5\nkinds: complex 3-vector domain domain domain\n", samples),
        "found axis 1 (3 values, kind 3-vector) as well"},
       {"between", nrrd("dimension: 4\nsizes: 3 2 4 5\nkinds: domain vector domain domain\n", samples), "between them"},
       {"no direction",
        nrrd("dimension: 4\nsizes: 3 3 4 5\nspace: LPS\n"
             "space directions: none (2,0,0) (0,3,0) (0,0,4)\n",
             samples),
        "found 3 components"},
       {"four dimensions", nrrd("dimension: 4\nsizes: 3 4 5 2\n", samples), "expected three spatial axes, found 4"},
       {"image", nrrd("dimension: 2\nsizes: 3 4\n", samples), "expected three spatial axes, found 2"}});
}

TEST(NrrdReaderBad, NamesUnsupportedTypesAndEncodings) {
  const std::string samples(600, '1');
  expect_all_refused("v.nrrd",
                     {{"block", nrrd("endian: little\nblock size: 7\n", samples, "block"), "found type 'block'"},
                      {"ascii", nrrd("encoding: ascii\n", samples), "expected encoding raw or gzip, found ASCII"},
                      {"hex", nrrd("encoding: hex\n", samples), "expected encoding raw or gzip, found hex"},
                      {"bzip2", nrrd("encoding: bzip2\n", samples), "expected encoding raw or gzip, found bzip2"},
                      {"skip list", nrrd("data file: SKIPLIST\n", samples), "SKIPLIST"}});
}

TEST(NrrdReaderBad, RejectsMalformedFiles) {
  const std::string good = nrrd("spacings: 1 1 1\n", kSamples);
  const std::string packed = gzip(kSamples);
  std::string flipped = packed;
  flipped[flipped.size() / 2] = static_cast<char>(flipped[flipped.size() / 2] ^ 0x10);
  std::string bad_checksum = packed;
  bad_checksum[bad_checksum.size() - 6] = static_cast<char>(bad_checksum[bad_checksum.size() - 6] ^ 1);
  expect_all_refused(
      "v.nrrd",
      {{"empty file", "", "empty"},
       {"text", "this is some text\n", "not a NRRD file"},
       {"other magic", "NRRD0009\n\n", "not a valid NRRD header"},
       {"magic only", "NRRD0004", "the header has neither an empty line"},
       {"nothing in the header", "NRRD0004\n\nabc", "no field 'type'"},
       {"no type", nrrd("", kSamples, "-"), "no field 'type'"},
       {"no sizes", "NRRD0004\ntype: uint8\ndimension: 3\nencoding: raw\n\nabc", ""},
       {"no encoding", "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 3 4 5\n\n" + kSamples, "no field 'encoding'"},
       {"no endian", nrrd("", std::string(600, 'x'), "int16"), "require endian info"},
       {"unknown type", nrrd("", kSamples, "quaternion"), "quaternion"},
       {"unknown field", nrrd("color: green\n", kSamples), "not a valid NRRD header"},
       {"field twice", nrrd("type: uint8\n", kSamples), "not a valid NRRD header"},
       {"cut header", good.substr(0, 30), "the header has neither an empty line"},
       {"cut samples", good.substr(0, good.size() - 1), "found 59"},
       {"no samples", good.substr(0, good.size() - 60), "found 0"},
       {"huge size", nrrd("dimension: 3\nsizes: 1099511627776 1 1\n", kSamples), "found 1099511627776x1x1"},
       {"huge volume", nrrd("dimension: 3\nsizes: 2000000000 2000000000 2000000000\n", kSamples), "too large"},
       {"large volume", nrrd("dimension: 3\nsizes: 60000 60000 60000\n", kSamples), "expected 216000000000000 bytes"},
       {"size over 64 bits", nrrd("dimension: 3\nsizes: 99999999999999999999999 1 1\n", kSamples), ""},
       {"negative size", nrrd("dimension: 3\nsizes: -3 4 5\n", kSamples), ""},
       {"zero size", nrrd("dimension: 3\nsizes: 3 0 5\n", kSamples), "not a valid NRRD header"},
       {"few sizes", nrrd("dimension: 3\nsizes: 3 4\n", kSamples), "not a valid NRRD header"},
       {"many sizes", nrrd("dimension: 3\nsizes: 3 4 5 6\n", kSamples), "not a valid NRRD header"},
       {"many dimensions", nrrd("dimension: 99\nsizes: 3 4 5\n", kSamples), "not a valid NRRD header"},
       {"infinite direction", nrrd("space: LPS\nspace directions: (inf,0,0) (0,1,0) (0,0,1)\n", kSamples),
        "not a valid NRRD header"},
       {"open direction", nrrd("space: LPS\nspace directions: (1,0,0 (0,1,0) (0,0,1)\n", kSamples),
        "not a valid NRRD header"},
       {"lines to skip", nrrd("line skip: 9\n", kSamples), "as 'line skip' says, found the end"},
       {"bytes to skip", nrrd("byte skip: 9000000000000000000\n", kSamples), "found 0"},
       {"bytes to skip from the end", nrrd("byte skip: -9223372036854775808\n", kSamples),
        "needs a file of at least 9223372036854775867 bytes"},
       {"skip from the end in gzip", nrrd("encoding: gzip\nbyte skip: -1\n", packed),
        "'byte skip' -1 needs encoding raw, found gzip"},
       {"binary header", "NRRD0004\n" + std::string(100, '\0') + "\n\n", "binary data"},
       {"gzip cut", nrrd("encoding: gzip\n", packed.substr(0, packed.size() - 3)), "damaged or cut off"},
       {"gzip cut early", nrrd("encoding: gzip\n", packed.substr(0, packed.size() / 2)), "damaged or cut off"},
       {"gzip garbage", nrrd("encoding: gzip\n", "this is not gzip data at all"), "expected gzip data"},
       {"gzip flipped", nrrd("encoding: gzip\n", flipped), "damaged or cut off"},
       {"gzip checksum", nrrd("encoding: gzip\n", bad_checksum), "damaged or cut off"},
       {"gzip too short", nrrd("encoding: gzip\n", gzip(kSamples.substr(1))), "holds 59 bytes, expected 60"},
       {"gzip bomb", nrrd("dimension: 3\nsizes: 60000 60000 60000\nencoding: gzip\n", packed), "cannot decompress"},
       {"gzip skip too far", nrrd("encoding: gzip\nbyte skip: 50\n", packed), "holds 60 bytes"}});
}

// teem writes messages that repeat the line into a buffer of 1025 bytes.
TEST(NrrdReaderBad, RejectsLinesTooLongForTeem) {
  const std::string many(2000, 'x');
  std::vector<BadFile> files{
      {"no field", nrrd(many + "\n", kSamples), "line 6 of the header has 2000 bytes, the limit is 768"},
      {"first line", "NRRD0004" + many + "\n\n", "line 1 of the header has 2008 bytes"}};
  std::vector<std::string> fields{
      "type: ",    "space: ",     "endian: ",           "centers: ",         "kinds: ",
      "units: ",   "labels: ",    "space directions: ", "space dimension: ", "no field: ",
      "old min: ", "line skip: ", "spacings: ",         "sizes: ",           "block size: "};
  for (const std::string& field : fields) {
    files.push_back({field.c_str(), nrrd(field + many + "\n", kSamples), "'" + field + "xxx"});
  }
  expect_all_refused("v.nrrd", files);
  expect_all_refused("v.vdb", {{"found by its content", nrrd("kinds: " + many + "\n", kSamples), "2007 bytes"}});
}

TEST(NrrdReaderBad, ReportsInvalidFieldsOfTheGreatestLength) {
  const std::vector<std::string> fields{"",
                                        "type: ",
                                        "space: ",
                                        "endian: ",
                                        "encoding: ",
                                        "centers: ",
                                        "kinds: ",
                                        "units: \"",
                                        "labels: \"",
                                        "spacings: ",
                                        "thicknesses: ",
                                        "axis mins: ",
                                        "axis maxs: ",
                                        "space dimension: ",
                                        "space directions: ",
                                        "space directions: (",
                                        "space directions: none",
                                        "space origin: (",
                                        "measurement frame: (",
                                        "space units: \"",
                                        "old min: ",
                                        "old max: ",
                                        "line skip: ",
                                        "byte skip: ",
                                        "block size: ",
                                        "sizes: ",
                                        "dimension: ",
                                        "no such field: ",
                                        std::string(700, 'x') + ": "};
  for (const std::string& field : fields) {
    SCOPED_TRACE(field);
    const TempFolder folder;
    const std::string line = field + std::string(768 - field.size(), 'x') + "\n";
    // Most fields are checked only after the dimensions are known; these two may occur once.
    const bool is_first = field.starts_with("space: ") || field.find("dimension") != std::string::npos;
    write_bytes(folder / "v.nrrd", (is_first ? "NRRD0005\n" : "NRRD0005\nspace: LPS\ndimension: 3\n") + line + "\n");
    const Error error = refusal(folder / "v.nrrd");
    EXPECT_EQ(error.message.find("the limit is"), std::string::npos) << error.message;
    EXPECT_EQ(error.code, ErrorCode::input);
  }
}

TEST(NrrdReaderBad, RejectsMoreValuesThanTeemHasRoomFor) {
  const auto ones = [](int count) {
    std::string text;
    for (int i = 0; i < count; ++i) text += i % 2 == 0 ? " 1" : "\t1";
    return text;
  };
  std::vector<BadFile> files;
  for (const char* field : {"spacings:", "thicknesses:", "axis mins:", "Axis Maxs:"}) {
    files.push_back({field, nrrd("dimension: 16\nsizes: 3 4 5" + ones(13) + "\n" + field + ones(17) + "\n", kSamples),
                     "line 6 of the header has 17 values, a NRRD has at most 16 axes"});
  }
  files.push_back({"sizes", nrrd("dimension: 16\nsizes: 3 4 5" + ones(14) + "\n", kSamples), "line 5 of the header"});
  expect_all_refused("v.nrrd", files);
  expect_ramp<std::uint8_t>(
      read_nrrd(nrrd("dimension: 16\nsizes: 3 4 5" + ones(13) + "\nspacings:" + ones(16) + "\n", kSamples)));
}

TEST(NrrdReaderData, AcceptsLongComments) {
  const std::string many(5000, 'x');
  for (const std::string& line :
       {"# " + many, "key:=" + many, many + ":=value", "key: with a colon:=" + many, "key:=" + many + ": " + many,
        "content: " + many, "Content: a:=" + many, "key:=" + many + "\n# " + many + "\ncontent: " + many}) {
    SCOPED_TRACE(line.substr(0, 20));
    expect_ramp<std::uint8_t>(read_nrrd(nrrd(line + "\nspacings: 1 2 3\n", kSamples)));
  }
  const TempFolder folder;
  write_bytes(folder / "data.raw", kSamples);
  write_bytes(folder / "v.nhdr", nrrd("key:=" + many + "\ndata file: data.raw\n", ""));
  expect_ramp<std::uint8_t>(must_read(folder / "v.nhdr"));
}

TEST(NrrdReaderBad, PrintsNothing) {
  const TempFolder folder;
  const std::string good = nrrd(
      "space: LPS\nspace directions: (1,0,0) (0,1,0) (0,0,1)\nkinds: domain domain domain\n"
      "labels: \"x\" \"y\" \"z\"\nkey:=value\n",
      kSamples);
  testing::internal::CaptureStderr();
  testing::internal::CaptureStdout();
  for (std::size_t length = 1; length < good.size(); ++length) {
    write_bytes(folder / "v.nrrd", good.substr(0, length));
    refusal(folder / "v.nrrd");
  }
  for (std::size_t bit = 0; bit < 8 * (good.size() - kSamples.size()); bit += 3) {
    std::string bytes = good;
    bytes[bit / 8] = static_cast<char>(bytes[bit / 8] ^ (1 << (bit % 8)));
    write_bytes(folder / "v.nrrd", bytes);
    static_cast<void>(volume_io::read_volume((folder / "v.nrrd").string(), {}, Context()));
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
}

}  // namespace
}  // namespace isoextract::test
