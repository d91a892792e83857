// Conversions side by side, within one budget of memory and one number of threads. What comes out does not depend on
// how many run at a time. A GPU is opened once for all of them (convert::KeptBackends): while one frame is drawn,
// others are read, measured and written.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/context.hpp"
#include "batch/batch_job.hpp"
#include "convert/conversion.hpp"
#include "convert/mesh_collector.hpp"

namespace isoextract::batch {

struct SchedulerOptions {
  int jobs = 1;     // conversions at a time, at most
  int threads = 1;  // of all of them together; each conversion has its share, and more when few are left
  bool fail_fast = false;
  std::uint64_t memory_of_one = 0;  // what a conversion is thought to reserve, until some are measured; 0: not known
  convert::OutcomeExtras extras = {};
};

// Told by the threads that convert, side by side: who listens guards what it has. Every function does nothing unless it
// is overridden.
class FrameEvents {
 public:
  virtual ~FrameEvents() = default;

  // Before a frame is converted, with the context that it is converted in; for one that is repeated, twice. Returns who
  // hears of its stages, on the thread that converts it, until the frame has ended; null: nobody.
  virtual convert::Events* started(std::size_t /*frame*/, const Context& /*context*/) { return nullptr; }
  // Every frame that was started, once. False ends the batch as a failure does with fail_fast: what the listener keeps
  // of the frame could not be kept.
  virtual bool finished(std::size_t /*frame*/, const convert::Outcome& /*outcome*/) { return true; }
};

// Takes the meshes of frames, where they do not go to files of their own.
class FrameReceiver {
 public:
  virtual ~FrameReceiver() = default;

  // The surfaces of a frame, as they were collected, or none; not told of frames that fail. One frame at a time,
  // in the order of the frames, on the thread that converted it. A failure is the frame's. Gives what packing did to
  // each surface, or nothing where they are not packed.
  [[nodiscard]] virtual Result<std::vector<mesh_io::PackedFacts>> take(std::size_t frame,
                                                                       const convert::MeshCollector& collected) = 0;
};

struct BatchCounts {
  std::size_t done = 0;
  std::size_t failed = 0;
  std::size_t not_started = 0;  // because of a failure before, or because somebody wanted the end
  std::size_t repeated = 0;     // times that a frame was run again: it failed for want of memory beside others, or
                                // had to wait for one that did
};

// Runs `which` of the batch's frames, by index, in their order as far as memory lets them start. A frame starts where
// what it is thought to need (the most that one has reserved so far) is left beside those that run, and in any case
// where none runs. One that fails for want of memory beside others is run again alone, at the end. Where the context is
// asked to end no further frame starts.
//
// With a `receiver` no frame is written to files. A frame that is converted waits until those before it were taken, and
// holds its meshes, and its place among those that run, meanwhile: so there is one frame a job in memory, however many
// there are. One that fails has no turn. Where one fails for want of memory beside others, those that come after it
// are converted again as well, after it. Where the batch ends early, frames that wait fail with ErrorCode::cancelled.
BatchCounts run(const BatchJob& batch, std::span<const std::size_t> which, const SchedulerOptions& options,
                const Context& context, FrameEvents& events, FrameReceiver* receiver = nullptr);

}  // namespace isoextract::batch
