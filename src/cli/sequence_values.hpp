// Values that all frames of a sequence share: the radius of particles, the spacing for spheres, the range of colors.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "base/context.hpp"
#include "base/error.hpp"
#include "cli/batch_plan.hpp"
#include "cli/messages.hpp"
#include "convert/conversion_job.hpp"

namespace isoextract::cli {

struct FrameSource {
  std::int64_t frame = 0;
  convert::SourceOptions source;
};

// A radius for all frames, and the frame that it comes from.
struct SequenceRadius {
  double radius = 0;
  std::int64_t frame = 0;

  // Returns a note with the value, the frame, and the options that change it.
  [[nodiscard]] std::string note() const;
};

inline constexpr std::size_t kFramesForRadius = 16;

// Returns the radius that fits the first frame with 50 particles or more, else the first frame with a radius. `frames`
// are the first kFramesForRadius frames of the sequence. Returns nullopt if a frame is not read as particles, or if
// the options or an attribute of the particles give the radius. Frames that cannot be read do not count: their
// conversion reports why. Fails with ErrorCode::cancelled only.
[[nodiscard]] Result<std::optional<SequenceRadius>> find_sequence_radius(std::span<const FrameSource> frames,
                                                                         const Context& context);

// Returns the smallest of the spacings that convert::find_sphere_spacing() chooses for `frames`, in world units, since
// all frames of a sequence share one grid. `frames` are the first kFramesForRadius frames. Returns nullopt if no frame
// has spheres with radii of their own, if the method makes no level set, or if the options give the radius, the cell
// size, the resolution or the voxel size. Frames that cannot be read do not count. Fails with ErrorCode::cancelled
// only.
[[nodiscard]] Result<std::optional<double>> find_sequence_spacing(std::span<const FrameSource> frames,
                                                                  const Context& context);

// Returns a note with the spacing and the option that changes it.
[[nodiscard]] std::string spacing_note(double spacing);

// Sets the radius of particles, the spacing for spheres and the range of colors in all jobs of a plan with several
// frames, unless the options give these values, and adds a note about each. For the range it reads the attribute of all
// frames, of other shards too: every shard and every later run with --resume has the same range. Shows progress.
//
// Frames that cannot be read do not count. Fails with ErrorCode::cancelled only.
[[nodiscard]] Result<void> find_sequence_values(const ConvertFlags& flags, BatchPlan& plan, const Messages& messages);

}  // namespace isoextract::cli
