#include "sandbox/program.hpp"

#include <sys/auxv.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <fstream>
#include <iterator>
#include <string_view>

#include "sandbox/detail/server.hpp"

#if defined(__SANITIZE_THREAD__)
#define ISOEXTRACT_THREAD_SANITIZER 1
#elif defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define ISOEXTRACT_THREAD_SANITIZER 1
#endif
#endif

namespace isoextract::sandbox {
namespace {

// Marks a child's command line. Not a plausible file name; without WorkerPool's socket it has no effect.
constexpr std::string_view kChildWord = "@child-process";

std::atomic<bool> children_allowed{false};

bool is_socket(int descriptor) {
  int domain = 0;
  socklen_t size = sizeof(domain);
  return ::getsockopt(descriptor, SOL_SOCKET, SO_DOMAIN, &domain, &size) == 0 && domain == AF_UNIX;
}

std::vector<std::string> own_command_line() {
  std::ifstream file("/proc/self/cmdline", std::ios::binary);
  std::vector<std::string> words;
  for (std::string word; std::getline(file, word, '\0');) words.push_back(word);
  return words;
}

// Counts the words of a dynamic loader that was started as a program, up to the program's file.
std::size_t loader_words(std::span<const std::string> words) {
  constexpr std::array<std::string_view, 6> kWithValue{"library-path",  "preload", "audit",
                                                       "inhibit-rpath", "argv0",   "glibc-hwcaps-prepend"};
  std::size_t at = 1;
  while (at < words.size() && words[at].starts_with("--")) {
    at += std::ranges::count(kWithValue, std::string_view(words[at]).substr(2)) > 0 ? 2 : 1;
  }
  return at;
}

}  // namespace

std::optional<int> run_as_child(std::span<char* const> arguments,
                                const std::function<ChildWork(std::span<const std::string>)>& make_work) {
  if (arguments.size() < 2 || arguments[1] != kChildWord || !is_socket(detail::kControlSocket)) {
#ifndef ISOEXTRACT_THREAD_SANITIZER
    children_allowed = true;
#endif
    return std::nullopt;
  }
  detail::isolate_server();
  const std::vector<std::string> words(arguments.begin() + 2, arguments.end());
  return detail::serve(make_work(words));
}

bool can_start_children() { return children_allowed; }

std::vector<std::string> command_line_with(const std::vector<std::string>& further) {
  std::vector<std::string> command = own_command_line();
  // A process without an interpreter (AT_BASE is 0) was started through the loader.
  const bool by_loader = ::getauxval(AT_BASE) == 0;
  const std::size_t kept = by_loader ? loader_words(command) + 1 : 1;
  command.resize(std::min(kept, command.size()));
  if (command.empty()) command.emplace_back("isoextract");
  command.emplace_back(kChildWord);
  command.insert(command.end(), further.begin(), further.end());
  return command;
}

}  // namespace isoextract::sandbox
