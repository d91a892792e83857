// Tests files with several frames: incomplete ones, steps and times, compressed files.
#include <chrono>
#include <functional>
#include <set>
#include <thread>

#include "files/parked_streams.hpp"
#include "unit/particle_io/particle_files.hpp"

namespace isoextract::test {
namespace {

using particle_io::FrameTime;

struct Trajectory {
  std::string name;
  std::function<std::string(int)> frame;  // two particles, the second one at (2, 2, 2 + number)
  // How many characters may be missing at the end of a frame that counts as whole.
  std::set<std::size_t> missing = {0, 1};
};

std::vector<Trajectory> trajectories() {
  return {
      {"a.xyz",
       [](int k) { return fmt::format("2\nProperties=pos:R:3 Time=0.{0} step={0}00\n1 1 1\n2 2 {1}\n", k, 2 + k); }},
      {"b.xyz", [](int k) { return fmt::format("2\nframe\nH 1 1 1\nO 2 2 {}\n", 2 + k); }},
      {"a.dump",
       [](int k) {
         return fmt::format(
             "ITEM: TIMESTEP\n{0}00\nITEM: TIME\n0.{0}\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS pp pp pp\n0 9\n0 9\n"
             "0 9\nITEM: ATOMS id x y z\n1 1 1 1\n2 2 2 {1}\n",
             k, 2 + k);
       }},
      {"a.gro",
       [](int k) {
         return fmt::format(
             "Water t= 0.{0} step= {0}00\n    2\n    1SOL     OW    1   1.000   1.000   1.000\n"
             "    1SOL     OW    2   2.000   2.000   {1}.000\n9 9 9\n",
             k, 2 + k);
       }},
      {"a.pdb",
       [](int k) {
         return fmt::format(
             "MODEL        {}\nATOM      1  N   ALA A   1       1.000   1.000   1.000\n"
             "ATOM      2  N   ALA A   1       2.000   2.000   {}.000\nENDMDL\n",
             k + 1, 2 + k);
       },
       {0, 1, std::string_view("MDL\n").size()}}};  // END ends a frame, too
}

std::string frames_text(const Trajectory& of, int count) {
  std::string text;
  for (int k = 0; k < count; ++k) text += of.frame(k);
  return text;
}

std::vector<std::string> texts_of(const Notes& notes) {
  std::vector<std::string> texts;
  for (const Note& note : notes) {
    if (note.id == NoteId::incomplete_frame) texts.push_back(note.text);
  }
  return texts;
}

TEST(ParticleFrames, UsesTheWholeFramesOfATruncatedFile) {
  for (const Trajectory& one : trajectories()) {
    const std::string whole = frames_text(one, 2);
    const std::string last = one.frame(2);
    for (std::size_t length = 0; length <= last.size(); ++length) {
      SCOPED_TRACE(fmt::format("{}: {} bytes of the last frame", one.name, length));
      const ParticleInput input{one.name, whole + last.substr(0, length)};
      const particle_io::ParticleInfo info = must_inform(input);
      const bool is_whole = one.missing.contains(last.size() - length);
      const bool begins_unseen = one.name == "a.pdb" && length < std::string_view("MODEL").size();
      ASSERT_EQ(info.frames, is_whole ? 3U : 2U);
      const bool has_open_line = is_whole && length < last.size() && one.name.find(".gro") == std::string::npos &&
                                 one.name.find(".pdb") == std::string::npos;
      const bool is_noted = has_open_line || (!is_whole && length > 0 && !begins_unseen);
      ASSERT_EQ(texts_of(info.notes).size(), is_noted ? 1U : 0U);
      expect_positions(must_read_particles(input, of_frame(1)).particles, {{1, 1, 1}, {2, 2, 3}});
      if (is_whole) {
        expect_positions(must_read_particles(input, of_frame(2)).particles, {{1, 1, 1}, {2, 2, 4}});
      } else {
        const std::string refused = particle_refusal(input, of_frame(2)).message;
        expect_in(refused, is_noted ? "frame 2 is incomplete" : "there is no frame 2");
        expect_in(particle_refusal(input, of_frame(3)).message, "there is no frame 3");
      }
    }
  }
}

TEST(ParticleFrames, NotesParticlesOfAnIncompleteLastFrame) {
  const auto notes_of = [](const std::string& name, const std::string& text) {
    return texts_of(must_inform({name, text}).notes);
  };
  std::string rows;
  for (int i = 0; i < 1000; ++i) rows += "H 1 2 3\n";
  const std::string frame = "1000\n\n" + rows;
  const auto found = notes_of("a.xyz", frame + frame.substr(0, frame.size() - 8 * 188));
  ASSERT_EQ(found.size(), 1U);
  expect_in(found[0], "the last frame (1) of ");
  expect_in(found[0], "a.xyz is incomplete: 812 of 1,000 particles; the reader uses the frame before it");
  // A last line that is cut off counts as missing.
  expect_in(notes_of("a.xyz", frame + frame + frame.substr(0, frame.size() - 3)).at(0), "(2) of ");
  expect_in(notes_of("a.xyz", frame + frame.substr(0, frame.size() - 3)).at(0), "999 of 1,000 particles");
  expect_in(notes_of("a.xyz", frame + "1000\n").at(0), "the file ends in its header");
  expect_in(notes_of("a.xyz", frame + frame.substr(0, frame.size() - 1)).at(0), "has no line end");
  // One whole frame needs no selection.
  const particle_io::ParticleFile read = must_read_particles({"a.xyz", frame + "1000\n"});
  EXPECT_EQ(read.particles.size(), 1000U);
  EXPECT_EQ(texts_of(read.notes).size(), 1U);
}

TEST(ParticleFrames, RefusesAFileWhoseOnlyFrameIsTruncated) {
  for (const Trajectory& one : trajectories()) {
    if (one.name == "a.pdb") continue;  // a single frame needs no end
    SCOPED_TRACE(one.name);
    const std::string frame = one.frame(0);
    const ParticleInput input{one.name, frame.substr(0, frame.size() - 3)};
    expect_in(particle_refusal(input).message, "");
    expect_in(particle_refusal(input, of_frame(0)).message, "");
    const TempFolder folder;
    write_bytes(folder / input.name, input.bytes);
    EXPECT_FALSE(particle_io::list_particles((folder / input.name).string(), {}, Context()));
  }
}

TEST(ParticleFrames, ReadsStepsAndTimes) {
  for (const Trajectory& one : trajectories()) {
    SCOPED_TRACE(one.name);
    const ParticleInput input{one.name, frames_text(one, 3)};
    std::vector<FrameTime> expected{{0, 0.0}, {100, 0.1}, {200, 0.2}};
    if (one.name == "b.xyz") expected.assign(3, {});
    if (one.name == "a.pdb") expected.clear();
    EXPECT_EQ(must_inform(input).times, expected);
    if (expected.empty()) continue;
    EXPECT_EQ(must_read_particles(input, of_frame(2)).time, expected[2]);
    const TempFolder folder;
    write_bytes(folder / input.name, input.bytes);
    const auto time = particle_io::find_frame_time((folder / input.name).string(), of_frame(1), Context());
    ASSERT_TRUE(time);
    EXPECT_EQ(*time, expected[1]);
  }
  const auto time_of = [](const std::string& comment) {
    return must_inform({"a.xyz", "1\n" + comment + "\n1 2 3\n"}).times.at(0);
  };
  EXPECT_EQ(time_of("time=2.5 Timestep=7"), (FrameTime{7, 2.5}));
  EXPECT_EQ(time_of("Time=nan step=-1"), FrameTime());
  EXPECT_EQ(time_of("Time=1e999 step=1.5"), FrameTime());
  EXPECT_EQ(time_of("step=99999999999999999999"), FrameTime());
}

// Digits without a pattern, so that the compressed file stays long.
std::string digits(std::size_t count, std::uint32_t& state) {
  std::string text;
  for (std::size_t i = 0; i < count; ++i) {
    state = state * 1664525U + 1013904223U;
    text += static_cast<char>('0' + (state >> 24) % 10);
  }
  return text;
}

// Reads all frames one after another and returns the compressed bytes that this read from the file.
std::uint64_t bytes_read_of_all(const std::string& path, std::int64_t frames, bool keeps_streams,
                                std::vector<glm::dvec3>& firsts) {
  const Context context;
  std::optional<files::StreamKeeper> keeper;
  if (keeps_streams) keeper.emplace(context, 1);
  std::uint64_t bytes = 0;
  for (std::int64_t k = 0; k < frames; ++k) {
    const Context part = context.part();
    const auto read = particle_io::read_particles(path, of_frame(k), part);
    if (!read) throw std::runtime_error(read.error().message);
    firsts.push_back(read->particles.positions[0]);
    bytes += part.counters().bytes_read;
  }
  return bytes;
}

// Returns frame `k` of 4000 particles at (k, 1, 2) as the format of this file name has it.
std::string long_frame(const std::string& name, std::int64_t k, std::uint32_t& state) {
  constexpr int kAtoms = 4000;
  const auto x = static_cast<double>(k);
  std::string text;
  if (name == "a.xyz") text = fmt::format("{}\n\n", kAtoms);
  if (name == "a.gro") text = fmt::format("t= {}\n{}\n", k, kAtoms);
  if (name == "a.pdb") text = fmt::format("MODEL {}\n", k + 1);
  if (name == "a.dump") {
    text = fmt::format("ITEM: TIMESTEP\n{}\nITEM: NUMBER OF ATOMS\n{}\nITEM: ATOMS type x y z id\n", k, kAtoms);
  }
  for (int i = 0; i < kAtoms; ++i) {
    const std::string more = digits(12, state);
    if (name == "a.xyz" || name == "a.dump") text += fmt::format("7 {} 1 2 {}\n", k, more);
    if (name == "a.gro") text += fmt::format("    1SOL     OW    1{:8.3f}   1.000   2.000{}\n", x, more);
    if (name == "a.pdb") text += fmt::format("ATOM      1  N   ALA A   1    {:8.3f}   1.000   2.000 {}\n", x, more);
  }
  if (name == "a.gro") text += "9 9 9\n";
  if (name == "a.pdb") text += "ENDMDL\n";
  return text;
}

TEST(ParticleFrames, InflatesACompressedFileOnce) {
  constexpr std::int64_t kFrames = 24;
  const TempFolder folder;
  std::uint32_t state = 1;
  for (const std::string name : {"a.xyz", "a.dump", "a.gro", "a.pdb"}) {
    SCOPED_TRACE(name);
    std::string text;
    std::vector<glm::dvec3> expected;
    for (std::int64_t k = 0; k < kFrames; ++k) {
      text += long_frame(name, k, state);
      expected.emplace_back(static_cast<double>(k), 1, 2);
    }
    const std::string packed = gzip(text);
    ASSERT_GT(packed.size(), std::size_t{500'000});
    write_bytes(folder / (name + ".gz"), packed);
    const std::string path = (folder / (name + ".gz")).string();
    std::this_thread::sleep_for(std::chrono::milliseconds(200));  // until the positions of frames can be remembered
    std::vector<glm::dvec3> found;
    const std::uint64_t once = bytes_read_of_all(path, kFrames, true, found);
    EXPECT_EQ(found, expected);
    // Each frame reads the start of the file to find out its format, and goes on with at most one block.
    EXPECT_LT(once, packed.size() * 3 + kFrames * (std::uint64_t{1} << 17));
    std::vector<glm::dvec3> again;
    const std::uint64_t often = bytes_read_of_all(path, kFrames, false, again);
    EXPECT_EQ(again, expected);
    EXPECT_GT(often, packed.size() * kFrames / 3);
    // Frames in any order have the same contents.
    const Context context;
    const files::StreamKeeper keeper(context, 2);
    for (const std::int64_t k : {5, 2, 23, 2, 3, 0}) {
      const auto read = particle_io::read_particles(path, of_frame(k), context.part());
      ASSERT_TRUE(read);
      EXPECT_EQ(read->particles.positions[0], expected[static_cast<std::size_t>(k)]) << k;
    }
  }
}

TEST(ParticleFrames, UsesTheWholeFramesOfATruncatedGzipFile) {
  std::string text;
  std::uint32_t state = 1;
  for (int k = 0; k < 8; ++k) {
    text += "200\n\n";
    for (int i = 0; i < 200; ++i) text += fmt::format("{} 0.{} 0.{}\n", k, digits(8, state), digits(8, state));
  }
  const std::string packed = gzip(text);
  const ParticleInput cut{"a.xyz.gz", packed.substr(0, packed.size() / 2)};
  const particle_io::ParticleInfo info = must_inform(cut);
  EXPECT_GE(info.frames, 3U);
  EXPECT_LT(info.frames, 5U);
  ASSERT_EQ(texts_of(info.notes).size(), 1U);
  EXPECT_EQ(must_read_particles(cut, of_frame(2)).particles.positions[199].x, 2);
  expect_in(particle_refusal(cut, of_frame(static_cast<std::int64_t>(info.frames))).message, "is incomplete");
  expect_in(particle_refusal({"a.xyz.gz", packed.substr(0, 100)}).message, "the gzip data is damaged or cut off");
}

std::string npy_frames(std::size_t frames, std::size_t particles) {
  std::string data;
  for (std::size_t f = 0; f < frames; ++f) {
    for (std::size_t p = 0; p < particles; ++p) {
      for (int axis = 0; axis < 3; ++axis) data += pack(static_cast<double>(100 * f + 10 * p) + axis);
    }
  }
  return data;
}

TEST(ParticleFrames, ReadsFramesOfNumPyArrays) {
  const std::string data = npy_frames(4, 2);
  const ParticleInput input{"a.npy", npy_bytes("'<f8'", "(4, 2, 3)", data)};
  EXPECT_EQ(must_inform(input).frames, 4U);
  EXPECT_EQ(must_inform(input, of_frame(3)).particles, 2U);
  for (const std::int64_t k : {0, 3, 1}) {
    const double x = 100.0 * static_cast<double>(k);
    expect_positions(must_read_particles(input, of_frame(k)).particles, {{x, x + 1, x + 2}, {x + 10, x + 11, x + 12}});
  }
  expect_in(particle_refusal(input).message, "there are 4 frames in the file, from 0 to 3");
  expect_in(particle_refusal(input, of_frame(4)).message, "there is no frame 4");
  // A frame depends on the header and on its own bytes.
  const TempFolder folder;
  write_bytes(folder / "a.npy", input.bytes);
  const auto part = particle_io::find_frame_part((folder / "a.npy").string(), of_frame(2), Context());
  ASSERT_TRUE(part);
  const std::uint64_t header = input.bytes.size() - data.size();
  EXPECT_EQ(part->ranges, (std::vector<files::ByteRange>{{0, header}, {header + 2 * 48, 48}}));
}

TEST(ParticleFrames, ReadsOnlyTheBytesOfANumPyFrame) {
  constexpr std::size_t kParticles = 100'000;
  const TempFolder folder;
  write_bytes(folder / "a.npy", npy_bytes("'<f8'", "(6, 100000, 3)", npy_frames(6, kParticles)));
  const Context context;
  const auto read = particle_io::read_particles((folder / "a.npy").string(), of_frame(4), context);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->particles.positions[kParticles - 1].x, 400.0 + 10.0 * (kParticles - 1));
  EXPECT_LT(context.counters().bytes_read, kParticles * 24 + (std::uint64_t{3} << 20));
}

TEST(ParticleFrames, RefusesInvalidNumPyArrays) {
  const std::string data = npy_frames(4, 2);
  const auto message = [&](const std::string& shape, const std::string& bytes, bool fortran = false) {
    return particle_refusal({"a.npy", npy_bytes("'<f8'", shape, bytes, fortran)}, of_frame(0)).message;
  };
  expect_in(message("(4, 2, 3)", data, true), "found an array in Fortran order");
  expect_in(message("(4, 2, 3)", data + "x"), "found 1 more bytes");
  expect_in(message("(0, 2, 3)", ""), "found an array without frames");
  expect_in(message("(4, 2, 3)", data.substr(0, 40)), "2 particles or entries need at least 48 bytes");
  expect_in(message("(4, 6148914691236517205, 3)", data), "2^64 bytes");
  const ParticleInput cut{"a.npy", npy_bytes("'<f8'", "(1152921504606846976, 2, 3)", data.substr(0, 3 * 48 - 1))};
  const particle_io::ParticleInfo info = must_inform(cut);
  EXPECT_EQ(info.frames, 2U);
  ASSERT_EQ(texts_of(info.notes).size(), 1U);
  expect_in(info.notes[0].text, "ends within frame 2 of 1152921504606846976");
  expect_positions(must_read_particles(cut, of_frame(1)).particles, {{100, 101, 102}, {110, 111, 112}});
  expect_in(particle_refusal(cut, of_frame(2)).message, "there is no frame 2");
}

}  // namespace
}  // namespace isoextract::test
