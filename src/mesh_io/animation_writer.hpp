// Writes a sequence of meshes as one animated GLB: one node per frame, visible only during that frame's time
// (write/animated_glb.hpp explains how).
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

// The largest GLB in bytes: the container stores its length in 32 bits.
inline constexpr std::uint64_t kLargestGlb = 0xFFFFFFFF;

// Returns the path of a part of a sequence that is too large for one file. Parts count from 1:
// water.glb, water.part2.glb, water.part3.glb.
[[nodiscard]] std::filesystem::path path_of_animation_part(const std::filesystem::path& path, std::size_t part);

// Time line: frame k starts at (k - first) / frames_per_second seconds, where `first` is the number of the first frame
// added, or `first` of set_span(). Gaps in the numbering keep their time.
// A frame is shown until the next frame that was added, and the last one for 1 / frames_per_second seconds, so that the
// animation loops evenly. A frame without triangles shows nothing during its time.
// Missing frames of set_span() keep their time too: nothing is shown before the first frame that was added, and the
// last frame that was added is shown until the end. The file stores the start of a frame as the largest float32 that is
// not after it, so that a player that computes the time in double or float32 shows the frame from its start.
//
// Programs that do not play animations show the first frame that has triangles.
//
// Splitting: a frame that does not fit into the current file begins the next one. Every file has the time line and the
// length of the whole sequence and shows its own frames only, so the files opened together play the whole sequence.
// A note tells which frames each file holds.
//
// Each frame goes to disk when it is added; about one kilobyte of it stays in memory. finish() gives all files their
// names together, the first file last. A writer destroyed without finish() leaves no file behind.
// Standard output, pipes and devices are refused, because the writer completes the start of the file last.
class AnimationWriter {
 public:
  // `expected_frames` is the expected number of frames: the writer reserves space in the file for their JSON. More
  // frames are no error; the file's data is then moved once within the file.
  // `largest_file`, in bytes, exists for tests.
  AnimationWriter(const std::filesystem::path& path, const MeshWriteOptions& options, double frames_per_second,
                  std::uint64_t expected_frames, const Context& context, std::uint64_t largest_file = kLargestGlb);
  AnimationWriter(AnimationWriter&&) noexcept;
  AnimationWriter& operator=(AnimationWriter&&) noexcept;
  ~AnimationWriter();

  // Sets the time line to the frames `first` to `last`, whichever of them are added. Call before add().
  void set_span(std::int64_t first, std::int64_t last);

  // Sets the start of each frame in seconds; without this call, the frame's number gives its start. The last frame
  // still lasts 1 / frames_per_second. `frames` and `starts` ascend and have the same size. Call before add(), then add
  // only these frames.
  void set_starts(std::span<const std::int64_t> frames, std::span<const double> starts);

  // Checks the options before any file is created. Fails with ErrorCode::usage if the format is not binary GLB, the
  // frame rate is not a positive number, or the path is a stream; add() and finish() then fail alike.
  [[nodiscard]] Result<void> check() const;

  // Checks that float32 times can tell these frames apart; `frames` are ascending. Counts time from the first of them
  // and ignores set_span(). Fails with ErrorCode::usage and names the first frame that add() would refuse.
  [[nodiscard]] Result<void> check_times(std::span<const std::int64_t> frames) const;

  // Adds the surfaces of a frame; the caller may free them afterwards. `frame` must grow from call to call. `name`
  // becomes the node's name; several surfaces become child nodes with the names of their meshes.
  // `packing` replaces options.packing for this frame. If it quantizes positions, its box must be set. mesh_packing.hpp
  // tells when frames share a lattice.
  // `placement` replaces options.placement: all files store the placement of the first frame, and a note tells if later
  // frames have another one.
  //
  // Refuses a frame with ErrorCode::output if its rounded coordinates would destroy triangles
  // (write/coordinate_rounding.hpp), if the frame is larger than a file can be, or if float32 cannot tell its time from
  // its neighbors'. Refuses a frame number that does not grow, and a missing box, with ErrorCode::usage. If packing or
  // reordering the frame fails (memory is short, a vertex is outside of the box), refuses it with that error.
  // Other frames can follow a refused one. After any other failure every later call fails alike; see has_failed().
  [[nodiscard]] Result<void> add(const std::string& name, std::int64_t frame, std::span<const mesh::Mesh> surfaces,
                                 const MeshPacking& packing = {}, const std::string& placement = {});
  [[nodiscard]] Result<void> add(const std::string& name, std::int64_t frame, const mesh::Mesh& surface);

  // Returns what packing did to each surface of the last frame added, with default values for a surface that packing
  // left as it is. Empty if no packing was requested, if the frame has no triangles, or if add() refused it.
  [[nodiscard]] std::span<const PackedFacts> packed() const;

  // Returns whether an earlier failure ended the whole file, so that every later call fails alike. Refusing one frame
  // does not count.
  [[nodiscard]] bool has_failed() const;

  // Completes all files and gives them their names. Call once, last. Fails with ErrorCode::output if no frame was
  // added.
  [[nodiscard]] Result<MeshWriteResult> finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace isoextract::mesh_io
