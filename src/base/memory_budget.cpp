#include "base/memory_budget.hpp"

#include <algorithm>
#include <atomic>
#include <cassert>
#include <fstream>
#include <mutex>
#include <optional>
#include <sstream>
#include <utility>

#include <fmt/format.h>
#include <unistd.h>

#include "base/buffer.hpp"
#include "base/byte_size.hpp"

namespace isoextract {

namespace detail {

// Reservations of a child count in all its ancestors; only the root has a limit.
struct MemoryAccount {
  std::shared_ptr<MemoryAccount> parent;
  std::uint64_t limit = 0;  // of the root
  std::mutex mutex;         // of the root
  std::atomic<std::uint64_t> reserved{0};
  std::atomic<std::uint64_t> peak{0};

  MemoryAccount& top() { return parent ? parent->top() : *this; }

  void add(std::uint64_t bytes) {
    for (MemoryAccount* account = this; account != nullptr; account = account->parent.get()) {
      account->reserved += bytes;
      account->peak = std::max(account->peak.load(), account->reserved.load());
    }
  }
  void remove(std::uint64_t bytes) {
    for (MemoryAccount* account = this; account != nullptr; account = account->parent.get()) account->reserved -= bytes;
  }
};

}  // namespace detail

namespace {

std::optional<std::uint64_t> number_in(const std::string& path) {
  std::ifstream file(path);
  std::uint64_t number = 0;
  if (file >> number) return number;
  return std::nullopt;  // missing file, or "max"
}

// Returns the lowest limit of the process's control group and its ancestors, because all of them apply. Version 2 has
// one tree; version 1 has one for the controller "memory". In a container the group's folder may be the root of the
// mount.
std::optional<std::uint64_t> control_group_limit() {
  std::optional<std::uint64_t> least;
  const auto look = [&](const std::string& path) {
    if (const auto limit = number_in(path)) least = std::min(*limit, least.value_or(*limit));
  };
  std::ifstream groups("/proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {  // "0::/a/b" or "5:memory:/a/b"
    std::istringstream fields(line);
    std::string number;
    std::string controllers;
    std::string folder;
    if (!std::getline(fields, number, ':') || !std::getline(fields, controllers, ':') ||
        !std::getline(fields, folder)) {
      continue;
    }
    const bool second = number == "0" && controllers.empty();
    if (!second && fmt::format(",{},", controllers).find(",memory,") == std::string::npos) continue;
    const std::string mount = second ? "/sys/fs/cgroup" : "/sys/fs/cgroup/memory";
    const std::string file = second ? "/memory.max" : "/memory.limit_in_bytes";
    for (std::string at = folder == "/" ? "" : folder;; at.erase(at.rfind('/'))) {
      look(fmt::format("{}{}{}", mount, at, file));
      if (at.find('/') == std::string::npos) break;
    }
  }
  return least;
}

std::uint64_t find_available_memory() {
  const long pages = ::sysconf(_SC_PHYS_PAGES);
  const long page_size = ::sysconf(_SC_PAGESIZE);
  constexpr std::uint64_t kFallback = 8ULL << 30;
  const std::uint64_t machine = pages > 0 && page_size > 0
                                    ? static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(page_size)
                                    : kFallback;
  return std::min(machine, control_group_limit().value_or(machine));
}

}  // namespace

std::uint64_t available_memory() {
  static const std::uint64_t found = find_available_memory();
  return found;
}

Reservation::Reservation(std::shared_ptr<detail::MemoryAccount> account, std::uint64_t bytes)
    : account_(std::move(account)), bytes_(bytes) {}

Reservation::Reservation(Reservation&& other) noexcept
    : account_(std::move(other.account_)), bytes_(std::exchange(other.bytes_, 0)) {}

Reservation& Reservation::operator=(Reservation&& other) noexcept {
  if (this == &other) return *this;
  release();
  account_ = std::move(other.account_);
  bytes_ = std::exchange(other.bytes_, 0);
  return *this;
}

void Reservation::release() { shrink(0); }

void Reservation::shrink(std::uint64_t bytes) {
  if (account_ == nullptr || bytes >= bytes_) return;
  account_->remove(bytes_ - bytes);
  bytes_ = bytes;
}

void Reservation::take(Reservation&& other) {
  if (bytes_ == 0) {
    *this = std::move(other);
    return;
  }
  assert(other.bytes_ == 0 || other.account_ == account_);
  bytes_ += std::exchange(other.bytes_, 0);
}

MemoryBudget::MemoryBudget(std::uint64_t limit_bytes) : account_(std::make_shared<detail::MemoryAccount>()) {
  account_->limit = limit_bytes;
}

MemoryBudget::MemoryBudget(std::shared_ptr<detail::MemoryAccount> account) : account_(std::move(account)) {}

MemoryBudget MemoryBudget::part() const {
  auto account = std::make_shared<detail::MemoryAccount>();
  account->parent = account_;
  return MemoryBudget(std::move(account));
}

Result<Reservation> MemoryBudget::reserve(std::uint64_t bytes, const std::string& what) const {
  detail::MemoryAccount& top = account_->top();
  const std::scoped_lock lock(top.mutex);
  const std::uint64_t used = top.reserved;
  if (bytes > top.limit || used > top.limit - bytes) {
    std::string message =
        fmt::format("{} would take {}, the limit is {}", what, format_byte_size(bytes), format_byte_size(top.limit));
    if (used > 0) message += fmt::format(", of which {} are in use", format_byte_size(used));
    return fail(ErrorCode::out_of_memory, std::move(message), {Remedy::raise, Setting::memory_limit});
  }
  detail::trim_kept_blocks(top.limit - used - bytes);
  account_->add(bytes);
  return Reservation(account_, bytes);
}

std::uint64_t MemoryBudget::limit() const { return account_->top().limit; }
std::uint64_t MemoryBudget::left() const {
  detail::MemoryAccount& top = account_->top();
  const std::scoped_lock lock(top.mutex);
  return top.limit - std::min(top.limit, std::uint64_t{top.reserved});
}
std::uint64_t MemoryBudget::reserved() const { return account_->reserved; }
std::uint64_t MemoryBudget::peak() const { return account_->peak; }

}  // namespace isoextract
