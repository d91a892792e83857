#include "sandbox/worker.hpp"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <limits>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "sandbox/detail/server.hpp"
#include "sandbox/program.hpp"

namespace isoextract::sandbox {
namespace {

constexpr std::size_t kMostOutput = 4096;
constexpr int kIntervalMilliseconds = 50;  // interval between checks for cancellation
constexpr int kMaxWaitsForEnd = 40;        // intervals that a process gets to end before it is killed
constexpr int kShortWaits = 50;            // waits of 1 ms, in which a server usually ends

bool socket_pair(int type, std::array<Descriptor, 2>& sockets) {
  std::array<int, 2> numbers{-1, -1};
  if (::socketpair(AF_UNIX, type | SOCK_CLOEXEC, 0, numbers.data()) != 0) return false;
  sockets = {Descriptor(numbers[0]), Descriptor(numbers[1])};
  return true;
}

bool pipe_pair(std::array<Descriptor, 2>& ends) {
  std::array<int, 2> numbers{-1, -1};
  if (::pipe2(numbers.data(), O_CLOEXEC) != 0) return false;
  ends = {Descriptor(numbers[0]), Descriptor(numbers[1])};
  ::fcntl(numbers[0], F_SETFL, O_NONBLOCK);
  return true;
}

std::string last_error() { return std::strerror(errno); }  // NOLINT(concurrency-mt-unsafe): glibc's is safe

}  // namespace

Worker::Worker(Descriptor socket, Descriptor status, Descriptor output, std::uint64_t seconds, Context context,
               std::function<void()> kill_server)
    : socket_(std::move(socket)),
      status_(std::move(status)),
      output_pipe_(std::move(output)),
      microseconds_left_(static_cast<std::int64_t>(std::min<std::uint64_t>(seconds, 1U << 30U)) * 1'000'000),
      context_(std::move(context)),
      kill_server_(std::move(kill_server)) {}

Worker::~Worker() {
  if (ending_) return;
  end_process(WorkerEnd::Reason::cancelled);
  finish();
}

void Worker::send(const MessageWriter& message, int descriptor) {
  if (!send_message(socket_.get(), message, descriptor, false)) socket_.close();
}

std::optional<MessageReader> Worker::receive() {
  for (;;) {
    if (auto message = take_message()) return message;
    const auto before = std::chrono::steady_clock::now();
    const ReadStatus status = read_socket();
    count_time_since(before);  // a worker that never stops sending would otherwise have no time limit
    if (requested_end_) break;
    if (status == ReadStatus::data) continue;
    // A worker that closed its socket before it was done has ended or is about to be ended.
    if (status == ReadStatus::closed || ending_) break;
    wait_interval(true);
  }
  finish();
  return std::nullopt;
}

bool Worker::receive_bytes(std::span<std::byte> to) {
  const std::span<const std::byte> kept = not_taken().first(std::min(not_taken().size(), to.size()));
  std::ranges::copy(kept, to.begin());
  taken_ += kept.size();
  to = to.subspan(kept.size());
  while (!to.empty() && socket_.is_open()) {
    const ssize_t got = ::recv(socket_.get(), to.data(), to.size(), MSG_DONTWAIT);
    if (got > 0) {
      to = to.subspan(static_cast<std::size_t>(got));
    } else if (got < 0 && (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR)) {
      if (ending_) break;
      wait_interval(true);
    } else {
      break;
    }
  }
  if (!to.empty()) finish();
  return to.empty();
}

const WorkerEnd& Worker::finish() {
  socket_.close();
  while (!ending_) wait_interval(false);
  read_output();
  return *ending_;
}

// Waits for data or the end of an interval.
void Worker::wait_interval(bool for_messages) {
  std::array<pollfd, 3> awaited{pollfd{status_.get(), POLLIN, 0}, pollfd{output_pipe_.get(), POLLIN, 0},
                                pollfd{for_messages ? socket_.get() : -1, POLLIN, 0}};
  const auto before = std::chrono::steady_clock::now();
  ::poll(awaited.data(), awaited.size(), kIntervalMilliseconds);
  if (awaited[1].revents != 0) read_output();
  if (awaited[0].revents != 0) read_status();
  if (ending_) return;
  if (requested_end_ && ++waits_since_end_request_ == kMaxWaitsForEnd) {
    kill_server_();  // the server may have been stopped by SIGSTOP
  }
  if (!requested_end_ && context_.cancelled()) end_process(WorkerEnd::Reason::cancelled);
  count_time_since(before);
}

// Ends the worker at its time limit. Counts at most one interval, and so not the time in which this process was
// stopped.
void Worker::count_time_since(std::chrono::steady_clock::time_point before) {
  const auto passed =
      std::chrono::duration_cast<std::chrono::microseconds>(std::chrono::steady_clock::now() - before).count();
  microseconds_left_ -= std::min<std::int64_t>(passed, 1000 * kIntervalMilliseconds);
  if (microseconds_left_ <= 0 && !requested_end_ && !ending_) end_process(WorkerEnd::Reason::too_long);
}

void Worker::end_process(WorkerEnd::Reason reason) {
  requested_end_ = reason;
  constexpr std::byte kEnd{1};
  if (::send(status_.get(), &kEnd, 1, MSG_NOSIGNAL | MSG_DONTWAIT) != 1) ending_ = WorkerEnd{.reason = reason};
}

void Worker::read_output() {
  std::array<char, 4096> part{};
  for (ssize_t got = 0; output_pipe_.is_open() && (got = ::read(output_pipe_.get(), part.data(), part.size())) != -1;) {
    if (got == 0) output_pipe_.close();
    const auto room = kMostOutput - std::min(output_.size(), kMostOutput);
    output_.append(part.data(), std::min(static_cast<std::size_t>(got), room));
  }
}

Worker::ReadStatus Worker::read_socket() {
  if (!socket_.is_open()) return ReadStatus::closed;
  received_.erase(received_.begin(), received_.begin() + static_cast<std::ptrdiff_t>(taken_));
  taken_ = 0;
  std::array<std::byte, 16384> part{};
  const ssize_t got = ::recv(socket_.get(), part.data(), part.size(), MSG_DONTWAIT);
  if (got < 0 && (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR)) return ReadStatus::nothing;
  if (got <= 0) return ReadStatus::closed;
  received_.insert(received_.end(), part.begin(), part.begin() + got);
  return ReadStatus::data;
}

std::span<const std::byte> Worker::not_taken() const { return std::span(received_).subspan(taken_); }

std::optional<MessageReader> Worker::take_message() {
  std::uint64_t length = 0;
  if (not_taken().size() < sizeof(length)) return std::nullopt;
  std::memcpy(&length, not_taken().data(), sizeof(length));
  if (length > kMaxMessageBytes) {  // not a valid message
    socket_.close();
    end_process(WorkerEnd::Reason::done);
    return std::nullopt;
  }
  if (length > not_taken().size() - sizeof(length)) return std::nullopt;
  const auto bytes = not_taken().subspan(sizeof(length), length);
  taken_ += sizeof(length) + length;
  return MessageReader(std::vector(bytes.begin(), bytes.end()));
}

void Worker::read_status() {
  detail::WorkerStatus status;
  const ssize_t got = ::recv(status_.get(), &status, sizeof(status), MSG_DONTWAIT);
  if (got < 0 && (errno == EINTR || errno == EAGAIN || errno == EWOULDBLOCK)) return;
  WorkerEnd ending;
  if (got == sizeof(status) && status.wait_status != -1) {
    ending.memory_was_refused = status.memory_was_refused != 0;
    ending.reason = WorkerEnd::Reason::done;
    if (WIFSIGNALED(status.wait_status)) {
      ending.reason = WorkerEnd::Reason::signal;
      ending.signal = WTERMSIG(status.wait_status);
      if (ending.signal == SIGXCPU) ending.reason = WorkerEnd::Reason::too_long;
    }
  }
  if (requested_end_) ending.reason = *requested_end_;
  ending_ = ending;
}

WorkerPool::~WorkerPool() { end_server(); }

int WorkerPool::end_server() {
  control_.close();
  int status = 0;
  constexpr int kWaits = kShortWaits + kMaxWaitsForEnd;
  for (int wait = 0; server_ > 0; ++wait) {
    if (wait == kWaits) ::kill(server_, SIGKILL);
    const pid_t ended = ::waitpid(server_, &status, wait < kWaits ? WNOHANG : 0);
    if (ended == server_ || (ended < 0 && errno != EINTR)) break;
    if (ended == 0) ::poll(nullptr, 0, wait < kShortWaits ? 1 : kIntervalMilliseconds);
  }
  server_ = -1;
  return status;
}

void WorkerPool::kill_server(pid_t server) {
  const std::scoped_lock lock(mutex_);
  if (server_ == server && server_ > 0) ::kill(server_, SIGKILL);
}

// Waits until the child has loaded its library: it sends its greeting, ends, exceeds the time limit, or is cancelled.
tl::expected<void, Refusal> WorkerPool::wait_for_greeting(const Limits& limits, const Context& context) {
  std::uint64_t milliseconds_left = std::min<std::uint64_t>(limits.seconds, 1U << 30U) * 1000;
  pollfd awaited{control_.get(), POLLIN, 0};
  while (::poll(&awaited, 1, kIntervalMilliseconds) <= 0) {
    milliseconds_left -= std::min<std::uint64_t>(milliseconds_left, kIntervalMilliseconds);
    const bool is_cancelled = context.cancelled();
    if (milliseconds_left > 0 && !is_cancelled) continue;
    ::kill(server_, SIGKILL);
    end_server();
    if (is_cancelled) return tl::unexpected(Refusal{"stops loading, because the run ends", {}});
    return tl::unexpected(Refusal{fmt::format("takes more than {} s to load", limits.seconds),
                                  "try again; if that fails too, install the plug-in that belongs to this version"});
  }
  auto greeting = receive_message(control_.get());
  if (!greeting) {
    const int status = end_server();
    if (WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL) {
      return tl::unexpected(
          Refusal{"does not load: the system killed the process that loads it, as systems do when they lack memory",
                  "try again, with more memory"});
    }
    return tl::unexpected(Refusal{"ends the process that loads it", {}});
  }
  const bool can_work = greeting->message.number() == 1;
  greeting_ = greeting->message.text();
  if (can_work) return {};
  end_server();
  return tl::unexpected(Refusal{greeting_, greeting->message.text()});
}

tl::expected<void, Refusal> WorkerPool::start_server() {
  const auto cannot_start = [] { return tl::unexpected(Refusal{"does not start: " + last_error(), {}}); };
  std::array<Descriptor, 2> control;
  if (!socket_pair(SOCK_STREAM, control)) return cannot_start();
  const std::vector<std::string> words = command_line_with(words_);
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));  // NOLINT: posix_spawn's
  arguments.push_back(nullptr);

  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_adddup2(&files, STDOUT_FILENO, STDERR_FILENO);
  posix_spawn_file_actions_adddup2(&files, control[1].get(), detail::kControlSocket);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none;
  sigemptyset(&none);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
  const int failed = ::posix_spawn(&server_, "/proc/self/exe", &files, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  if (failed != 0) {
    server_ = -1;
    errno = failed;
    return cannot_start();
  }
  control[1].close();
  control_ = std::move(control[0]);
  return {};
}

