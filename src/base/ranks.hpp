// Ranks: the processes of one run that a launcher such as mpirun started, on one or more machines. All have the same
// command line, and see the same files. Only rank 0 prints.
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.hpp"

namespace isoextract {

struct RankMessage {
  int from = 0;
  std::string bytes;
};

// The connection between the ranks. Its functions fail with ErrorCode::unavailable.
class RankLink {
 public:
  RankLink() = default;
  RankLink(const RankLink&) = delete;
  RankLink& operator=(const RankLink&) = delete;
  virtual ~RankLink() = default;

  [[nodiscard]] virtual int rank() const = 0;
  [[nodiscard]] virtual int size() const = 0;
  [[nodiscard]] virtual int node() const = 0;  // the least rank on this machine
  // Returns the bytes of all ranks, by rank. Waits until every rank has called it.
  [[nodiscard]] virtual Result<std::vector<std::string>> gather(std::string_view bytes) = 0;
  [[nodiscard]] virtual Result<void> send(int to, std::string_view bytes) = 0;
  // Returns the next message of any rank, or nullopt if none comes within `most`.
  [[nodiscard]] virtual Result<std::optional<RankMessage>> receive(std::chrono::milliseconds most) = 0;
  // Waits until every rank calls it, and ends the connection.
  virtual void leave() = 0;
};

class Ranks {
 public:
  explicit Ranks(std::unique_ptr<RankLink> link) : link_(std::move(link)) {}

  [[nodiscard]] int rank() const { return link_->rank(); }
  [[nodiscard]] int size() const { return link_->size(); }
  [[nodiscard]] int node() const { return link_->node(); }
  [[nodiscard]] bool is_first() const { return rank() == 0; }

  // Returns the bytes of all ranks, by rank. Waits until every rank has called it. All ranks make the same calls in the
  // same order. Once a rank calls end(), the next gather() of every other rank fails: at rank 0 with the error given to
  // end() (ErrorCode::unavailable if there is none), at other ranks with ErrorCode::cancelled.
  [[nodiscard]] Result<std::vector<std::string>> gather(std::string_view bytes);

  // Sends a message to one rank.
  [[nodiscard]] Result<void> send(int to, std::string_view bytes) { return link_->send(to, bytes); }
  // Returns the next message of any rank, or nullopt if none comes within `most`.
  [[nodiscard]] Result<std::optional<RankMessage>> receive(std::chrono::milliseconds most) {
    return link_->receive(most);
  }

  // Ends the common work of this rank: waits until all other ranks end, too. `error` is set if this rank failed.
  // Returns the first error of another rank, with the number of that rank, or the error of the connection. Call once,
  // last.
  [[nodiscard]] std::optional<Error> end(const Error* error);

  // Ends the sharing of a task: rank 0 does the task alone, and the other ranks end. Every rank must come to the same
  // decision. `why` completes "rank 0 works alone, because ...".
  void work_alone(std::string why) { why_alone_ = std::move(why); }
  [[nodiscard]] bool is_shared() const { return why_alone_.empty(); }
  [[nodiscard]] const std::string& why_alone() const { return why_alone_; }

  // Returns the seconds that this rank has waited in gather().
  [[nodiscard]] double waited() const { return waited_; }

 private:
  [[nodiscard]] Result<std::vector<std::string>> exchange(std::string_view bytes);

  std::unique_ptr<RankLink> link_;
  std::string why_alone_;
  double waited_ = 0;
  bool has_ended_ = false;         // a rank has called end()
  std::optional<Error> of_other_;  // the first error that another rank gave to end()
};

// Returns the error with which a rank other than 0 leaves work to rank 0. end() does not pass this error on.
[[nodiscard]] tl::unexpected<Error> leave_to_first_rank();

}  // namespace isoextract
