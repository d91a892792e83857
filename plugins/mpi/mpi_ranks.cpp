// Connects ranks by MPI (ranks_plugin.h). Communication is nonblocking, and a waiting thread sleeps between polls:
// MPI's own waiting functions would keep a processor busy.
#include <ranks_plugin.h>

#include <algorithm>
#include <chrono>
#include <climits>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <mutex>
#include <new>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <dlfcn.h>
#include <mpi.h>

namespace {

using Clock = std::chrono::steady_clock;

constexpr int kMessageTag = 1;
constexpr std::chrono::microseconds kShortestSleep{20};
constexpr std::chrono::microseconds kLongestSleep{2000};

thread_local std::string last_error;

class Link {
 public:
  static Link& get() {
    static Link link;
    return link;
  }

  void join(isoextract_rank& own) {
    // Open MPI loads its components as libraries, which look up Open MPI's symbols in the global scope.
    Dl_info library{};
    if (::dladdr(reinterpret_cast<void*>(&MPI_Init_thread), &library) != 0) {
      ::dlopen(library.dli_fname, RTLD_NOW | RTLD_GLOBAL | RTLD_NOLOAD);
    }
    int provided = 0;
    check(MPI_Init_thread(nullptr, nullptr, MPI_THREAD_SERIALIZED, &provided));
    if (provided < MPI_THREAD_SERIALIZED) throw std::runtime_error("this MPI does not support threads");
    check(MPI_Comm_dup(MPI_COMM_WORLD, &all_));
    check(MPI_Comm_set_errhandler(all_, MPI_ERRORS_RETURN));
    check(MPI_Comm_rank(all_, &own.rank));
    check(MPI_Comm_size(all_, &size_));
    own.size = size_;
    MPI_Comm node = MPI_COMM_NULL;
    check(MPI_Comm_split_type(all_, MPI_COMM_TYPE_SHARED, own.rank, MPI_INFO_NULL, &node));
    check(MPI_Allreduce(&own.rank, &own.node, 1, MPI_INT, MPI_MIN, node));
    check(MPI_Comm_free(&node));
  }

  const void* gather(const void* bytes, std::uint64_t count, std::uint64_t* sizes) {
    const auto ranks = static_cast<std::size_t>(size_);
    wait_for([&](MPI_Request& request) {
      return MPI_Iallgather(&count, 1, MPI_UINT64_T, sizes, 1, MPI_UINT64_T, all_, &request);
    });
    std::vector<int> counts(ranks);
    std::vector<int> places(ranks);
    std::uint64_t total = 0;
    for (std::size_t r = 0; r < ranks; ++r) {
      if (total + sizes[r] > INT_MAX) throw std::runtime_error("the ranks exchange more than 2 GiB");
      counts[r] = static_cast<int>(sizes[r]);
      places[r] = static_cast<int>(total);
      total += sizes[r];
    }
    allocate(total);
    wait_for([&](MPI_Request& request) {
      return MPI_Iallgatherv(bytes, static_cast<int>(count), MPI_BYTE, gathered_.data(), counts.data(), places.data(),
                             MPI_BYTE, all_, &request);
    });
    return gathered_.data();
  }

  // Makes gathered_ large enough. Long messages could exceed the memory of one rank only: then all ranks fail, since a
  // rank that left alone would make the others wait for ever.
  void allocate(std::uint64_t total) {
    constexpr std::uint64_t kLong = std::uint64_t{1} << 20U;
    if (total <= kLong && gathered_.size() > kLong) gathered_ = {};
    if (total <= kLong) {
      gathered_.resize(std::max<std::size_t>(total, 1));
      return;
    }
    std::uint8_t fails = 0;
    try {
      gathered_.resize(total);
    } catch (const std::bad_alloc&) {
      fails = 1;
    }
    std::uint8_t any_fails = 0;
    wait_for([&](MPI_Request& request) {
      return MPI_Iallreduce(&fails, &any_fails, 1, MPI_UINT8_T, MPI_MAX, all_, &request);
    });
    if (any_fails != 0) throw std::runtime_error("a rank lacks the memory for a message of the others");
  }

  void send(int to, const void* bytes, std::uint64_t count) {
    if (count > INT_MAX) throw std::runtime_error("a message has more than 2 GiB");
    wait_for([&](MPI_Request& request) {
      return MPI_Isend(bytes, static_cast<int>(count), MPI_BYTE, to, kMessageTag, all_, &request);
    });
  }

