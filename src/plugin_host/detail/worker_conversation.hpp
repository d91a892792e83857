// The program's side of a conversation with a worker (plugin_messages.hpp): sends requests, and reports as an error
// every way in which the conversation can fail.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>

#include "base/context.hpp"
#include "base/error.hpp"
#include "plugin_host/detail/plugin_messages.hpp"
#include "plugin_host/plugin_library.hpp"
#include "sandbox/limits.hpp"
#include "sandbox/shared_memory.hpp"
#include "sandbox/worker.hpp"

namespace isoextract::plugin_host {

inline constexpr std::size_t kMaxText = 4096;  // longest text of a worker in bytes

// Fails with ErrorCode::unavailable, naming the input, if the system refuses.
[[nodiscard]] Result<sandbox::SharedMemory> share_memory(const std::string& name, std::uint64_t bytes);

[[nodiscard]] inline std::int32_t signed_of(std::uint64_t bits) { return static_cast<std::int32_t>(bits); }

class WorkerConversation {
 public:
  WorkerConversation(sandbox::WorkerPool::Started started, std::string id, std::string name, Context context,
                     const sandbox::Limits& limits);

  struct Heard {
    MessageKind what{};
    sandbox::MessageReader message;
  };

  void tell(const sandbox::MessageWriter& message, int descriptor = -1) { worker_->send(message, descriptor); }
  // Returns the worker's next message. Fails if it reports a failure or has ended.
  [[nodiscard]] Result<Heard> hear();
  // Receives bytes that follow a message.
  [[nodiscard]] Result<void> take(std::span<std::byte> to);
  // Ends the worker, after which the shared memory no longer changes.
  [[nodiscard]] Result<void> finish();
  // Returns the error for an invalid reply; `what` completes "the plug-in for ID returns ...".
  [[nodiscard]] tl::unexpected<Error> refused(const std::string& what) const;

  [[nodiscard]] const std::string& greeting() const { return greeting_; }
  [[nodiscard]] const std::string& id() const { return id_; }
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const Context& context() const { return context_; }
  // Returns what the worker printed, as one line.
  [[nodiscard]] std::string printed() const;

 private:
  [[nodiscard]] Error error_of(const sandbox::WorkerEnd& ending) const;

  std::unique_ptr<sandbox::Worker> worker_;
  std::string greeting_;
  std::string id_;
  std::string name_;
  Context context_;
  sandbox::Limits limits_;
};

// Starts a worker for an input; `file_bytes` is the total size of its files.
[[nodiscard]] Result<std::unique_ptr<WorkerConversation>> start_conversation(const PluginLibrary& library,
                                                                             const std::string& id,
                                                                             const std::string& name,
                                                                             std::uint64_t file_bytes,
                                                                             const Context& context);

}  // namespace isoextract::plugin_host
