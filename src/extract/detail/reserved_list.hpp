// A growing list that reserves its memory in the budget before it allocates it.
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
    const std::size_t wanted = std::max<std::size_t>(2 * values_.capacity(), 32);
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

}  // namespace isoextract::extract
