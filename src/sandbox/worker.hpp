// Child processes that do work which may crash, hang, take memory without end, or be led by its input to do anything
// else: what becomes of them is a value here.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <sys/types.h>
#include <tl/expected.hpp>

#include "base/context.hpp"
#include "sandbox/descriptor.hpp"
#include "sandbox/limits.hpp"
#include "sandbox/message.hpp"

namespace isoextract::sandbox {

// How a worker has ended.
struct Ending {
  enum class Reason {
    done,       // by itself
    signal,     // `signal` has ended it
    too_long,   // its time was over
    cancelled,  // the context was
    lost,       // it could not be started, or nobody knows what became of it
  };
  Reason reason = Reason::lost;
  int signal = 0;
  bool lacked_memory = false;  // it was refused some that it asked for
};

// One process, alive until it has ended or this goes. Used by one thread at a time.
class Worker {
 public:
  // `kill_server` ends the process that the worker was forked from, and the worker with it: it is called where that
  // process does not end the worker when it is told to.
  Worker(Descriptor socket, Descriptor status, Descriptor output, std::uint64_t seconds, Context context,
         std::function<void()> kill_server);
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;
  ~Worker();

  // Nothing is waited for. Where it fails, receive() tells how the worker has ended.
  void send(const MessageWriter& message, int descriptor = -1);
  // The next message. Nothing where it has ended, or had to be: ending() says how.
  [[nodiscard]] std::optional<MessageReader> receive();
  // Bytes that follow a message. False where it has ended before that.
  [[nodiscard]] bool receive_bytes(std::span<std::byte> to);
  // Takes no more messages and waits for its end. After that it has no more access to shared memory.
  const Ending& finish();
  [[nodiscard]] const Ending& ending() const { return *ending_; }
  // The beginning of what it has printed.
  [[nodiscard]] const std::string& output() const { return output_; }

 private:
  void wait_a_little(bool for_messages);
  void read_output();
  [[nodiscard]] bool read_socket();
  void read_status();
  void end_it(Ending::Reason reason);
  [[nodiscard]] std::optional<MessageReader> take_message();

  Descriptor socket_;
  Descriptor status_;
  Descriptor printed_;
  std::int64_t microseconds_left_ = 0;
  Context context_;
  std::function<void()> kill_server_;
  int waited_for_end_ = 0;  // how often, since it was told to end
  std::vector<std::byte> received_;
  std::string output_;
  std::optional<Ending::Reason> wanted_end_;
  std::optional<Ending> ending_;
};

// Why there is no worker.
struct Refusal {
  std::string what;    // "has version 1 of the interface, expected 2"
  std::string advice;  // what to do about it; may be empty
};

// The workers of one library, which is loaded in a process that all of them are forked from. That is started for the
// first one, and ends with this.
class Workers {
 public:
  // `words` tell run_if_child of the child what to do.
  explicit Workers(std::vector<std::string> words) : words_(std::move(words)) {}
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;
  ~Workers();

  struct Started {
    std::unique_ptr<Worker> worker;
    std::string greeting;  // of the child
  };
  // From any thread, several at once. Fails where the child cannot work, or does not greet within limits.seconds.
  [[nodiscard]] tl::expected<Started, Refusal> start(const Limits& limits, const Context& context);

 private:
  [[nodiscard]] tl::expected<void, Refusal> start_server();
  [[nodiscard]] tl::expected<void, Refusal> hear_greeting(const Limits& limits, const Context& context);
  // Waits for the server's end, kills it where it does not end, and returns its status as of waitpid.
  int end_server();
  void kill_server(pid_t server);

  std::vector<std::string> words_;
  std::mutex mutex_;
  Descriptor control_;
  pid_t server_ = -1;
  std::string greeting_;
};

}  // namespace isoextract::sandbox
