// Memory of the arrays of a surface net and of the voxels of its labels: reserved memory, or temporary files if the
// memory limit does not hold them. Passes over the chunks of the net then give pages back as they advance.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/context.hpp"
#include "base/parallel.hpp"
#include "files/work_memory.hpp"

namespace isoextract::extract {

// Arrays from this size on may go to temporary files.
inline constexpr std::uint64_t kLeastNetFile = std::uint64_t{4} << 20U;  // bytes

// A fixed-size array with undefined elements. Movable; a moved-from array must not be used.
template <class T>
class NetArray {
  static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T>);

 public:
  NetArray() = default;

  [[nodiscard]] T* data() { return values_.data(); }
  [[nodiscard]] const T* data() const { return values_.data(); }
  [[nodiscard]] std::size_t size() const { return values_.size(); }
  [[nodiscard]] T& operator[](std::size_t i) { return values_[i]; }
  [[nodiscard]] const T& operator[](std::size_t i) const { return values_[i]; }
  [[nodiscard]] T* begin() { return data(); }
  [[nodiscard]] T* end() { return data() + size(); }
  [[nodiscard]] const T* begin() const { return data(); }
  [[nodiscard]] const T* end() const { return data() + size(); }
  [[nodiscard]] std::span<T> span() { return values_; }

  [[nodiscard]] bool is_in_file() const { return owner_ != nullptr && owner_->is_in_file(); }
  // If the array is in a file, gives the pages of all or some elements back to the system.
  void leave() const { leave(values_); }
  void leave(std::span<const T> part) const {
    if (owner_ != nullptr) owner_->leave(std::as_bytes(part));
  }

 private:
  friend class NetMemory;
  NetArray(std::span<T> values, std::shared_ptr<files::WorkMemory> owner) : values_(values), owner_(std::move(owner)) {}

  std::span<T> values_;
  std::shared_ptr<files::WorkMemory> owner_;
};

// Safe to use from several threads.
class NetMemory {
 public:
  // `what` starts messages about memory.
  NetMemory(Context context, std::string what) : context_(std::move(context)), what_(std::move(what)) {}
  NetMemory(const NetMemory&) = delete;
  NetMemory& operator=(const NetMemory&) = delete;

  [[nodiscard]] const Context& context() const { return context_; }
  [[nodiscard]] const std::string& what() const { return what_; }

  // Returns whether arrays of so many bytes in all belong in files: if they take more than half of the memory limit.
  // The other half is for the meshes.
  [[nodiscard]] static bool prefers_files(std::uint64_t bytes, const Context& context) {
    return bytes > context.memory().limit() / 2;
  }
  // Tells the bytes of all arrays that may go to files, for hints.
  void expect(std::uint64_t bytes) { expected_bytes_ = bytes; }
  // Returns about how many bytes of arrays in files a pass has in memory at a time.
  [[nodiscard]] static std::uint64_t run_bytes(const Context& context) { return context.memory().limit() / 8; }
  // Makes later arrays prefer files. They never prefer memory again.
  void use_files() { uses_files_ = true; }
  [[nodiscard]] bool uses_files() const { return uses_files_; }

  // Makes an array in memory. Makes it in a file if files are in use, if the arrays in memory would take more than half
  // of the memory limit, or if memory runs out. Fails if neither has space.
  template <class T>
  [[nodiscard]] Result<NetArray<T>> make(std::size_t count) {
    auto memory = TRY(files::WorkMemory::make(count * sizeof(T), use(count * sizeof(T)), context_, what_));
    return array_in<T>(keep(std::move(memory)), count);
  }

  // Makes an array in a file. Fails with `refusal` as files::WorkMemory::make_in_file().
  template <class T>
  [[nodiscard]] Result<NetArray<T>> make_in_file(std::size_t count, Error refusal) {
    auto memory = TRY(files::WorkMemory::make_in_file(count * sizeof(T), use(count * sizeof(T)), std::move(refusal)));
    return array_in<T>(keep(std::move(memory)), count);
  }

