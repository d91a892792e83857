// A limit for the memory of all work that runs at the same time. Code reserves large memory before it allocates it, and
// holds the reservation as long as the memory lives.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "base/error.hpp"

namespace isoextract {

// Returns the bytes that this process may use: the physical memory, or the lowest limit of its control groups (v1 or
// v2) if that is lower. The first call reads them; later calls return the same number.
[[nodiscard]] std::uint64_t available_memory();

namespace detail {
struct MemoryAccount;
}

// A reserved part of the budget; the destructor gives it back. Movable; a moved-from reservation holds nothing. It may
// outlive its MemoryBudget.
class [[nodiscard]] Reservation {
 public:
  Reservation() = default;
  Reservation(Reservation&& other) noexcept;
  Reservation& operator=(Reservation&& other) noexcept;
  ~Reservation() { release(); }

  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }
  void release();
  // Reduces the reservation to `bytes`. Does nothing if the reservation is not larger.
  void shrink(std::uint64_t bytes);
  // Moves the bytes of `other` here. Two reservations with bytes must be of one account (a part() has its own).
  void take(Reservation&& other);

 private:
  friend class MemoryBudget;
  Reservation(std::shared_ptr<detail::MemoryAccount> account, std::uint64_t bytes);

  std::shared_ptr<detail::MemoryAccount> account_;
  std::uint64_t bytes_ = 0;
};

// A handle: copies share one account. Safe to use from several threads.
class MemoryBudget {
 public:
  explicit MemoryBudget(std::uint64_t limit_bytes = available_memory());

  // Returns an account within this budget: its reservations count here as well, and it records a peak of its own. Each
  // conversion of a batch has one.
  [[nodiscard]] MemoryBudget part() const;

  // Fails with ErrorCode::out_of_memory and the hint to raise the limit if `bytes` exceed the memory left. `what`
  // starts the message, for example "in.nrrd: 4096x4096x4096 f32 samples". On success, frees the blocks that Buffer
  // keeps for reuse until they fit into the memory left after the reservation.
  [[nodiscard]] Result<Reservation> reserve(std::uint64_t bytes, const std::string& what) const;

  [[nodiscard]] std::uint64_t limit() const;
  [[nodiscard]] std::uint64_t left() const;      // bytes of the limit that no account has reserved now
  [[nodiscard]] std::uint64_t reserved() const;  // bytes that this account and its parts hold now
  [[nodiscard]] std::uint64_t peak() const;      // the most bytes that account and parts held at a time

 private:
  explicit MemoryBudget(std::shared_ptr<detail::MemoryAccount> account);

  std::shared_ptr<detail::MemoryAccount> account_;
};

}  // namespace isoextract
