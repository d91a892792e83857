// How much memory may be taken, by all that runs at once together. What is large is reserved before it is allocated,
// and stays reserved for as long as it lives.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "base/error.hpp"

namespace isoextract {

// What this process may use: the machine's physical memory, or less where a control group (v1 or v2) says so.
[[nodiscard]] std::uint64_t available_memory();

namespace detail {
struct MemoryAccount;
}

// A part of the budget, given back when it goes. Movable; what is moved from holds nothing. It may outlive the
// MemoryBudget that it came from.
class [[nodiscard]] Reservation {
 public:
  Reservation() = default;
  Reservation(Reservation&& other) noexcept;
  Reservation& operator=(Reservation&& other) noexcept;
  ~Reservation() { release(); }

  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }
  void release();
  // To what is still needed: `bytes` are at most those that are held.
  void shrink(std::uint64_t bytes);
  // Takes over what the other one holds, which is of the same context; either may hold nothing.
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

  // An account within this budget: what it reserves counts here as well, and its own peak is told apart. One conversion
  // of many has one of its own.
  [[nodiscard]] MemoryBudget part() const;

  // Fails with ErrorCode::out_of_memory and Remedy::raise_memory_limit where that is more than is left. `what` starts
  // the message, for example "in.nrrd: 4096x4096x4096 f32 samples". Kept blocks of Buffer give way first.
  [[nodiscard]] Result<Reservation> reserve(std::uint64_t bytes, const std::string& what) const;

  [[nodiscard]] std::uint64_t limit() const;
  [[nodiscard]] std::uint64_t left() const;      // of the limit, now, by all accounts of it
  [[nodiscard]] std::uint64_t reserved() const;  // now, by this account
  [[nodiscard]] std::uint64_t peak() const;      // the most that it has reserved at a time

 private:
  explicit MemoryBudget(std::shared_ptr<detail::MemoryAccount> account);

  std::shared_ptr<detail::MemoryAccount> account_;
};

}  // namespace isoextract
