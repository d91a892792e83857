// Conversions side by side, within one budget of memory and one number of threads. What comes out does not depend on
// how many run at a time. A GPU is opened once for all of them (convert::KeptBackends): while one frame is drawn,
// others are read, measured and written.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "base/context.hpp"
#include "batch/batch_job.hpp"
#include "convert/conversion.hpp"

namespace isoextract::batch {

struct SchedulerOptions {
  int jobs = 1;     // conversions at a time, at most
  int threads = 1;  // of all of them together; each conversion has its share, and more when few are left
  bool fail_fast = false;
  std::uint64_t memory_of_one = 0;  // what a conversion is thought to reserve, until some are measured; 0: not known
  bool mesh_facts = false;          // Outcome::meshes
};

// Told by the threads that convert, side by side: who listens guards what it has. Every function does nothing unless it
// is overridden.
class FrameEvents {
 public:
  virtual ~FrameEvents() = default;

  // Before a frame is converted; for one that is repeated, twice.
  virtual void started(std::size_t /*frame*/) {}
  // Every frame that was started, once. False ends the batch as a failure does with fail_fast: what the listener keeps
  // of the frame could not be kept.
  virtual bool finished(std::size_t /*frame*/, const convert::Outcome& /*outcome*/) { return true; }
};

struct BatchCounts {
  std::size_t done = 0;
  std::size_t failed = 0;
  std::size_t not_started = 0;  // because of a failure before, or because somebody wanted the end
  std::size_t repeated = 0;     // that failed for want of memory beside others, and were run again alone
};

// Runs `which` of the batch's frames, by index, in their order as far as memory lets them start. A frame starts where
// what it is thought to need (the most that one has reserved so far) is left beside those that run, and in any case
// where none runs. One that fails for want of memory beside others is run again alone, at the end. Where the context is
// asked to end no further frame starts.
[[nodiscard]] BatchCounts run(const BatchJob& batch, std::span<const std::size_t> which,
                              const SchedulerOptions& options, const Context& context, FrameEvents& events);

}  // namespace isoextract::batch
