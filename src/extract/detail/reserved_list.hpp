// Growing lists that reserve their memory in the budget before they allocate it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/context.hpp"

namespace isoextract::extract {

template <class T>
class ReservedList {
 public:
  static constexpr std::size_t kLeastCapacity = 32;  // of a list that is not empty

  // `what` starts the message if memory runs out. The context and `what` must outlive the list.
  ReservedList(const Context& context, const std::string& what) : context_(&context), what_(&what) {}

  // Appends a value. Returns false if memory ran out; error() then has the reason, and the list adds no more values.
  bool add(const T& value) {
    if (values_.size() == values_.capacity() && !grow()) return false;
    values_.push_back(value);
    return true;
  }

  [[nodiscard]] const std::vector<T>& values() const { return values_; }
  [[nodiscard]] std::vector<T>& values() { return values_; }
  [[nodiscard]] const std::optional<Error>& error() const { return error_; }

 private:
  bool grow() {
    if (error_) return false;
    const std::size_t wanted = std::max(2 * values_.capacity(), kLeastCapacity);
    auto memory = context_->reserve(wanted * sizeof(T), *what_);
    if (!memory) {
      error_ = std::move(memory.error());
      return false;
    }
    values_.reserve(wanted);
    memory_ = std::move(*memory);
    return true;
  }

  const Context* context_;
  const std::string* what_;
  std::vector<T> values_;
  Reservation memory_;
  std::optional<Error> error_;
};

// A list in blocks, for large values: it grows without copies, and leaves at most one block partly empty. Values keep
// their addresses, even if the list moves.
template <class T>
class ReservedBlocks {
 public:
  // Takes the arguments of a ReservedList.
  ReservedBlocks(const Context& context, const std::string& what) : context_(&context), what_(&what) {}

  // Appends a value. Returns its place, or null if memory ran out; error() then has the reason.
  T* add(const T& value) {
    if ((blocks_.empty() || blocks_.back().size() == kBlockValues) && !grow()) return nullptr;
    return &blocks_.back().emplace_back(value);
  }

  // Frees all values.
  void clear() {
    blocks_.clear();
    memory_.release();
  }

  [[nodiscard]] std::size_t size() const {
    return blocks_.empty() ? 0 : kBlockValues * (blocks_.size() - 1) + blocks_.back().size();
  }
  [[nodiscard]] const std::optional<Error>& error() const { return error_; }

  // Calls f(value) for the values in their order.
  template <class F>
  void for_each(const F& f) const {
    for (const std::vector<T>& block : blocks_) {
      for (const T& value : block) f(value);
    }
  }
  template <class F>
  void for_each(const F& f) {
    for (std::vector<T>& block : blocks_) {
      for (T& value : block) f(value);
    }
  }

 private:
  static constexpr std::size_t kBlockValues = 16;

  bool grow() {
    if (error_) return false;
    auto memory = context_->reserve(kBlockValues * sizeof(T), *what_);
    if (!memory) {
      error_ = std::move(memory.error());
      return false;
    }
    memory_.take(std::move(*memory));
    blocks_.emplace_back().reserve(kBlockValues);
    return true;
  }

  const Context* context_;
  const std::string* what_;
  std::vector<std::vector<T>> blocks_;
  Reservation memory_;
  std::optional<Error> error_;
};

}  // namespace isoextract::extract
