#include "plugin_host/detail/worker_conversation.hpp"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <limits>
#include <string_view>

#include <fmt/format.h>
#include <tbb/global_control.h>

#include "base/byte_size.hpp"
#include "base/checked.hpp"
#include "base/printable.hpp"
#include "plugin_host/plugin_session.hpp"

namespace isoextract::plugin_host {

using sandbox::SharedMemory;
using sandbox::WorkerEnd;

namespace {

constexpr const char* kSecondsVariable = "ISOEXTRACT_PLUGIN_SECONDS";
constexpr std::uint64_t kUsualSeconds = 60;

// Returns a worker's limits. Adds the size of its files to the memory, as libraries map them, and 1 s per MiB to the
// time.
Result<sandbox::Limits> limits_for(std::uint64_t file_bytes, const Context& context) {
  std::uint64_t seconds = kUsualSeconds;
  if (const char* given = std::getenv(kSecondsVariable)) {
    const std::string_view text(given);
    const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), seconds);
    if (status != std::errc{} || end != text.data() + text.size() || seconds == 0) {
      return fail(ErrorCode::usage, fmt::format("the environment variable {}: expected 1 or more seconds, found '{}'",
                                                kSecondsVariable, printable(text, 40)));
    }
  }
  sandbox::Limits limits;
  limits.seconds = checked_sum(seconds, file_bytes >> 20U).value_or(std::numeric_limits<std::uint64_t>::max());
  const std::uint64_t left = context.memory().left();
  limits.memory = checked_sum(left, file_bytes).value_or(left);
  limits.threads = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  return limits;
}

}  // namespace

Result<SharedMemory> share_memory(const std::string& name, std::uint64_t bytes) {
  if (auto memory = SharedMemory::create(bytes)) return std::move(*memory);
  return fail(
      ErrorCode::unavailable,
      fmt::format("{}: the system refuses {} of shared memory (memfd_create) for the process that reads the file", name,
                  format_byte_size(bytes)),
      {Remedy::use, Setting::in_process});
}

WorkerConversation::WorkerConversation(sandbox::WorkerPool::Started started, std::string id, std::string name,
                                       Context context, const sandbox::Limits& limits)
    : worker_(std::move(started.worker)),
      greeting_(std::move(started.greeting)),
      id_(std::move(id)),
      name_(std::move(name)),
      context_(std::move(context)),
      limits_(limits) {}

Result<WorkerConversation::Heard> WorkerConversation::hear() {
  auto message = worker_->receive();
  if (!message) return tl::unexpected(error_of(worker_->ending()));
  Heard heard{static_cast<MessageKind>(message->number()), std::move(*message)};
  if (heard.what != MessageKind::failed) return heard;
  const std::string reason = heard.message.text();
  Error failed = plugin_error(name_, reason, signed_of(heard.message.number()));
  if (worker_->finish().memory_was_refused) {
    failed.message += fmt::format("; the memory limit leaves {}", format_byte_size(limits_.memory));
    failed.code = ErrorCode::out_of_memory;
    failed.hint = {Remedy::raise, Setting::memory_limit};
  }
  return tl::unexpected(std::move(failed));
}

Result<void> WorkerConversation::take(std::span<std::byte> to) {
  if (worker_->receive_bytes(to)) return {};
  return tl::unexpected(error_of(worker_->ending()));
}

Result<void> WorkerConversation::finish() {
  const WorkerEnd& ending = worker_->finish();
  if (ending.reason == WorkerEnd::Reason::done) return {};
  return tl::unexpected(error_of(ending));
}

tl::unexpected<Error> WorkerConversation::refused(const std::string& what) const {
  return fail(ErrorCode::input, fmt::format("{}: the plug-in for {} returns {}", name_, id_, what));
}

std::string WorkerConversation::printed() const {
  std::string text = worker_->output();
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
  std::ranges::replace(text, '\n', ' ');
  return printable(text, 300);
}

Error WorkerConversation::error_of(const WorkerEnd& ending) const {
  const std::string who = fmt::format("{}: the process that read the file with the plug-in for {}", name_, id_);
  constexpr const char* kDamaged = "the file is damaged, or the plug-in's library does not support it";
  switch (ending.reason) {
    case WorkerEnd::Reason::cancelled: return {ErrorCode::cancelled, "cancelled", {}};
    case WorkerEnd::Reason::too_long:
      return {ErrorCode::input, fmt::format("{} exceeded its time limit of {} s: {}", who, limits_.seconds, kDamaged),
              fmt::format("if the file is intact, raise the limit with the environment variable {}", kSecondsVariable)};
    case WorkerEnd::Reason::lost:
      return {ErrorCode::unavailable,
              fmt::format("{}: the process for reading the file with the plug-in for {} did not start, or its "
                          "connection broke",
                          name_, id_),
              {Remedy::use, Setting::in_process}};
    case WorkerEnd::Reason::signal:
      if (ending.memory_was_refused) {
        return {ErrorCode::out_of_memory,
                fmt::format("{} needs more memory than the {} that the memory limit leaves", who,
                            format_byte_size(limits_.memory)),
                {Remedy::raise, Setting::memory_limit}};
      }
      return {ErrorCode::input, fmt::format("{} crashed (signal {}): {}", who, ending.signal, kDamaged),
              "write the file again, or in another format"};
    case WorkerEnd::Reason::done: break;
  }
  return {ErrorCode::input, fmt::format("{} ended without an answer: {}", who, kDamaged), {}};
}

Result<std::unique_ptr<WorkerConversation>> start_conversation(const PluginLibrary& library, const std::string& id,
                                                               const std::string& name, std::uint64_t file_bytes,
                                                               const Context& context) {
  const auto limits = TRY(limits_for(file_bytes, context));
  auto started = TRY(library.start_worker(name, limits, context));
  return std::make_unique<WorkerConversation>(std::move(started), id, name, context, limits);
}

}  // namespace isoextract::plugin_host