  const void* receive(int milliseconds, std::int32_t& from, std::uint64_t& count) {
    const auto end = Clock::now() + std::chrono::milliseconds(milliseconds);
    MPI_Message message = MPI_MESSAGE_NULL;
    MPI_Status status;
    const bool came = sleep_until(
        [&] {
          int flag = 0;
          check(MPI_Improbe(MPI_ANY_SOURCE, kMessageTag, all_, &flag, &message, &status));
          return flag != 0;
        },
        end);
    if (!came) return nullptr;
    int bytes = 0;
    check(MPI_Get_count(&status, MPI_BYTE, &bytes));
    received_.resize(std::max<std::size_t>(static_cast<std::size_t>(bytes), 1));
    wait_for([&](MPI_Request& request) { return MPI_Imrecv(received_.data(), bytes, MPI_BYTE, &message, &request); });
    from = status.MPI_SOURCE;
    count = static_cast<std::uint64_t>(bytes);
    return received_.data();
  }

  void leave() {
    // MPI_Finalize() may wait for the other ranks, and then keeps a processor busy.
    wait_for([&](MPI_Request& request) { return MPI_Ibarrier(all_, &request); });
    check(MPI_Comm_free(&all_));
    check(MPI_Finalize());
  }

 private:
  static void check(int code) {
    if (code == MPI_SUCCESS) return;
    char text[MPI_MAX_ERROR_STRING] = {};
    int length = 0;
    MPI_Error_string(code, text, &length);
    throw std::runtime_error("MPI: " + std::string(text, static_cast<std::size_t>(length)));
  }

  // Calls look() until it returns true or the time is over. Holds the lock during the calls only.
  template <class Look>
  bool sleep_until(const Look& look, Clock::time_point end) {
    for (auto pause = kShortestSleep;; pause = std::min(2 * pause, kLongestSleep)) {
      {
        const std::lock_guard lock(mutex_);
        if (look()) return true;
      }
      if (Clock::now() >= end) return false;
      std::this_thread::sleep_for(pause);
    }
  }

  // Starts an operation, and waits until it is complete.
  template <class Start>
  void wait_for(const Start& start) {
    MPI_Request request = MPI_REQUEST_NULL;
    {
      const std::lock_guard lock(mutex_);
      check(start(request));
    }
    sleep_until(
        [&] {
          int done = 0;
          check(MPI_Test(&request, &done, MPI_STATUS_IGNORE));
          return done != 0;
        },
        Clock::time_point::max());
  }

  std::mutex mutex_;  // MPI_THREAD_SERIALIZED: guards every call of MPI
  MPI_Comm all_ = MPI_COMM_NULL;
  int size_ = 1;
  std::vector<std::byte> gathered_;
  std::vector<std::byte> received_;
};

// Runs a step. Returns false on an exception, and keeps its text.
template <class Step>
bool attempt(const Step& step) {
  try {
    step(Link::get());
    return true;
  } catch (const std::exception& error) {
    last_error = error.what();
    std::ranges::replace(last_error, '\n', ' ');
    return false;
  }
}

int join(isoextract_rank* own) {
  return attempt([&](Link& link) { link.join(*own); }) ? 0 : 1;
}

const void* gather(const void* bytes, std::uint64_t count, std::uint64_t* sizes) {
  const void* all = nullptr;
  attempt([&](Link& link) { all = link.gather(bytes, count, sizes); });
  return all;
}

int send(std::int32_t to, const void* bytes, std::uint64_t count) {
  return attempt([&](Link& link) { link.send(to, bytes, count); }) ? 0 : 1;
}

const void* receive(std::int32_t milliseconds, std::int32_t* from, std::uint64_t* count) {
  constexpr std::int32_t kNone = -1;
  constexpr std::int32_t kFailed = -2;
  *from = kNone;
  const void* bytes = nullptr;
  if (!attempt([&](Link& link) { bytes = link.receive(milliseconds, *from, *count); })) *from = kFailed;
  return bytes;
}

void leave() {
  attempt([](Link& link) { link.leave(); });
}

const char* error_text() { return last_error.c_str(); }

constexpr isoextract_ranks_plugin_v1 kPlugin{
    ISOEXTRACT_RANKS_PLUGIN_VERSION, "mpi", join, gather, send, receive, leave, error_text};

}  // namespace

extern "C" const isoextract_ranks_plugin_v1* isoextract_ranks_plugin() { return &kPlugin; }
