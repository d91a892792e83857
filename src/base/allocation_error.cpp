#include "base/allocation_error.hpp"

#include <algorithm>
#include <fstream>

#include <sys/resource.h>
#include <unistd.h>

#include <fmt/format.h>

#include "base/byte_size.hpp"

namespace isoextract {

std::optional<std::uint64_t> address_space_limit() {
  rlimit limit{};
  if (::getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return std::nullopt;
  return limit.rlim_cur;
}

std::optional<std::uint64_t> address_space_left() {
  const auto limit = address_space_limit();
  if (!limit) return std::nullopt;
  std::uint64_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return *limit - std::min(*limit, pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE)));
}

Error allocation_error(std::string message, Hint hint) {
  const auto limit = address_space_limit();
  if (!limit) return {ErrorCode::out_of_memory, std::move(message), std::move(hint)};
  return {ErrorCode::out_of_memory,
          fmt::format("{}: the address space of the process is limited to {}", message, format_byte_size(*limit)),
          {kRaiseAddressSpaceHint, {Remedy::use, Setting::parts}}};
}

}  // namespace isoextract
