#include "plugin_host/ranks_plugin.hpp"

#include <array>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include <ranks_plugin.h>
#include "base/printable.hpp"

namespace isoextract::plugin_host {
namespace {

using Plugin = isoextract_ranks_plugin_v1;

std::optional<int> number_of(const char* text) {
  if (text == nullptr) return std::nullopt;
  int number = 0;
  const char* const end = text + std::strlen(text);
  const auto [last, status] = std::from_chars(text, end, number);
  return status == std::errc{} && last == end && number >= 0 ? std::optional(number) : std::nullopt;
}

tl::unexpected<Error> failed(const Plugin& plugin) {
  const char* text = plugin.error_text();
  return fail(ErrorCode::unavailable, fmt::format("the ranks cannot reach each other: {}",
                                                  text == nullptr ? "no reason given" : printable(text, 400)));
}

class PluginLink final : public RankLink {
 public:
  PluginLink(const Plugin& plugin, const isoextract_rank& own) : plugin_(plugin), own_(own) {}

  [[nodiscard]] int rank() const override { return own_.rank; }
  [[nodiscard]] int size() const override { return own_.size; }
  [[nodiscard]] int node() const override { return own_.node; }

  Result<std::vector<std::string>> gather(std::string_view bytes) override {
    std::vector<std::uint64_t> sizes(static_cast<std::size_t>(own_.size));
    const auto* all = static_cast<const char*>(plugin_.gather(bytes.data(), bytes.size(), sizes.data()));
    if (all == nullptr) return failed(plugin_);
    std::vector<std::string> by_rank;
    for (const std::uint64_t size : sizes) {
      by_rank.emplace_back(all, size);
      all += size;
    }
    return by_rank;
  }

  Result<void> send(int to, std::string_view bytes) override {
    if (plugin_.send(to, bytes.data(), bytes.size()) != 0) return failed(plugin_);
    return {};
  }

  Result<std::optional<RankMessage>> receive(std::chrono::milliseconds most) override {
    constexpr std::int32_t kNone = -1;
    std::int32_t from = kNone;
    std::uint64_t count = 0;
    const auto* bytes =
        static_cast<const char*>(plugin_.receive(static_cast<std::int32_t>(most.count()), &from, &count));
    if (bytes != nullptr) return RankMessage{from, std::string(bytes, count)};
    if (from != kNone) return failed(plugin_);
    return std::nullopt;
  }

  void leave() override { plugin_.leave(); }

 private:
  const Plugin& plugin_;
  isoextract_rank own_;
};

}  // namespace

std::optional<LaunchedRank> launched_rank(const std::function<const char*(const char*)>& get) {
  struct Launcher {
    const char* rank;
    const char* size;
  };
  constexpr std::array kLaunchers{Launcher{"OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE"},
                                  Launcher{"PMI_RANK", "PMI_SIZE"}, Launcher{"PMIX_RANK", "SLURM_STEP_NUM_TASKS"}};
  for (const Launcher& launcher : kLaunchers) {
    const auto rank = number_of(get(launcher.rank));
    const auto size = number_of(get(launcher.size));
    if (rank && size && *size > 1) return LaunchedRank{*rank, *size, launcher.size};
  }
  return std::nullopt;
}

Result<std::unique_ptr<RankLink>> join_ranks(const LaunchedRank& launched, PluginFolders folders) {
  const PluginKind kind{"isoextract-ranks-", "isoextract_ranks_plugin", call_plugin_function<Plugin>,
                        ISOEXTRACT_RANKS_PLUGIN_VERSION, false};
  const std::string label = fmt::format("{}={}", launched.variable, launched.size);
  const std::string alone = fmt::format("env -u {} runs independent processes", launched.variable);
  const PluginLibrary library(kind, "mpi", std::move(folders));
  if (!library.is_there()) {
    return fail(
        ErrorCode::unavailable,
        fmt::format("{}: a run of several processes needs the plug-in {}mpi.so, which is in no plug-in folder", label,
                    kind.name_start),
        fmt::format("install the packages libopenmpi-dev and openmpi-bin and build isoextract again, which then "
                    "builds the plug-in; {}",
                    alone));
  }
  const auto opened = TRY(library.opened(label));
  const auto& plugin = *static_cast<const Plugin*>(opened);
  isoextract_rank own{};
  if (plugin.join(&own) != 0) return failed(plugin);
  if (own.size != launched.size) {
    return fail(
        ErrorCode::unavailable,
        fmt::format("{}: the launcher started {} processes, but MPI connects {}", label, launched.size, own.size),
        fmt::format("use the launcher that belongs to the MPI of the plug-in (with Slurm: the type pmix of srun); {}",
                    alone));
  }
  return std::make_unique<PluginLink>(plugin, own);
}

}  // namespace isoextract::plugin_host
