#include "sandbox/detail/server.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/signalfd.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <new>
#include <string>
#include <thread>
#include <vector>

#include "sandbox/limits.hpp"
#include "sandbox/message.hpp"

namespace isoextract::sandbox::detail {
namespace {

// Uses one system call if Linux has it (5.9).
void close_from(int first) {
#ifdef __NR_close_range
  if (::syscall(__NR_close_range, first, ~0U, 0) == 0) return;
#endif
  constexpr int kMost = 4096;
  for (int number = first; number < kMost; ++number) ::close(number);
}

// Returns whether all other threads sleep: then none holds a lock that a forked process would wait for.
bool other_threads_sleep() {
  std::error_code error;
  const std::string self = std::to_string(::getpid());
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task", error)) {
    if (task.path().filename() == self) continue;
    std::ifstream file(task.path() / "stat");
    std::string text;
    std::getline(file, text);
    const std::size_t name_end = text.rfind(')');
    if (name_end != std::string::npos && name_end + 2 < text.size() && text[name_end + 2] != 'S') return false;
  }
  return true;
}

// Libraries may start threads when they are loaded, as OpenVDB's log4cplus does. They soon sleep, waiting for work that
// never comes.
void wait_for_other_threads() {
  for (int tried = 0; tried < 200 && !other_threads_sleep(); ++tried) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

// Memory that a worker and this process share.
struct Shared {
  std::atomic<std::int32_t> memory_was_refused{0};
};

Shared* make_shared_page() {
  void* page = ::mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  return page == MAP_FAILED ? nullptr : new (page) Shared;
}

Shared* own_page = nullptr;  // set in a worker

void note_lack_of_memory() {
  own_page->memory_was_refused = 1;
  throw std::bad_alloc();
}

struct Running {
  pid_t process = -1;
  Descriptor status;
  Shared* shared = nullptr;
};

class Server {
 public:
  explicit Server(const ChildWork& work) : work_(work) {
    sigset_t ended;
    sigemptyset(&ended);
    sigaddset(&ended, SIGCHLD);
    ::sigprocmask(SIG_BLOCK, &ended, &usual_signals_);
    signals_ = Descriptor(::signalfd(-1, &ended, SFD_CLOEXEC | SFD_NONBLOCK));
  }

  void run() {
    for (;;) {
      std::vector<pollfd> awaited{{kControlSocket, POLLIN, 0}, {signals_.get(), POLLIN, 0}};
      for (const Running& worker : running_) awaited.push_back({worker.status.get(), POLLIN, 0});
      if (::poll(awaited.data(), awaited.size(), -1) < 0 && errno != EINTR) break;
      for (std::size_t i = 0; i < running_.size(); ++i) {
        if (awaited[i + 2].revents != 0) end(running_[i]);
      }
      if (awaited[1].revents != 0) bury();
      if (awaited[0].revents != 0 && !start()) break;
    }
    for (const Running& worker : running_) ::kill(worker.process, SIGKILL);
    for (const Running& worker : running_) ::waitpid(worker.process, nullptr, 0);
  }

 private:
  // Returns false if the parent has ended.
  bool start() {
    std::vector<Descriptor> given = receive_descriptors(kControlSocket);
    if (given.size() != 3) return !given.empty();
    const pid_t server = ::getpid();
    Running worker{-1, std::move(given[1]), make_shared_page()};
    if (worker.shared != nullptr) worker.process = ::fork();
    if (worker.process == 0) become_worker(server, given[0].get(), given[2].get(), worker.shared);
    if (worker.process > 0) {
      running_.push_back(std::move(worker));
    } else {
      tell(worker, -1);
    }
    return true;
  }

  [[noreturn]] void become_worker(pid_t server, int socket, int output, Shared* shared) const {
    constexpr int kSocket = kControlSocket;  // a worker does not need the control socket's number
    ::prctl(PR_SET_PDEATHSIG, SIGKILL, 0, 0, 0);
    if (::getppid() != server) ::_exit(1);
    own_page = shared;
    std::set_new_handler(note_lack_of_memory);
    ::dup2(output, STDOUT_FILENO);
    ::dup2(output, STDERR_FILENO);
    ::dup2(socket, kSocket);
    close_from(kSocket + 1);
    ::sigprocmask(SIG_SETMASK, &usual_signals_, nullptr);
    if (auto first = receive_message(kSocket)) {
      Limits limits;
      limits.memory = first->message.number();
      limits.seconds = first->message.number();
      limits.threads = first->message.number();
      apply(limits);
      work_.run(kSocket);
    }
    static_cast<void>(std::fflush(nullptr));
    // Skips the libraries' exit handlers: they take time, and some wait for threads that do not exist after fork().
    ::_exit(0);
  }

  // Calling it twice is harmless: the process ID stays reserved until waitpid().
  static void end(Running& worker) { ::kill(worker.process, SIGKILL); }

  void bury() {
    signalfd_siginfo read{};
    while (::read(signals_.get(), &read, sizeof(read)) > 0) {
    }
    int status = 0;
    for (pid_t process = 0; (process = ::waitpid(-1, &status, WNOHANG)) > 0;) {
      const auto worker = std::ranges::find(running_, process, &Running::process);
      if (worker == running_.end()) continue;
      tell(*worker, status);
      running_.erase(worker);
    }
  }

  static void tell(const Running& worker, int wait_status) {
    WorkerStatus status{wait_status, 0};
    if (worker.shared != nullptr) {
      status.memory_was_refused = worker.shared->memory_was_refused;
      ::munmap(worker.shared, sizeof(Shared));
    }
    static_cast<void>(::send(worker.status.get(), &status, sizeof(status), MSG_NOSIGNAL | MSG_DONTWAIT));
  }

  const ChildWork& work_;
  sigset_t usual_signals_{};
  Descriptor signals_;
  std::vector<Running> running_;
};

}  // namespace

void isolate_server() {
  close_from(kControlSocket + 1);
  ::fcntl(kControlSocket, F_SETFD, FD_CLOEXEC);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGTSTP, SIGPIPE}) ::signal(signal, SIG_IGN);
}

int serve(const ChildWork& work) {
  MessageWriter greeting;
  greeting.number(work.run ? 1 : 0).text(work.greeting).text(work.advice);
  if (!send_message(kControlSocket, greeting) || !work.run) ::_exit(0);
  wait_for_other_threads();
  Server(work).run();
  ::_exit(0);
}

}  // namespace isoextract::sandbox::detail
