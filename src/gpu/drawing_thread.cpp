#include "gpu/drawing_thread.hpp"

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

namespace isoextract::gpu {

// `mutex_` guards the data that pass between the threads. A caller also holds `turn_`, so there is one request at a
// time. Requests live on the stack of the caller, so asking allocates no memory.
class DrawingThread::Owner {
 public:
  explicit Owner(const GpuOptions& options) : options_(options) {}
  Owner(const Owner&) = delete;
  Owner& operator=(const Owner&) = delete;

  ~Owner() {
    {
      const std::lock_guard lock(mutex_);
      ending_ = true;
    }
    changed_.notify_all();
    if (thread_.joinable()) thread_.join();
  }

  Result<void> start() {
    try {
      thread_ = std::thread([this] { work(); });
    } catch (const std::system_error& error) {
      return fail(ErrorCode::unavailable, fmt::format("the drawing thread failed to start: {}", error.what()),
                  {Remedy::use, Setting::cpu_backend});
    }
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return opened_.has_value() || thrown_ != nullptr; });
    if (thrown_ != nullptr) std::rethrow_exception(std::exchange(thrown_, nullptr));
    return *opened_;
  }

  // Valid after start(); never changes.
  [[nodiscard]] const gl::GpuDevice& device() const { return device_; }
  [[nodiscard]] const extract::Extractor& extractor() const { return *extractor_; }

  Result<extract::Extraction> extract(const field::ScalarField& field, const extract::ExtractOptions& options,
                                      const Context& context) {
    const IdleThreads waiting(*this, tbb::this_task_arena::max_concurrency());
    const std::lock_guard turn(turn_);
    std::unique_lock lock(mutex_);
    const Request request{field, options, context};
    request_ = &request;
    changed_.notify_all();
    changed_.wait(lock, [this] { return answer_.has_value() || thrown_ != nullptr; });
    if (thrown_ != nullptr) std::rethrow_exception(std::exchange(thrown_, nullptr));
    Result<extract::Extraction> answer = std::move(*answer_);
    answer_.reset();
    return answer;
  }

 private:
  struct Request {
    const field::ScalarField& field;
    const extract::ExtractOptions& options;
    const Context& context;
  };

  // Counts the oneTBB threads that a waiting caller leaves idle.
  class IdleThreads {
   public:
    IdleThreads(Owner& owner, int threads) : owner_(owner), threads_(threads) {
      const std::lock_guard lock(owner_.mutex_);
      owner_.waiting_threads_ += threads_;
    }
    IdleThreads(const IdleThreads&) = delete;
    IdleThreads& operator=(const IdleThreads&) = delete;
    ~IdleThreads() {
      const std::lock_guard lock(owner_.mutex_);
      owner_.waiting_threads_ -= threads_;
    }

   private:
    Owner& owner_;
    int threads_;
  };

  void work() {
    open();
    std::unique_lock lock(mutex_);
    for (;;) {
      changed_.wait(lock, [this] { return ending_ || request_ != nullptr; });
      if (request_ == nullptr) break;
      const Request& request = *std::exchange(request_, nullptr);  // valid: the caller waits
      const int threads = waiting_threads_;
      lock.unlock();
      std::optional<Result<extract::Extraction>> answer;
      std::exception_ptr thrown;
      try {
        run(request, threads, answer);
      } catch (...) {
        thrown = std::current_exception();
      }
      lock.lock();
      answer_ = std::move(answer);
      thrown_ = std::move(thrown);
      changed_.notify_all();
    }
    lock.unlock();
    extractor_.reset();  // destroy it on its own thread
  }

  void open() {
    Result<void> opened;
    std::exception_ptr thrown;
    try {
      auto made = make_gpu_extractor(options_);
      if (made) {
        extractor_ = std::move(made->extractor);
        device_ = std::move(made->device);
      } else {
        opened = tl::unexpected(std::move(made.error()));
      }
    } catch (...) {
      thrown = std::current_exception();
    }
    const std::lock_guard lock(mutex_);
    opened_ = std::move(opened);
    thrown_ = std::move(thrown);
    changed_.notify_all();
  }

  void run(const Request& request, int threads, std::optional<Result<extract::Extraction>>& answer) {
    const auto allowed = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
    tbb::task_arena arena(
        std::max(1, static_cast<int>(std::min<std::size_t>(allowed, static_cast<std::size_t>(threads)))));
    arena.execute([&] { answer.emplace(extractor_->extract(request.field, request.options, request.context)); });
  }

  const GpuOptions options_;
  std::unique_ptr<extract::Extractor> extractor_;
  gl::GpuDevice device_;

  std::mutex turn_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<Result<void>> opened_;
  const Request* request_ = nullptr;
  std::optional<Result<extract::Extraction>> answer_;
  std::exception_ptr thrown_;
  int waiting_threads_ = 0;
  bool ending_ = false;
  std::thread thread_;
};

class DrawingThread::Proxy final : public extract::Extractor {
 public:
  explicit Proxy(std::shared_ptr<Owner> owner) : owner_(std::move(owner)) {}

  [[nodiscard]] std::string_view name() const override { return owner_->extractor().name(); }
  [[nodiscard]] std::string device() const override { return owner_->extractor().device(); }
  [[nodiscard]] bool has(extract::Method method) const override { return owner_->extractor().has(method); }

 private:
  [[nodiscard]] Result<extract::Extraction> run(const field::ScalarField& field, const extract::ExtractOptions& options,
                                                const Context& context) override {
    return owner_->extract(field, options, context);
  }

  std::shared_ptr<Owner> owner_;
};

Result<DrawingThread> DrawingThread::start(const GpuOptions& options) {
  auto owner = std::make_shared<Owner>(options);
  TRY(owner->start());
  return DrawingThread(std::move(owner));
}

const gl::GpuDevice& DrawingThread::device() const { return owner_->device(); }

std::unique_ptr<extract::Extractor> DrawingThread::extractor() const { return std::make_unique<Proxy>(owner_); }

}  // namespace isoextract::gpu
