// A sequence of meshes as one GLB that plays: a node a frame, shown in its time only (write/animated_glb.hpp says how).
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

#include "base/context.hpp"
#include "base/error.hpp"
#include "mesh/mesh.hpp"
#include "mesh_io/mesh_writer.hpp"

namespace isoextract::mesh_io {

// What the container can be: its length is a number of 32 bits.
inline constexpr std::uint64_t kLargestGlb = 0xFFFFFFFF;

// Where a sequence has more than one file can hold, it goes on in others: water.glb, water.part2.glb, water.part3.glb.
[[nodiscard]] std::filesystem::path animation_part_path(const std::filesystem::path& path, std::size_t part);

// The time line. The first frame is at 0 seconds, whatever its number, and frame k at (k - first) / frames_per_second:
// gaps in the numbering keep their time. A frame is shown until the next one that is there, be it of the next number or
// after a gap, and the last one for the time of one frame, so that the animation loops evenly. A frame that is there
// but has no triangles shows nothing in its time. Frames of span() that are missing keep their time as well: nothing is
// shown before the first that is there, and the last one is shown until the end. The key of a frame is the largest
// float32 that is not after its time, so that players see it there, whichever way they round.
//
// Programs that do not play show the first frame that has triangles.
//
// Splitting. A frame that does not fit into a file begins the next one. All files keep the time line of the sequence
// and its length, and show their own frames only: opened together they play the whole. A note says what is where.
//
// Each frame goes to disk as it comes; about a kilobyte of it is kept in memory. Nothing has a name before finish(),
// where all files get theirs together, the first one last: a writer that goes without it leaves nothing behind.
// Standard output, pipes and devices are refused: what a GLB begins with is known at its end.
class AnimationWriter {
 public:
  // `frames_at_most` is how many may come: room is left for the descriptions of so many. More are no error; the file is
  // then copied once within itself. `largest_file` is for tests.
  AnimationWriter(const std::filesystem::path& path, const MeshWriteOptions& options, double frames_per_second,
                  std::uint64_t frames_at_most, const Context& context, std::uint64_t largest_file = kLargestGlb);
  AnimationWriter(AnimationWriter&&) noexcept;
  AnimationWriter& operator=(AnimationWriter&&) noexcept;
  ~AnimationWriter();

  // Makes the time line that of the frames from `first` to `last`, whichever of them come. Call before add().
  void span(std::int64_t first, std::int64_t last);

  // Whether there can be such a file, before anything is made for it. Fails with ErrorCode::usage, as add() and
  // finish() then do.
  [[nodiscard]] Result<void> check() const;

  // Whether frames of these numbers, which grow, could be told apart in time, were they the first that come: else
  // add() refuses some of them. Fails with ErrorCode::usage, naming the first.
  [[nodiscard]] Result<void> check_times(std::span<const std::int64_t> frames) const;

  // The surfaces of a frame, none of which is needed afterwards. Numbers grow from call to call. `name` is the node's;
  // where there are several surfaces, theirs are those of nodes below it. `packing` is the frame's: options.packing
  // does not count here, and its box must be there where positions are quantised. Frames share a lattice where
  // mesh_packing.hpp says so. Neither does options.placement: the file has that of the first frame, and a note tells
  // where others differ.
  //
  // A frame that cannot be written is refused with ErrorCode::output, and the rest may go on as if it had not come: one
  // whose numbers would destroy its triangles (write/written_places.hpp), that is larger than a file can be, or that is
  // so far from the first that float32 cannot tell its time from its neighbours'. So is a number that does not grow,
  // with ErrorCode::usage. After any other failure every later call fails alike.
  [[nodiscard]] Result<void> add(const std::string& name, std::int64_t frame, std::span<const mesh::Mesh> surfaces,
                                 const MeshPacking& packing = {}, const std::string& placement = {});
  [[nodiscard]] Result<void> add(const std::string& name, std::int64_t frame, const mesh::Mesh& surface);

  // What packing did to the surfaces of the last frame that was added, one each; nothing where they were not packed.
  [[nodiscard]] std::span<const PackedFacts> packed() const;

  // Whether a failure has ended it, so that every later call fails like that one: it was none of a single frame.
  [[nodiscard]] bool has_failed() const;

  // Gives all files their names. Call once, last. Fails with ErrorCode::output where no frame came.
  [[nodiscard]] Result<MeshWriteResult> finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace isoextract::mesh_io
