// An array together with what is reserved for it.
#pragma once

#include <memory>
#include <string>

#include "base/buffer.hpp"
#include "base/checked.hpp"
#include "base/context.hpp"

namespace isoextract {

template <class T>
struct ReservedBuffer {
  Buffer<T> values;
  Reservation memory;
};

// `count` elements, not initialised, reserved before they are allocated; fails as MemoryBudget::reserve() does.
template <class T>
Result<std::shared_ptr<ReservedBuffer<T>>> make_reserved_buffer(std::size_t count, const Context& context,
                                                                const std::string& what) {
  auto memory = TRY(context.reserve(
      checked_product(std::uint64_t{count}, std::uint64_t{sizeof(T)}).value_or(~std::uint64_t{0}), what));
  return std::make_shared<ReservedBuffer<T>>(ReservedBuffer<T>{Buffer<T>(count), std::move(memory)});
}

}  // namespace isoextract
