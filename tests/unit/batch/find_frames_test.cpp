#include "batch/find_frames.hpp"

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "support/hints.hpp"
#include "support/temp_folder.hpp"

namespace isoextract::batch {
namespace {

namespace fs = std::filesystem;

// Works in a temporary folder, to which the names in messages are relative.
class FindFrames : public testing::Test {
 protected:
  FindFrames() { fs::current_path(folder_.path()); }
  ~FindFrames() override { fs::current_path(before_); }

  static void make(std::initializer_list<const char*> names) {
    for (const char* name : names) {
      if (fs::path(name).has_parent_path()) fs::create_directories(fs::path(name).parent_path());
      test::write_bytes(name, "");
    }
  }

  static Result<Frames> find(const std::vector<std::string>& inputs, const std::string& range = {}) {
    std::optional<FrameRange> wanted;
    if (!range.empty()) wanted = FrameRange::parse(range).value();
    return find_frames(inputs, wanted);
  }

  // Returns "1=a_1.vdb 3=a_3.vdb | gaps 2", or the error.
  static std::string found(const std::vector<std::string>& inputs, const std::string& range = {}) {
    const auto frames = find(inputs, range);
    if (!frames) return fmt::format("{}: {}", exit_code_of(frames.error().code), frames.error().message);
    std::string text;
    for (const Frame& frame : frames->frames) {
      text += fmt::format("{}{}={}", text.empty() ? "" : " ", frame.number, frame.input);
    }
    if (!frames->gaps.empty()) text += " | gaps " + text_of(frames->gaps);
    return text;
  }