  // Calls f(begin, end) for all indices from 0 to count - 1, run by run. With arrays in files, there are several runs,
  // and leave() follows each. The indices are assumed to use all arrays evenly. Ends early if the context is cancelled.
  template <class F>
  void for_each_run(std::size_t count, const F& f) const {
    for_each_run(count, run_length(count, bytes_in_files()), f, [this] { leave(); });
  }
  // Does the same for the indices of one array, and leaves only this array.
  template <class T, class F>
  void for_each_run_of(const NetArray<T>& values, const F& f) const {
    const std::uint64_t bytes = values.is_in_file() ? values.size() * sizeof(T) : 0;
    for_each_run(values.size(), run_length(values.size(), bytes), f, [&] { values.leave(); });
  }
  // Calls f(chunk) for all chunks of a net, in parallel within each run.
  template <class F>
  void for_each_chunk(std::size_t chunks, const F& f) const {
    for_each_run(chunks, [&](std::size_t begin, std::size_t end) {
      for_each_index(end - begin, [&](std::size_t c) { f(begin + c); });
    });
  }
  // Fills an array with equal values, in parallel, because the system takes long to clear new pages.
  template <class T>
  void fill(NetArray<T>& values, const T& value) const {
    constexpr std::size_t kGrain = 1 << 16;
    for_each_run_of(values, [&](std::size_t begin, std::size_t end) {
      for_each_range(end - begin, kGrain, [&](std::size_t first, std::size_t last) {
        std::fill(values.begin() + begin + first, values.begin() + begin + last, value);
      });
    });
  }

  // Gives the pages of all arrays in files back to the system, which keeps their contents.
  void leave() const;
  // Does so once all calls together told that about run_bytes() were used. For work that uses little at a time.
  void leave_after(std::uint64_t used_bytes) const;
  // Returns the bytes of all arrays in files: those of now, and the most at a time.
  [[nodiscard]] std::uint64_t bytes_in_files() const { return bytes_of(true); }
  [[nodiscard]] std::uint64_t most_in_files() const { return most_in_files_; }
  // Fails with ErrorCode::input if the disk lost a part of an array in a file.
  [[nodiscard]] Result<void> check() const;

 private:
  template <class T>
  [[nodiscard]] static NetArray<T> array_in(std::shared_ptr<files::WorkMemory> owner, std::size_t count) {
    const std::span<T> values(reinterpret_cast<T*>(owner->bytes().data()), count);
    return NetArray<T>(values, std::move(owner));
  }
  template <class F, class Leave>
  void for_each_run(std::size_t count, std::size_t run, const F& f, const Leave& leave_run) const {
    for (std::size_t begin = 0; begin < count && !context_.cancelled(); begin += run) {
      f(begin, std::min(begin + run, count));
      if (run < count) leave_run();
    }
  }
  // Returns when an array of so many bytes goes to a file.
  [[nodiscard]] files::FileUse use(std::uint64_t bytes) const;
  [[nodiscard]] std::shared_ptr<files::WorkMemory> keep(files::WorkMemory memory);
  // Returns how many of `count` indices a run takes if all of them use so many bytes in files.
  [[nodiscard]] std::size_t run_length(std::size_t count, std::uint64_t bytes) const;
  // Returns the arrays in files, or those in memory, and their bytes.
  [[nodiscard]] std::vector<std::shared_ptr<files::WorkMemory>> list(bool in_files) const;
  [[nodiscard]] std::uint64_t bytes_of(bool in_files) const;

  Context context_;
  std::string what_;
  std::atomic<bool> uses_files_ = false;
  std::uint64_t expected_bytes_ = 0;
  std::atomic<std::uint64_t> most_in_files_ = 0;
  mutable std::atomic<std::uint64_t> used_bytes_ = 0;  // since the last leave() of leave_after()
  mutable std::mutex mutex_;
  mutable std::vector<std::weak_ptr<files::WorkMemory>> arrays_;
};

}  // namespace isoextract::extract
