// A list that grows, and whose memory is reserved before it is taken.
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
  // `what` starts the message where there is no memory; both must outlive the list.
  ReservedList(const Context& context, const std::string& what) : context_(&context), what_(&what) {}

  // False where there was no memory: then error() says so, and nothing is added any more.
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
