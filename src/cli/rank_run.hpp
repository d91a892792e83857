// Runs the program on several ranks (base/ranks.hpp): joins the ranks if a launcher started several processes, and
// gives each rank a share of its machine. Only rank 0 prints.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/ranks.hpp"

namespace isoextract::cli {

// Returns whether a launcher started several processes, and this is not the first of them.
[[nodiscard]] bool is_later_rank();

// Runs `work`, the whole program, prints its error, and returns its exit code. If a launcher started several processes,
// joins the ranks first, and waits for them last. Rank 0 then returns the exit code of the run, and the other ranks
// return 0. `arguments` are the words of the command line. Prints an error and returns the code of
// ErrorCode::unavailable if the ranks cannot be joined, of ErrorCode::usage if command lines or folders differ.
[[nodiscard]] int run_on_ranks(const std::vector<std::string>& arguments, const std::function<Result<int>()>& work);

// Returns the ranks of this run; null if this process is alone.
[[nodiscard]] Ranks* ranks_of_run();

// Shares the processors and the memory of each machine among its ranks, for a command whose work all ranks do.
void share_machine();
// Returns how many threads this rank may use; nullopt if this process is alone or share_machine() was not called.
[[nodiscard]] std::optional<int> threads_of_rank();
// Returns how many bytes of memory this rank may use; nullopt when threads_of_rank() returns nullopt.
[[nodiscard]] std::optional<std::uint64_t> memory_of_rank();
// Returns "4 ranks on 2 machines": the ranks of this run, which must have several.
[[nodiscard]] std::string ranks_text();

// Returns "; 2 threads each": the given number, or else all threads that this process may use.
[[nodiscard]] std::string threads_text(const std::optional<int>& threads);
// Returns the longest time of a rank, divided by the mean time of all ranks.
[[nodiscard]] double imbalance_of(const std::vector<double>& seconds);
[[nodiscard]] std::string imbalance_text(const std::vector<double>& seconds);

// Writes to stderr that a signal ends the run. Ranks other than the first write nothing. For handlers of signals that
// end the process: async-signal-safe.
void tell_ended_by_signal() noexcept;

// Fails with ErrorCode::input on all ranks if `same`, such as the hash of a plan, differs between ranks. Does nothing
// if this process is alone. Every rank calls this function.
[[nodiscard]] Result<void> agree(const std::string& same);

}  // namespace isoextract::cli
