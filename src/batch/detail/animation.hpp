// The frames of a batch as one animated GLB: each is added when its turn comes, and what the file was made of is kept
// in the manifest, for all frames or for none.
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
  // Of the batch's animation, which outlives it. `largest_file` is for tests.
  Animation(const BatchJob& batch, const Context& context, std::uint64_t largest_file = mesh_io::kLargestGlb);

  // Whether it could be written, before any work. Fails with ErrorCode::usage or ErrorCode::output.
  [[nodiscard]] Result<void> check() const;

  // The frame's node is named after the file and the frame: water_0012.
  [[nodiscard]] Result<std::vector<mesh_io::PackedFacts>> take(std::size_t frame,
                                                               const convert::MeshCollector& collected) override;

  // Why nothing more can be written, where that is so: a full disk, for example. Then the failure of a frame is the
  // whole animation's. May be asked on any thread.
  [[nodiscard]] std::optional<Error> lost() const;

  // Gives the files their names. Call once, last. Where no frame came, because none has a surface, nothing is written,
  // an old file of that name is removed, and a note says so.
  [[nodiscard]] Result<mesh_io::MeshWriteResult> finish();

 private:
  const BatchJob& batch_;
  mesh_io::AnimationWriter writer_;
  bool is_empty_ = true;
  mutable std::mutex mutex_;  // of what follows
  std::optional<Error> lost_;
};

// Returns a note of the frames that failed, which are `missing` in the animation, in their order: which they are, and
// what is shown in their time.
[[nodiscard]] std::string left_out_text(const BatchJob& batch, std::span<const std::int64_t> missing);

// What the record of a whole animation has as its job, by the hash of its batch.
[[nodiscard]] std::string animation_key(const std::string& batch);

// Keeps in the manifest what a whole animation was made of: `frames` are the records of all its frames, in their order.
// A run that ends within leaves it as if nothing was kept.
[[nodiscard]] Result<void> keep_animation(Manifest& manifest, const BatchJob& batch, std::vector<FrameRecord> frames,
                                          const mesh_io::MeshWriteResult& written);

// The records of all frames where the manifest has the batch's animation, and its files and all inputs are what they
// were, byte by byte. Outputs of each are all files of the animation.
[[nodiscard]] std::optional<std::vector<FrameRecord>> kept_animation(const Manifest& manifest, const BatchJob& batch);

}  // namespace isoextract::batch
