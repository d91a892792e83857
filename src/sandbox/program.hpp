// Runs this program as its own child process: the same executable, started again, does a child's work.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace isoextract::sandbox {

// The work of a child. The function that returns it has loaded the libraries.
struct ChildWork {
  std::string greeting;          // sent to the parent once; if the child cannot work: the reason
  std::function<void(int)> run;  // runs one worker, which communicates through the given socket; empty if the child
                                 // cannot work
  std::string advice;            // if the child cannot work: what to do about it
};

// main() calls this before anything else, with its arguments. If WorkerPool started this process, runs the work that
// `make_work` returns for the words of WorkerPool, then ends the process with code 0. Otherwise returns nothing, and
// from now on this program may start itself as a child.
[[nodiscard]] std::optional<int> run_as_child(std::span<char* const> arguments,
                                              const std::function<ChildWork(std::span<const std::string>)>& make_work);

// Returns whether main() has called run_as_child and children can work. They cannot under the thread sanitizer, which
// terminates them.
[[nodiscard]] bool can_start_children();

// Returns argv for starting "/proc/self/exe" as a child: this process's argv[0], the word that marks a child, then
// `further`. If a loader runs the program, as in the portable folder, "/proc/self/exe" is the loader. The loader's own
// words and the program's file then follow argv[0].
[[nodiscard]] std::vector<std::string> command_line_with(const std::vector<std::string>& further);

}  // namespace isoextract::sandbox