 private:
  fs::path before_ = fs::current_path();
  test::TempFolder folder_;
};

TEST_F(FindFrames, MatchesPattern) {
  make({"a_0010.vdb", "a_0002.vdb", "a_0001.vdb", "a_003.vdb", "a_0004.vdb.tmp", "b_0005.vdb", "a_.vdb",
        "s/a_0006.vdb"});
  fs::create_directory("a_0009.vdb");
  EXPECT_EQ(found({"a_{:04}.vdb"}), "1=a_0001.vdb 2=a_0002.vdb 10=a_0010.vdb | gaps 3-9");
  EXPECT_EQ(found({"./a_####.vdb"}), "1=./a_0001.vdb 2=./a_0002.vdb 10=./a_0010.vdb | gaps 3-9");
  EXPECT_EQ(found({"s/a_%04d.vdb"}), "6=s/a_0006.vdb");
  EXPECT_EQ(found({"a_{}.vdb"}), "1=a_0001.vdb 2=a_0002.vdb 3=a_003.vdb 10=a_0010.vdb | gaps 4-9");
}

TEST_F(FindFrames, SelectsRangeAndListsGaps) {
  make({"a_1.vdb", "a_2.vdb", "a_3.vdb", "a_5.vdb", "a_12.vdb", "a_-1.vdb"});
  EXPECT_EQ(found({"a_{}.vdb"}, "1-10x2"), "1=a_1.vdb 3=a_3.vdb 5=a_5.vdb | gaps 7,9");
  EXPECT_EQ(found({"a_{}.vdb"}, "-3-1"), "-1=a_-1.vdb 1=a_1.vdb | gaps -3--2,0");
  EXPECT_EQ(found({"a_{}.vdb"}, "12"), "12=a_12.vdb");
  EXPECT_EQ(found({"a_{}.vdb"}, "6-11"), "2: a_{}.vdb: no file matches this pattern with a number in 6-11");
  EXPECT_EQ(found({"a_1.vdb", "a_2.vdb", "a_5.vdb"}, "2-4"), "2=a_2.vdb | gaps 3-4");
  EXPECT_EQ(found({"a_1.vdb", "a_2.vdb"}, "7"), "2: a_1.vdb and 1 more: expected files of the frames 7, found none");
  EXPECT_EQ(found({"."}, "2-4"), "2=./a_2.vdb 3=./a_3.vdb | gaps 4");
}

TEST_F(FindFrames, FindsGapsByStep) {
  make({"a_0.vdb", "a_10.vdb", "a_40.vdb", "a_50.vdb", "a_70.vdb", "b_1.vdb", "b_999999999999999999.vdb", "b_2.vdb"});
  EXPECT_EQ(found({"a_{}.vdb"}), "0=a_0.vdb 10=a_10.vdb 40=a_40.vdb 50=a_50.vdb 70=a_70.vdb | gaps 20-30x10,60");
  const auto far = find({"b_{}.vdb"});
  ASSERT_TRUE(far);
  EXPECT_EQ(text_of(far->gaps), "3-999999999999999998");
}

TEST_F(FindFrames, NumbersFoldersByPattern) {
  make({"shot_001/density.vdb", "shot_002/other.vdb", "shot_003/density.vdb", "shot_007/density.vdb",
        "shot_010/density.vdb", "shot_4/density.vdb", "shot_005"});
  fs::create_directories("shot_006/density.vdb");
  EXPECT_EQ(
      found({"shot_{:03}/density.vdb"}),
      "1=shot_001/density.vdb 3=shot_003/density.vdb 7=shot_007/density.vdb 10=shot_010/density.vdb | gaps 2,4-6,8-9");
  EXPECT_EQ(found({"shot_{:03}/density.vdb"}, "2-3"), "3=shot_003/density.vdb | gaps 2");
}

TEST_F(FindFrames, PrefersFileOverPattern) {
  make({"a####.vdb", "a0001.vdb", "x%04d.raw", "y{}{}.raw"});
  EXPECT_EQ(found({"a####.vdb"}), "1=a####.vdb");
  EXPECT_EQ(found({"x%04d.raw"}), "4=x%04d.raw");
  EXPECT_EQ(found({"y{}{}.raw"}), "1=y{}{}.raw");
  EXPECT_EQ(found({"a%04d.vdb"}), "1=a0001.vdb");
}

TEST_F(FindFrames, FailsWithoutMatches) {
  make({"a_001.vdb", "a_002.vdb"});
  EXPECT_EQ(found({"b_{:04}.vdb"}), "2: b_{:04}.vdb: no file matches this pattern");
  EXPECT_EQ(found({"no/b_{:04}.vdb"}), "2: no/: cannot read the folder: No such file or directory");
  EXPECT_EQ(found({"a_001.vdb/{}"}), "2: a_001.vdb/: cannot read the folder: Not a directory");
  EXPECT_EQ(found({"x\n{}"}), "2: x\\n{}: no file matches this pattern");
  const auto near = find({"a_{:04}.vdb"});
  ASSERT_FALSE(near);
  EXPECT_EQ(test::text_of(near.error().hint), "{} matches a_001.vdb");
}

TEST_F(FindFrames, TellsThatPatternsStandForWholeNumbers) {
  make({"t_0.5.npy", "t_0.25.npy", "t_.75.npy", "t_1e-3.npy", "t_-2p5.npy", "t_1.x.npy", "t_.npy", "t_v2.5.npy"});
  const auto none = find({"./t_{}.npy"}, "1-2");
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().message.find("./t_{}.npy: no file matches this pattern with a number in 1-2; t_"),
            std::string::npos)
      << none.error().message;
  EXPECT_NE(none.error().message.find("has a decimal number, and the pattern stands for whole numbers"),
            std::string::npos);
  EXPECT_EQ(test::text_of(none.error().hint),
            "list the files, without quotes: ./t_*.npy; the run orders the files by their decimal numbers");
  EXPECT_EQ(found({"u_{}.npy"}), "2: u_{}.npy: no file matches this pattern");
  make({"t_0.npy", "t_1.npy"});
  const auto some = find({"t_{}.npy"});
  ASSERT_TRUE(some);
  EXPECT_EQ(some->frames.size(), 2U);
  ASSERT_EQ(some->notes.size(), 1U);
  EXPECT_EQ(some->notes.front().text.substr(0, some->notes.front().text.find(", such as")),
            "t_{}.npy: the pattern stands for whole numbers; the run leaves out 5 files with decimal numbers");
}

TEST_F(FindFrames, FailsForRepeatedNumber) {
  make({"f_1.vdb", "f_01.vdb", "f_2.vdb"});
  const std::string both = "2: expected one file for frame 1, found f_01.vdb and f_1.vdb";
  EXPECT_EQ(found({"f_{}.vdb"}), both);
  EXPECT_EQ(found({"f_1.vdb", "f_2.vdb", "f_01.vdb"}), both);
  EXPECT_EQ(found({"f_{}.vdb"}, "2-5"), "2=f_2.vdb | gaps 3-5");
  EXPECT_EQ(found({"."}), "2: expected one file for frame 1, found ./f_01.vdb and ./f_1.vdb");
}

TEST_F(FindFrames, NumbersListedFilesByName) {
  make({"v2_10.vdb", "v2_9.vdb", "v2_7.vdb"});
  EXPECT_EQ(found({"v2_10.vdb", "v2_7.vdb", "v2_9.vdb"}), "7=v2_7.vdb 9=v2_9.vdb 10=v2_10.vdb | gaps 8");
  EXPECT_EQ(found({"gone_1.vdb", "gone_2.vdb"}), "1=gone_1.vdb 2=gone_2.vdb");
}

TEST_F(FindFrames, NumbersOtherListedFilesByPosition) {
  make({"b.vdb", "a.vdb", "c1_1.vdb", "c2_2.vdb"});
  EXPECT_EQ(found({"b.vdb", "a.vdb"}), "1=b.vdb 2=a.vdb");
  EXPECT_EQ(found({"c2_2.vdb", "c1_1.vdb"}), "1=c2_2.vdb 2=c1_1.vdb");
  EXPECT_EQ(found({"demo:sphere?size=64", "demo:sphere?size=16"}), "1=demo:sphere?size=64 2=demo:sphere?size=16");
  const auto frames = find({"b.vdb", "a.vdb"});
  ASSERT_TRUE(frames);
  ASSERT_EQ(frames->notes.size(), 1U);
  EXPECT_EQ(frames->notes.front().text,
            "the file names do not differ in exactly one number: the run numbers the frames 1 to 2 by their order");
  EXPECT_TRUE(find({"c1_1.vdb", "c1_2.vdb"})->notes.empty());
}

TEST_F(FindFrames, OrdersByDecimalValue) {
  EXPECT_EQ(found({"t_0.25.npy", "t_0.5.npy", "t_0.75.npy"}), "1=t_0.25.npy 2=t_0.5.npy 3=t_0.75.npy");
  EXPECT_EQ(found({"t_1e-1.npy", "t_1e-2.npy", "t_1e+0.npy", "t_2.5e-02.npy"}),
            "1=t_1e-2.npy 2=t_2.5e-02.npy 3=t_1e-1.npy 4=t_1e+0.npy");
  EXPECT_EQ(found({"t_0.5.npy", "t_10.0.npy", "t_2.0.npy"}), "1=t_0.5.npy 2=t_2.0.npy 3=t_10.0.npy");
  EXPECT_EQ(found({"t_0.npy", "t_0.5.npy", "t_1.npy", "t_1.25.npy"}), "1=t_0.npy 2=t_0.5.npy 3=t_1.npy 4=t_1.25.npy");
  EXPECT_EQ(found({"t_-0.5.npy", "t_0.5.npy", "t_-1.5.npy"}), "1=t_-1.5.npy 2=t_-0.5.npy 3=t_0.5.npy");
  EXPECT_EQ(found({"run-0.5.npy", "run-0.25.npy"}), "1=run-0.25.npy 2=run-0.5.npy");
  EXPECT_EQ(found({"0.05/p.npy", "0.1/p.npy", "0.5/p.npy"}), "1=0.05/p.npy 2=0.1/p.npy 3=0.5/p.npy");
  EXPECT_EQ(found({"t_0.5.npy", "t_0.75.npy", "t_0.25.npy"}, "2-3"), "2=t_0.5.npy 3=t_0.75.npy");
  EXPECT_EQ(find({"t_0.5.npy", "t_0.25.npy"})->notes,
            (Notes{{NoteId::frame_order,
                    "the file names differ in a decimal number: the run numbers the frames 1 to 2 by its "
                    "value, from t_0.25.npy to t_0.5.npy"}}));
  make({"d/t_0.5.npy", "d/t_0.25.npy", "d/t_0.75.npy", "d/t_1.npy"});
  EXPECT_EQ(found({"d"}), "1=d/t_0.25.npy 2=d/t_0.5.npy 3=d/t_0.75.npy 4=d/t_1.npy");
}

TEST_F(FindFrames, AcceptsOtherDecimalMarks) {
  EXPECT_EQ(found({"t_.25.npy", "t_.5.npy", "t_.75.npy"}), "1=t_.25.npy 2=t_.5.npy 3=t_.75.npy");
  EXPECT_EQ(found({"t_.5.npy", "t_.25.npy", "t_1.npy", "t_-.5.npy"}), "1=t_-.5.npy 2=t_.25.npy 3=t_.5.npy 4=t_1.npy");
  EXPECT_EQ(found({"t_0p25.npy", "t_0p5.npy", "t_0p75.npy"}), "1=t_0p25.npy 2=t_0p5.npy 3=t_0p75.npy");
  EXPECT_EQ(found({"t_0,25.npy", "t_0,5.npy", "t_0,75.npy"}), "1=t_0,25.npy 2=t_0,5.npy 3=t_0,75.npy");
  EXPECT_EQ(found({"f_.8.npy", "f_.9.npy", "f_.10.npy"}), "8=f_.8.npy 9=f_.9.npy 10=f_.10.npy");
  EXPECT_EQ(found({"f.25.npy", "f.5.npy", "f.75.npy"}), "5=f.5.npy 25=f.25.npy 75=f.75.npy | gaps 15,35-65x10");
  make({"p/t_0p25.npy", "p/t_0p5.npy", "p/t_0p75.npy", "p/t_.25.npy", "p/t_.5.npy", "p/t_.75.npy"});
  EXPECT_EQ(found({"p/t_0p{}.npy"}),
            "1: p/t_0p{}.npy: expected whole frame numbers, found decimal numbers in the names t_0p25.npy and "
            "t_0p75.npy");
  EXPECT_EQ(found({"p/t_.{}.npy"}),
            "1: p/t_.{}.npy: expected whole frame numbers, found decimal numbers in the names t_.25.npy and "
            "t_.75.npy");
}

TEST_F(FindFrames, NotesDigitsThatMayBeFractions) {
  const auto note = [&](std::vector<std::string> names) {
    const auto frames = find(std::move(names));
    return frames && !frames->notes.empty() ? frames->notes.front().text : "none";
  };
  const std::string_view taken = "the digits after the point count as whole numbers: 10 follows 9";
  EXPECT_EQ(note({"t_1.25.npy", "t_1.45.npy", "t_1.5.npy"}), fmt::format("t_1.{{}}.npy: {}", taken));
  EXPECT_EQ(note({"t_0.2.npy", "t_0.4.npy", "t_0.6.npy", "t_0.8.npy", "t_0.10.npy"}),
            fmt::format("t_0.{{}}.npy: {}", taken));
  EXPECT_EQ(note({"t_0.8.npy", "t_0.9.npy", "t_0.10.npy"}), "none");
}

TEST_F(FindFrames, NumbersByDigitsAfterVersion) {
  EXPECT_EQ(found({"f_v2.8.vdb", "f_v2.9.vdb", "f_v2.10.vdb"}), "8=f_v2.8.vdb 9=f_v2.9.vdb 10=f_v2.10.vdb");
  EXPECT_EQ(found({"f_v2.7.vdb", "f_v2.9.vdb", "f_v2.11.vdb"}), "7=f_v2.7.vdb 9=f_v2.9.vdb 11=f_v2.11.vdb");
  EXPECT_EQ(found({"t_0.10.npy", "t_0.25.npy"}), "10=t_0.10.npy 25=t_0.25.npy");
  EXPECT_TRUE(find({"f_v2.8.vdb", "f_v2.9.vdb", "f_v2.10.vdb"})->notes.empty());
  EXPECT_EQ(found({"f_v2.5.vdb", "f_v2.9.vdb", "f_v2.10.vdb"}), "5=f_v2.5.vdb 9=f_v2.9.vdb 10=f_v2.10.vdb | gaps 6-8");
  EXPECT_EQ(
      find({"f_v2.5.vdb", "f_v2.9.vdb", "f_v2.10.vdb"})->notes,
      (Notes{{NoteId::frame_order, "f_v2.{}.vdb: the digits after the point count as whole numbers: 10 follows 9"}}));
  make({"s_v2.97.vdb", "s_v2.98.vdb", "s_v2.99.vdb", "s_v2.101.vdb"});  // 100 is lost or not yet written
  EXPECT_EQ(found({"s_v2.{}.vdb"}, "97-101"),
            "97=s_v2.97.vdb 98=s_v2.98.vdb 99=s_v2.99.vdb 101=s_v2.101.vdb | gaps 100");
  EXPECT_EQ(found({"s_v2.97.vdb", "s_v2.98.vdb", "s_v2.99.vdb", "s_v2.101.vdb"}),
            "97=s_v2.97.vdb 98=s_v2.98.vdb 99=s_v2.99.vdb 101=s_v2.101.vdb | gaps 100");
  EXPECT_EQ(found({"t_0.1.npy", "t_0.2.npy", "t_0.25.npy", "t_0.3.npy"}),
            "1=t_0.1.npy 2=t_0.2.npy 3=t_0.25.npy 4=t_0.3.npy");
  make({"d/shot_1.0001.vdb", "d/shot_1.0002.vdb", "d/shot_2.0001.vdb"});
  EXPECT_EQ(found({"d"}),
            "1: d: expected one sequence in the folder, found 2: shot_1.{:04}.vdb (2 files), shot_2.0001.vdb");
  make({"v_2.8.vdb", "v_2.9.vdb", "v_2.10.vdb", "v_2.11.vdb"});
  EXPECT_EQ(found({"v_2.{}.vdb"}, "9-11"), "9=v_2.9.vdb 10=v_2.10.vdb 11=v_2.11.vdb");
}

TEST_F(FindFrames, RefusesPatternInsideDecimals) {
  make({"t_0.25.npy", "t_0.5.npy", "t_0.75.npy", "t_1e-1.npy", "t_1e-2.npy"});
  EXPECT_EQ(found({"t_0.{}.npy"}),
            "1: t_0.{}.npy: expected whole frame numbers, found decimal numbers in the names t_0.25.npy and "
            "t_0.75.npy");
  EXPECT_EQ(test::text_of(find({"t_0.{}.npy"}, "5-25").error().hint),
            "list the files, without quotes: t_0.*.npy; the run orders the files by their decimal numbers");
  EXPECT_EQ(found({"t_1e-{}.npy"}),
            "1: t_1e-{}.npy: expected whole frame numbers, found decimal numbers in the names t_1e-1.npy and "
            "t_1e-2.npy");
  EXPECT_EQ(found({"t_0.{:02}.npy"}), "25=t_0.25.npy 75=t_0.75.npy");
}

TEST_F(FindFrames, RefusesPatternsAndFoldersInLists) {
  make({"a.vdb", "b####.vdb", "s/a.vdb"});
  EXPECT_EQ(found({"a.vdb", "b####.vdb"}), "1=a.vdb 2=b####.vdb");
  EXPECT_EQ(found({"a.vdb", "c####.vdb"}), "1: c####.vdb: expected files, found a pattern as one of 2 inputs");
  EXPECT_EQ(found({"a.vdb", "demo:sphere?size={}"}),
            "1: demo:sphere?size={}: expected files, found a pattern as one of 2 inputs");
  EXPECT_EQ(found({"s", "a.vdb"}), "1: s: expected files, found a folder as one of 2 inputs");
  EXPECT_EQ(found({"a.vdb", "a.vdb"}), "1: a.vdb: expected each input once, found this input twice");
  EXPECT_EQ(found({}), "1: expected an input, found none");
}

TEST_F(FindFrames, FindsSequenceInFolder) {
  make({"d/f_10.vdb", "d/f_9.VDB", "d/f_8.vdb", "d/.f_7.vdb", "d/notes.txt", "d/s/f_6.vdb", "d/log.json"});
  EXPECT_EQ(found({"d"}), "1: d: expected one sequence in the folder, found 2: f_{}.vdb (2 files), f_9.VDB");
  fs::rename("d/f_9.VDB", "d/f_9.vdb");
  EXPECT_EQ(found({"d"}), "8=d/f_8.vdb 9=d/f_9.vdb 10=d/f_10.vdb");
  EXPECT_EQ(found({"d/"}), "8=d/f_8.vdb 9=d/f_9.vdb 10=d/f_10.vdb");
  EXPECT_EQ(
      find({"d"})->notes,
      (Notes{{NoteId::other_files,
              "d: the program takes 3 volume files (such as f_8.vdb) and skips 2 other files (such as log.json)"}}));
  EXPECT_EQ(found({"d"}, "1-9x8"), "9=d/f_9.vdb | gaps 1");
}

TEST_F(FindFrames, RefusesNamesWithoutFile) {
  make({"a_1.vdb", "a_2.vdb", "IM3"});
  EXPECT_EQ(found({"a_1.vdb", "%"}), "1: %: expected a file as one of 2 inputs, found no file of this name");
  EXPECT_EQ(found({"a_1.vdb", "IM3"}), "1=a_1.vdb 2=IM3");
  EXPECT_EQ(found({"a_1.vdb", "a_3.vdb"}), "1=a_1.vdb 3=a_3.vdb");
}

TEST_F(FindFrames, SkipsSampleFilesOfListedHeaders) {
  make({"d/a_1.nhdr", "d/a_1.raw", "d/a_2.nhdr", "d/a_2.raw.gz"});
  EXPECT_EQ(found({"d"}), "1=d/a_1.nhdr 2=d/a_2.nhdr");
  EXPECT_TRUE(find({"d"})->notes.empty());
  make({"e/scan.nhdr", "e/scan.zraw"});
  EXPECT_EQ(found({"e"}), "1=e/scan.nhdr");
  EXPECT_TRUE(find({"e"})->notes.empty() || find({"e"})->notes.front().id != NoteId::other_files);
  EXPECT_EQ(found({"e/scan.nhdr", "e/scan.zraw"}), "1=e/scan.nhdr");
  EXPECT_EQ(found({"d/a_1.nhdr", "d/a_1.raw", "d/a_2.nhdr", "d/a_2.raw.gz"}), "1=d/a_1.nhdr 2=d/a_2.nhdr");
  EXPECT_EQ(found({"d/a_1.raw", "d/a_2.nhdr"}), "1=d/a_1.raw 2=d/a_2.nhdr") << "the header of a_1.raw is not listed";
  make({"f/scan.nhdr", "f/other.raw"});
  EXPECT_EQ(found({"f"}), "1=f/other.raw 2=f/scan.nhdr");
}

TEST_F(FindFrames, OrdersUnnumberedFilesNaturally) {
  make({"d/skull.nrrd", "d/head10.nii.gz", "d/head.nii.gz", "d/arm.vdb"});
  EXPECT_EQ(found({"d"}), "1=d/arm.vdb 2=d/head.nii.gz 3=d/head10.nii.gz 4=d/skull.nrrd");
  EXPECT_EQ(find({"d"})->notes.size(), 1U);
  make({"one/f_0042.vdb"});
  EXPECT_EQ(found({"one"}), "42=one/f_0042.vdb");
}

TEST_F(FindFrames, ListsSeveralSequencesInFolder) {
  make({"d/smoke_0001.vdb", "d/smoke_0002.vdb", "d/fire_1.vdb", "d/fire_2.vdb", "d/fire_3.vdb", "d/cache\x1b.npy"});
  EXPECT_EQ(found({"d"}),
            "1: d: expected one sequence in the folder, found 3: cache\\x1b.npy, fire_{}.vdb (3 files), "
            "smoke_{:04}.vdb (2 files)");
  for (int i = 0; i < 30; ++i) make({fmt::format("d/{}_x.vdb", std::string(1 + i, 'a')).c_str()});
  EXPECT_LT(found({"d"}).size(), 400U);
}

TEST_F(FindFrames, FindsParticlesInFolderWithoutVolumes) {
  make({"d/drops_1.ply", "d/drops_2.ply", "d/readme.txt"});
  EXPECT_EQ(found({"d"}), "1=d/drops_1.ply 2=d/drops_2.ply");
  EXPECT_EQ(
      find({"d"})->notes,
      (Notes{{NoteId::other_files,
              "d: the program takes 2 particle files (such as drops_1.ply) and skips 1 other file (readme.txt)"}}));
  make({"packed/peri_0.csv.gz", "packed/peri_100.csv.gz"});
  EXPECT_EQ(found({"packed"}), "0=packed/peri_0.csv.gz 100=packed/peri_100.csv.gz");
  make({"d/smoke_7.vdb"});
  EXPECT_EQ(found({"d"}), "7=d/smoke_7.vdb");
  EXPECT_EQ(
      find({"d"})->notes,
      (Notes{{NoteId::other_files,
              "d: the program takes 1 volume file (smoke_7.vdb) and skips 3 other files (such as drops_1.ply)"}}));
}

TEST_F(FindFrames, FailsForFolderOfOtherFiles) {
  make({"d/readme.txt"});
  EXPECT_EQ(found({"d"}), "2: d: no file in the folder has the extension of a volume, particle or mesh format");
}

TEST_F(FindFrames, FindsMeshesOfFolderWithoutVolumes) {
  make({"d/scan_1.stl", "d/scan_2.stl", "d/readme.txt"});
  EXPECT_EQ(found({"d"}), "1=d/scan_1.stl 2=d/scan_2.stl");
  EXPECT_EQ(find({"d"})->notes,
            (Notes{{NoteId::other_files,
                    "d: the program takes 2 mesh files (such as scan_1.stl) and skips 1 other file (readme.txt)"}}));
}

TEST_F(FindFrames, TreatsSingleInputAsFrame) {
  make({"f_0042.vdb"});
  EXPECT_EQ(found({"f_0042.vdb"}), "42=f_0042.vdb");
  EXPECT_EQ(found({"gone.vdb"}), "1=gone.vdb");
  EXPECT_EQ(found({"50%%.vdb"}), "50=50%%.vdb");
  EXPECT_EQ(found({"demo:sphere?size=64"}), "1=demo:sphere?size=64");
  EXPECT_EQ(found({"f_0042.vdb"}, "42"), "1: f_0042.vdb: expected a sequence for the frames 42, found one input");
  EXPECT_EQ(found({"a{}_{}.vdb"}), "1: a{}_{}.vdb: expected one placeholder of the frame number, found '{}' and '{}'");
}

TEST_F(FindFrames, NumbersDemoFieldByRange) {
  EXPECT_EQ(found({"demo:sphere?size={}"}, "16-48x16"),
            "16=demo:sphere?size=16 32=demo:sphere?size=32 48=demo:sphere?size=48");
  const auto frames = find({"demo:sphere?size={}"});
  ASSERT_FALSE(frames);
  EXPECT_EQ(frames.error().code, ErrorCode::usage);
  EXPECT_EQ(frames.error().hint, Hint(Remedy::give, Setting::frames));
}

TEST_F(FindFrames, FollowsLinks) {
  make({"real/x.vdb"});
  fs::create_directory("d");
  fs::create_symlink("../real/x.vdb", "d/f_1.vdb");
  fs::create_symlink("../real/gone.vdb", "d/f_2.vdb");
  fs::create_symlink("../real", "d/f_3.vdb");
  // Frame 2 links to a missing file, and fails when it is read.
  EXPECT_EQ(found({"d/f_{}.vdb"}), "1=d/f_1.vdb 2=d/f_2.vdb");
  EXPECT_EQ(found({"d"}), "1=d/f_1.vdb 2=d/f_2.vdb");
}

TEST_F(FindFrames, FindsManyFilesOnce) {
  constexpr int kFiles = 3000;
  fs::create_directory("d");
  for (int i = kFiles; i > 0; --i) test::write_bytes(fmt::format("d/f.{:04}.vdb", i), "");
  for (const std::string input : {"d", "d/f.{:04}.vdb"}) {
    const auto frames = find({input});
    ASSERT_TRUE(frames);
    ASSERT_EQ(frames->frames.size(), static_cast<std::size_t>(kFiles));
    EXPECT_EQ(frames->frames.back(), (Frame{kFiles, "d/f.3000.vdb", {}}));
    EXPECT_TRUE(frames->gaps.empty());
  }
}

}  // namespace
}  // namespace isoextract::batch
