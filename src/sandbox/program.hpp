// This program as its own child process: started again, it does the work of a child in place of its own.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace isoextract::sandbox {

// What a child does. Its libraries are loaded by whoever makes this.
struct ChildWork {
  std::string greeting;          // what it tells the parent once; where it cannot work: why
  std::function<void(int)> run;  // the work of one worker, which speaks through that socket; empty where it cannot work
  std::string advice;            // where it cannot work: what to do
};

// Called by main() before anything else, with its arguments. Where this process was started by Workers, it does what
// `make_work` gives for the words that Workers has, and this gives the exit code. Else it gives nothing, and this
// program may start itself as a child from now on.
[[nodiscard]] std::optional<int> run_if_child(std::span<char* const> arguments,
                                              const std::function<ChildWork(std::span<const std::string>)>& make_work);

// Whether main() has called run_if_child, and children can work: not under the thread sanitizer, which ends them.
[[nodiscard]] bool can_start_children();

// The words that start this program again with further ones, its file apart: "/proc/self/exe" is to be started. Where a
// loader runs the program, as in the portable folder, that is the loader, and its own words are among these.
[[nodiscard]] std::vector<std::string> words_to_start(const std::vector<std::string>& further);

}  // namespace isoextract::sandbox