tl::expected<WorkerPool::Started, Refusal> WorkerPool::start(const Limits& limits, const Context& context) {
  std::array<Descriptor, 2> socket;
  std::array<Descriptor, 2> status;
  std::array<Descriptor, 2> output;
  if (!socket_pair(SOCK_STREAM, socket) || !socket_pair(SOCK_SEQPACKET, status) || !pipe_pair(output)) {
    return tl::unexpected(Refusal{"does not start: " + last_error(), {}});
  }
  const std::array along{socket[1].get(), status[1].get(), output[1].get()};
  const std::scoped_lock lock(mutex_);
  // Restarts the server if it has ended since the last worker, for example killed by the system.
  if (!control_.is_open() || !send_descriptors(control_.get(), along)) {
    end_server();
    TRY(start_server());
    TRY(wait_for_greeting(limits, context));
    if (!send_descriptors(control_.get(), along)) {
      end_server();
      return tl::unexpected(Refusal{"ends the process that loaded it", {}});
    }
  }
  Started started{std::make_unique<Worker>(std::move(socket[0]), std::move(status[0]), std::move(output[0]),
                                           limits.seconds, context, [this, server = server_] { kill_server(server); }),
                  greeting_};
  started.worker->send(MessageWriter().number(limits.memory).number(limits.seconds).number(limits.threads));
  return started;
}

}  // namespace isoextract::sandbox
