// The frames of a batch on several ranks (base/ranks.hpp). Rank 0 hands them out as ranks come free, and converts
// frames itself; the other ranks send what came of theirs. Only rank 0 writes the manifest.
#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "base/error.hpp"
#include "base/note.hpp"
#include "base/ranks.hpp"
#include "batch/frame_record.hpp"
#include "batch/frame_table.hpp"
#include "batch/scheduler.hpp"

namespace isoextract::batch {

// A frame that was converted, or whose conversion failed.
struct FinishedFrame {
  std::size_t frame = 0;  // index in the batch
  FrameRow row;
  bool is_converted = false;                // the conversion succeeded, though its report may have failed
  std::optional<Error> error = {};          // of the conversion, the report or the record
  std::optional<FrameRecord> record = {};   // for the manifest
  std::vector<std::string> set_aside = {};  // new names of old meshes
  Notes notes = {};                         // of the conversion
  Notes field_notes = {};                   // notes about fields that no frame before had
  bool empty_picture = false;
};

[[nodiscard]] std::string packed(const FinishedFrame& finished);
// Returns nullopt for other bytes.
[[nodiscard]] std::optional<FinishedFrame> unpacked_frame(std::string_view bytes);

// The frames as rank 0 hands them out. A thread answers the other ranks.
class FrameDesk final : public FrameSource {
 public:
  // `begin` is called with the index in the list of each frame that another rank gets; if it returns false, no more
  // frames are handed out. `accept` is called with what comes of it. Both are called on the thread.
  using Begin = std::function<bool(std::size_t place)>;
  using Accept = std::function<void(FinishedFrame)>;
  FrameDesk(Ranks& ranks, std::size_t count, Begin begin, Accept accept);
  ~FrameDesk() override;

  std::optional<std::size_t> next() override;
  // Hands out no more frames.
  void stop() { stops_ = true; }
  // Waits until the other ranks have no more frames, and returns how many seconds each worked. Fails with
  // ErrorCode::unavailable.
  [[nodiscard]] Result<std::map<int, double>> finish();

 private:
  void answer();
  [[nodiscard]] Result<void> answer(const RankMessage& message);

  Ranks& ranks_;
  const std::size_t count_;
  Begin begin_;
  Accept accept_;
  std::atomic<std::size_t> next_{0};
  std::atomic<bool> stops_{false};
  std::map<int, double> done_;    // the seconds of ranks that have ended; only for the thread until it ends
  std::optional<Error> failure_;  // of the thread; valid once it has ended
  std::jthread thread_;
};

// The frames as another rank gets them from rank 0.
class FramesOfDesk final : public FrameSource {
 public:
  explicit FramesOfDesk(Ranks& ranks) : ranks_(ranks) {}

  std::optional<std::size_t> next() override;
  // Sends what came of a frame. Returns false if that failed.
  [[nodiscard]] bool tell(const FinishedFrame& finished);
  // Tells rank 0 that this rank ends. Fails if a message could not be sent or received.
  [[nodiscard]] Result<void> finish(double seconds);

 private:
  void keep(const Error& error);

  Ranks& ranks_;
  std::mutex mutex_;
  std::optional<Error> failure_;
};

}  // namespace isoextract::batch
