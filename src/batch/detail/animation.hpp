// Writes the frames of a batch in order into one animated GLB, or into several if one would exceed 4 GiB. The manifest
// records all frames of the animation or none.
#pragma once

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "batch/batch_job.hpp"
#include "batch/frame_record.hpp"
#include "batch/manifest.hpp"
#include "batch/scheduler.hpp"
#include "mesh_io/animation_writer.hpp"

namespace isoextract::batch {

class Animation final : public FrameReceiver {
 public:
  // `batch` must have an animation and outlive this object. `largest_file` is for tests.
  Animation(const BatchJob& batch, const Context& context, std::uint64_t largest_file = mesh_io::kLargestGlb);

  // Checks before any work that the file can be written. Fails with ErrorCode::usage or ErrorCode::output.
  [[nodiscard]] Result<void> check() const;

  // Adds a frame. Its node is named after the file and the frame: water_0012.
  [[nodiscard]] Result<std::vector<mesh_io::PackedFacts>> take(std::size_t frame,
                                                               const convert::MeshCollector& collected) override;

  // Returns the error after which nothing more can be written, such as a full disk, or nullopt. The whole animation has
  // then failed, not only a frame. Safe to call on any thread.
  [[nodiscard]] std::optional<Error> lost() const;

  // Finishes the files and gives them their names. Call once, last. If no frame has a surface, writes nothing, removes
  // an old file of that name, and returns a note.
  [[nodiscard]] Result<mesh_io::MeshWriteResult> finish();

 private:
  const BatchJob& batch_;
  mesh_io::AnimationWriter writer_;
  bool is_empty_ = true;
  mutable std::mutex mutex_;  // guards the member below
  std::optional<Error> lost_;
};

// Returns a note that lists the failed frames and says what the animation shows during their time. `missing` has the
// numbers of these frames, ascending.
[[nodiscard]] std::string missing_frames_note(const BatchJob& batch, std::span<const std::int64_t> missing);

// Returns the manifest key of a whole animation. `batch` is the hash of the animation's batch (hash_of()).
[[nodiscard]] std::string animation_key(const std::string& batch);

// Records in the manifest what the animation was made from. `frames` are the records of all its frames, in order. If
// the run is killed meanwhile, nothing counts as recorded.
[[nodiscard]] Result<void> record_animation(Manifest& manifest, const BatchJob& batch, std::vector<FrameRecord> frames,
                                            const mesh_io::MeshWriteResult& written);

// Returns the records of all frames if the manifest has the batch's animation, no file of the animation and no input
// has changed (changed_file_message()), and no input was added; else nullopt. Each record lists the animation's files.
[[nodiscard]] std::optional<std::vector<FrameRecord>> find_animation_record(const Manifest& manifest,
                                                                            const BatchJob& batch);

}  // namespace isoextract::batch
