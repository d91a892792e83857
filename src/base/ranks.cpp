#include "base/ranks.hpp"

#include <utility>

#include <fmt/format.h>

#include "base/packed_values.hpp"
#include "base/stopwatch.hpp"

namespace isoextract {
namespace {

// The first byte of a rank's message to the other ranks.
enum class Turn : char {
  works,   // the bytes of gather() follow
  ends,    // the rank has ended without an error, or was cancelled
  failed,  // the rank's error follows
};

std::string packed(Turn turn, const Error* error) {
  Packer packer;
  packer.put(turn);
  if (error != nullptr) packer.put(*error);
  return packer.take();
}

}  // namespace

Result<std::vector<std::string>> Ranks::exchange(std::string_view bytes) {
  auto all = TRY(link_->gather(bytes));
  for (std::size_t r = 0; r < all.size(); ++r) {
    Unpacker from(all[r]);
    const auto turn = from.get<Turn>();
    if (turn != Turn::works) has_ended_ = true;
    if (turn != Turn::failed || static_cast<int>(r) == rank() || of_other_) continue;
    of_other_ = from.get<Error>();
    of_other_->message = fmt::format("rank {}: {}", r, of_other_->message);
  }
  return all;
}

Result<std::vector<std::string>> Ranks::gather(std::string_view bytes) {
  if (has_ended_) return leave_to_first_rank();
  const Stopwatch watch;
  auto all = TRY(exchange(packed(Turn::works, nullptr) + std::string(bytes)));
  waited_ += watch.elapsed().wall_seconds;
  if (has_ended_ && is_first()) {
    return tl::unexpected(of_other_.value_or(Error{ErrorCode::unavailable, "another rank ended early", {}}));
  }
  if (has_ended_) return leave_to_first_rank();
  for (std::string& one : all) one.erase(0, sizeof(Turn));
  return all;
}

std::optional<Error> Ranks::end(const Error* error) {
  const bool failed = error != nullptr && error->code != ErrorCode::cancelled;
  if (!has_ended_) {
    const auto told = exchange(packed(failed ? Turn::failed : Turn::ends, failed ? error : nullptr));
    if (!told && !of_other_) of_other_ = told.error();
  }
  link_->leave();
  return of_other_;
}

tl::unexpected<Error> leave_to_first_rank() { return fail(ErrorCode::cancelled, "rank 0 goes on alone"); }

}  // namespace isoextract
