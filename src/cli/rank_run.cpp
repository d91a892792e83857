#include "cli/rank_run.hpp"

#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <memory>
#include <numeric>
#include <set>
#include <string_view>
#include <system_error>
#include <utility>

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include "base/counted.hpp"
#include "base/memory_budget.hpp"
#include "base/packed_values.hpp"
#include "cli/messages.hpp"
#include "plugin_host/ranks_plugin.hpp"

namespace isoextract::cli {
namespace {

// The state of this process as one of several ranks; it stays in memory until the process ends.
struct Joined {
  explicit Joined(std::unique_ptr<RankLink> link) : ranks(std::move(link)) {}

  Ranks ranks;
  int machines = 1;
  int on_machine = 1;     // ranks on this machine
  int on_processors = 1;  // ranks on this machine that may use the same processors as this one
  bool shares = false;
};

std::unique_ptr<Joined>& joined() {
  static std::unique_ptr<Joined> one;
  return one;
}

std::atomic<bool> is_rank{false};           // this process is one of several ranks
std::atomic<bool> speaks_for_ranks{false};  // this is rank 0 of several

int report(const Error& error) {
  Messages({Verbosity::quiet}).error(error);
  return exit_code_of(error.code);
}

std::optional<plugin_host::LaunchedRank> launched() {
  return plugin_host::launched_rank([](const char* name) -> const char* { return std::getenv(name); });
}

// Describes a rank to the others.
struct Presence {
  int node = 0;
  std::string processors;  // bytes of the cpu_set_t that the rank may use
  std::string words;       // its command line and folder

  [[nodiscard]] std::string packed() const { return Packer().put(node).put(processors).put(words).take(); }
  static Presence of(std::string_view bytes) {
    Unpacker from(bytes);
    Presence presence;
    presence.node = from.get<int>();
    presence.processors = from.get<std::string>();
    presence.words = from.get<std::string>();
    return presence;
  }
};

Presence own_presence(const Ranks& ranks, const std::vector<std::string>& arguments) {
  cpu_set_t set;
  CPU_ZERO(&set);
  ::sched_getaffinity(0, sizeof(set), &set);
  std::error_code none;
  Packer words;
  for (const std::string& word : arguments) words.put(word);
  words.put(std::filesystem::current_path(none).string());
  return {ranks.node(), std::string(reinterpret_cast<const char*>(&set), sizeof(set)), words.take()};
}

Result<void> meet(Joined& one, const std::vector<std::string>& arguments) {
  const Presence own = own_presence(one.ranks, arguments);
  const auto all = TRY(one.ranks.gather(own.packed()));
  std::set<int> machines;
  one.on_machine = one.on_processors = 0;
  for (std::size_t r = 0; r < all.size(); ++r) {
    const Presence other = Presence::of(all[r]);
    machines.insert(other.node);
    if (other.node == own.node) {
      ++one.on_machine;
      if (other.processors == own.processors) ++one.on_processors;
    }
    if (other.words == Presence::of(all.front()).words) continue;
    return fail(
        ErrorCode::usage,
        fmt::format("rank {} has another command line or folder than rank 0; the ranks of a run share its work", r),
        "give all ranks the same command, or start independent runs without mpirun");
  }
  one.machines = static_cast<int>(machines.size());
  return {};
}

Result<int> guarded(const std::function<Result<int>()>& work) {
  try {
    return work();
  } catch (const std::exception&) {
    return tl::unexpected(error_of_exception());
  }
}

}  // namespace

bool is_later_rank() {
  static const bool later = [] {
    const auto own = launched();
    return own && own->rank > 0;
  }();
  return later;
}

int run_on_ranks(const std::vector<std::string>& arguments, const std::function<Result<int>()>& work) {
  const auto own = launched();
  if (!own) {
    const auto code = guarded(work);
    return code ? *code : report(code.error());
  }
  auto link = plugin_host::join_ranks(*own, plugin_host::plugin_folders());
  if (!link) return report(link.error());
  joined() = std::make_unique<Joined>(std::move(*link));
  Ranks& ranks = joined()->ranks;
  is_rank = true;
  speaks_for_ranks = ranks.is_first();
  const auto code = guarded([&]() -> Result<int> {
    TRY(meet(*joined(), arguments));
    return work();
  });
  int exit_code = code ? *code : report(code.error());
  const auto other = ranks.end(code ? nullptr : &code.error());
  speaks_for_ranks = false;
  if (!ranks.is_first()) return 0;  // a launcher ends all ranks when one fails
  if (code && other) exit_code = report(*other);
  return exit_code;
}

Ranks* ranks_of_run() { return joined() ? &joined()->ranks : nullptr; }

void share_machine() {
  if (joined()) joined()->shares = true;
}

std::optional<int> threads_of_rank() {
  if (!joined() || !joined()->shares) return std::nullopt;
  return std::max(1, tbb::this_task_arena::max_concurrency() / joined()->on_processors);
}

std::optional<std::uint64_t> memory_of_rank() {
  if (!joined() || !joined()->shares) return std::nullopt;
  return available_memory() / static_cast<std::uint64_t>(joined()->on_machine);
}

std::string ranks_text() {
  return fmt::format("{} ranks on {}", joined()->ranks.size(), counted(joined()->machines, "machine"));
}

std::string threads_text(const std::optional<int>& threads) {
  const int each = threads.value_or(tbb::this_task_arena::max_concurrency());
  return fmt::format("; {} each", counted(each, "thread"));
}

double imbalance_of(const std::vector<double>& seconds) {
  const double sum = std::accumulate(seconds.begin(), seconds.end(), 0.0);
  return sum > 0 ? std::ranges::max(seconds) * static_cast<double>(seconds.size()) / sum : 1;
}

std::string imbalance_text(const std::vector<double>& seconds) {
  return fmt::format("the slowest rank took {:.2f} times the mean of all ranks", imbalance_of(seconds));
}

void tell_ended_by_signal() noexcept {
  constexpr std::string_view kByItself = "\nisoextract: interrupted; it has removed unfinished output\n";
  constexpr std::string_view kOfRanks =
      "isoextract: error: a signal ended the run; mpirun sends one to all ranks if one of them ends early\n"
      "  hint: no file is incomplete; --resume continues a sequence\n";
  if (is_rank && !speaks_for_ranks) return;
  const std::string_view text = is_rank ? kOfRanks : kByItself;
  [[maybe_unused]] const auto written = ::write(STDERR_FILENO, text.data(), text.size());
}

Result<void> agree(const std::string& same) {
  if (!joined()) return {};
  const auto all = TRY(joined()->ranks.gather(same));
  for (std::size_t r = 1; r < all.size(); ++r) {
    if (all[r] == all.front()) continue;
    return fail(ErrorCode::input, fmt::format("rank {} finds other inputs than rank 0", r),
                "keep the inputs on a file system that all machines share");
  }
  return {};
}

}  // namespace isoextract::cli
