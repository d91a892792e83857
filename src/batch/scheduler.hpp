// Runs conversions side by side within one memory budget and one number of threads. The results do not depend on how
// many run at a time. One GPU device serves all conversions (convert::BackendCache): while it extracts one frame, other
// frames are read, measured and written.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "base/context.hpp"
#include "batch/batch_job.hpp"
#include "convert/conversion.hpp"
#include "convert/mesh_collector.hpp"

namespace isoextract::batch {

// Returns the threads of a conversion if `at_once` of them share `threads`.
[[nodiscard]] inline int threads_of_one(int threads, std::size_t at_once) {
  return std::max(1, threads / static_cast<int>(std::max<std::size_t>(at_once, 1)));
}

struct SchedulerOptions {
  int jobs = 1;            // largest number of conversions at a time
  int threads = 1;         // in all; conversions share them, and get more when few conversions are left
  bool fail_fast = false;  // the first frame that fails cancels the running frames, and no other starts
  // Estimated reservation of one conversion, in bytes. Only a larger measured reservation replaces it. 0: unknown.
  std::uint64_t memory_per_frame = 0;
  convert::ConversionOptions extras = {};
};

// Events of frames; they do nothing unless overridden. The converting threads call them concurrently, so a listener
// must guard its data.
class FrameEvents {
 public:
  virtual ~FrameEvents() = default;

  // Called before a frame is converted, with its context; again if the frame is repeated. Returns the listener of the
  // frame's stages, used on the converting thread until the frame ends, or null.
  virtual convert::Events* started(std::size_t /*frame*/, const Context& /*context*/) { return nullptr; }
  // Called once for every frame that was started, except for a frame that still waits to be repeated when the batch
  // ends. A listener returns false if it could not write the frame's record. That ends the batch in the same way as a
  // failed frame with fail_fast. It may move parts out of the outcome.
  virtual bool finished(std::size_t /*frame*/, convert::Outcome& /*outcome*/) { return true; }
};

// Receives the meshes of frames that do not get files of their own.
class FrameReceiver {
 public:
  virtual ~FrameReceiver() = default;

  // Receives the collected surfaces of a frame, possibly none; frames that fail are not received. Frames arrive one at
  // a time, in order, on the thread that converted them. If take() fails, the frame fails with that error. Returns the
  // packing figures of each surface, or an empty list if surfaces are not packed.
  [[nodiscard]] virtual Result<std::vector<mesh_io::PackedFacts>> take(std::size_t frame,
                                                                       const convert::MeshCollector& collected) = 0;
};

// Hands out frames one by one, so that several schedulers share them.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  // Returns an index into `which` of run(), or nullopt if no frame is left. One scheduler makes no concurrent calls.
  [[nodiscard]] virtual std::optional<std::size_t> next() = 0;
};

struct BatchCounts {
  std::size_t done = 0;
  std::size_t failed = 0;
  std::size_t not_started = 0;  // or still to be repeated, when a failure or a request ended the batch
  // Repeated runs: the frame ran out of memory beside other frames, or had to free its meshes for such a frame.
  std::size_t repeated = 0;
};

// Runs the batch's frames with the indices `which`, in order as far as memory allows. A frame starts if its estimated
// memory (memory_per_frame, or the largest reservation so far if that is larger) fits into the limit of
// Context::memory() beside the running frames, or if none is running. A frame that ran out of memory beside others runs
// again alone, at the end. If the context is cancelled, no further frame starts.
//
// With a `receiver`, writes no frame to files. A converted frame waits until all earlier frames were taken; meanwhile
// it keeps its meshes and its slot, so memory holds at most one frame for each job. A frame that fails is not waited
// for. If a frame runs out of memory beside others, it and all later unfinished frames run again. If the batch ends
// early, waiting frames fail with ErrorCode::cancelled.
//
// With a `source`, runs only the frames of `which` that the source hands out, and asks it whenever a frame may start. A
// source excludes a receiver.
BatchCounts run(const BatchJob& batch, std::span<const std::size_t> which, const SchedulerOptions& options,
                const Context& context, FrameEvents& events, FrameReceiver* receiver = nullptr,
                FrameSource* source = nullptr);

}  // namespace isoextract::batch
