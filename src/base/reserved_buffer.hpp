// An array that holds the reservation of its memory.
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

// Reserves memory for `count` elements, then allocates them uninitialized. Fails like MemoryBudget::reserve(); throws
// std::bad_alloc.
template <class T>
Result<std::shared_ptr<ReservedBuffer<T>>> make_reserved_buffer(std::size_t count, const Context& context,
                                                                const std::string& what) {
  auto memory = TRY(context.reserve(
      checked_product(std::uint64_t{count}, std::uint64_t{sizeof(T)}).value_or(~std::uint64_t{0}), what));
  return std::make_shared<ReservedBuffer<T>>(ReservedBuffer<T>{Buffer<T>(count), std::move(memory)});
}

}  // namespace isoextract
