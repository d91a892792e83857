// Child processes for work that may crash, hang, use unlimited memory, or be exploited through its input. The way they
// end is returned as a value.
#pragma once

#include <chrono>
#include <cstddef>
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

// How a worker ended.
struct WorkerEnd {
  enum class Reason {
    done,       // exited by itself, or was ended because it sent an invalid message
    signal,     // killed by `signal`
    too_long,   // exceeded its time limit
    cancelled,  // the context was cancelled
    lost,       // could not be started, or its end is unknown
  };
  Reason reason = Reason::lost;
  int signal = 0;
  bool memory_was_refused = false;  // the memory limit refused an allocation of the worker
};

// One child process; killed when this object is destroyed. Use it from one thread at a time.
class Worker {
 public:
  // `kill_server` kills the server, the process that the worker was forked from, and with it the worker. Worker calls
  // it if the server does not end the worker within about 2 s of the request.
  Worker(Descriptor socket, Descriptor status, Descriptor output, std::uint64_t seconds, Context context,
         std::function<void()> kill_server);
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;
  ~Worker();

  // Sends without blocking. After a failure, receive() returns nothing and ending() tells how the worker ended.
  void send(const MessageWriter& message, int descriptor = -1);
  // Returns the next message. Returns nothing if the worker ended or had to be ended; see ending().
  [[nodiscard]] std::optional<MessageReader> receive();
  // Receives bytes that follow a message. Returns false if the worker ended before sending them all.
  [[nodiscard]] bool receive_bytes(std::span<std::byte> to);
  // Stops reading messages and waits for the worker to end. Afterwards the worker can no longer access shared memory.
  const WorkerEnd& finish();
  [[nodiscard]] const WorkerEnd& ending() const { return *ending_; }
  // Returns the beginning of the worker's output.
  [[nodiscard]] const std::string& output() const { return output_; }

 private:
  enum class ReadStatus : std::uint8_t { data, nothing, closed };

  void wait_interval(bool for_messages);
  void count_time_since(std::chrono::steady_clock::time_point before);
  void read_output();
  [[nodiscard]] ReadStatus read_socket();
  void read_status();
  void end_process(WorkerEnd::Reason reason);
  [[nodiscard]] std::optional<MessageReader> take_message();

  Descriptor socket_;
  Descriptor status_;
  Descriptor output_pipe_;
  std::int64_t microseconds_left_ = 0;
  Context context_;
  std::function<void()> kill_server_;
  int waits_since_end_request_ = 0;  // at kMaxWaitsForEnd (about 2 s), kill_server_ is called
  [[nodiscard]] std::span<const std::byte> not_taken() const;

  std::vector<std::byte> received_;
  std::size_t taken_ = 0;  // bytes at the start of received_ that were returned as messages
  std::string output_;
  std::optional<WorkerEnd::Reason> requested_end_;
  std::optional<WorkerEnd> ending_;
};

// Why no worker could be started.
struct Refusal {
  std::string what;    // the problem: "has version 1 of the interface, expected 2"
  std::string advice;  // suggested action; may be empty
};

// The workers of one library. A server process loads the library and forks the workers; it starts with the first worker
// and ends with this object.
class WorkerPool {
 public:
  // `words` are arguments for the server process: run_as_child() reads from them which work to do.
  explicit WorkerPool(std::vector<std::string> words) : words_(std::move(words)) {}
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;
  ~WorkerPool();

  struct Started {
    std::unique_ptr<Worker> worker;
    std::string greeting;  // text that the server sent when it was ready (ChildWork::greeting)
  };
  // Starts a worker. Safe to call from several threads. Fails if the server process does not start, cannot load its
  // library, or sends no greeting within limits.seconds or before the context is cancelled. Callers whose context is
  // cancelled report the error of Context::check() instead of the Refusal.
  [[nodiscard]] tl::expected<Started, Refusal> start(const Limits& limits, const Context& context);

 private:
  [[nodiscard]] tl::expected<void, Refusal> start_server();
  [[nodiscard]] tl::expected<void, Refusal> wait_for_greeting(const Limits& limits, const Context& context);
  // Waits for the server to end, kills it if it does not, and returns its status in the form of waitpid.
  int end_server();
  void kill_server(pid_t server);

  std::vector<std::string> words_;
  std::mutex mutex_;
  Descriptor control_;
  pid_t server_ = -1;
  std::string greeting_;
};

}  // namespace isoextract::sandbox
