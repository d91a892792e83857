// The frames of a batch on several ranks (base/ranks.hpp). Rank 0 hands out frames as ranks come free, and converts
// frames, too; the other ranks send their results to rank 0. Only rank 0 writes the manifest.
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
  Notes field_notes = {};                   // notes about fields since the last result that the rank sent
  bool empty_picture = false;
};

[[nodiscard]] std::string packed(const FinishedFrame& finished);
// Returns nullopt if the bytes have no valid record. Leaves row.frame, row.input and row.rank unset.
[[nodiscard]] std::optional<FinishedFrame> unpacked_frame(std::string_view bytes);

// The frames as rank 0 hands them out. A thread answers the other ranks.
class FrameDesk final : public FrameSource {
 public:
  // FrameDesk calls `begin` with the list index of each frame before another rank gets the frame. If `begin` returns
  // false, the desk hands out no more frames. FrameDesk calls `accept` with the result of each such frame. Both calls
  // come from the thread that answers the ranks.
  using Begin = std::function<bool(std::size_t place)>;
  using Accept = std::function<void(FinishedFrame)>;
  FrameDesk(Ranks& ranks, std::size_t count, Begin begin, Accept accept);
  ~FrameDesk() override;

  std::optional<std::size_t> next() override;
  // Hands out no more frames.
  void stop() { stops_ = true; }
  // Waits until all other ranks have ended, and returns how many seconds each worked. Fails with ErrorCode::unavailable
  // if a message is damaged or cannot be exchanged.
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
  std::map<int, double> done_;    // seconds worked by ranks that have ended; only thread_ uses it until thread_ ends
  std::optional<Error> failure_;  // of the thread; valid once it has ended
  std::jthread thread_;
};

// The frames as another rank gets them from rank 0.
class FramesOfDesk final : public FrameSource {
 public:
  explicit FramesOfDesk(Ranks& ranks) : ranks_(ranks) {}

  std::optional<std::size_t> next() override;
  // Sends the result of a frame to rank 0. Returns false if sending fails.
  [[nodiscard]] bool tell(const FinishedFrame& finished);
  // Tells rank 0 that this rank ends. Fails if this message or an earlier one could not be sent or received.
  [[nodiscard]] Result<void> finish(double seconds);

 private:
  void keep(const Error& error);

  Ranks& ranks_;
  std::mutex mutex_;
  std::optional<Error> failure_;
};

}  // namespace isoextract::batch
