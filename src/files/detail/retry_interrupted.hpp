// Repeats a system call for as long as signals interrupt it.
#pragma once

#include <cerrno>

namespace isoextract::files {

template <class Call>
auto retry_interrupted(Call call) {
  auto result = call();
  while (result < 0 && errno == EINTR) result = call();
  return result;
}

}  // namespace isoextract::files
