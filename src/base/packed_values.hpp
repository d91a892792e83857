// Values as bytes, for messages between processes of this program on machines of one kind.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include "base/error.hpp"

namespace isoextract {

class Packer {
 public:
  template <class T>
  Packer& put(const T& value) {
    if constexpr (std::is_convertible_v<const T&, std::string_view>) {
      const std::string_view text = value;
      put(static_cast<std::uint64_t>(text.size()));
      bytes_ += text;
    } else if constexpr (std::is_same_v<T, Error>) {
      put(value.code).put(value.message).put(static_cast<std::uint64_t>(value.hint.steps.size()));
      for (const Step& step : value.hint.steps) put(step.remedy).put(step.setting).put(step.text);
    } else {
      static_assert(std::is_trivially_copyable_v<T>);
      bytes_.append(reinterpret_cast<const char*>(&value), sizeof(T));
    }
    return *this;
  }

  [[nodiscard]] std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

// Reads values in the order in which they were put. Behind the end every value is zero or empty.
class Unpacker {
 public:
  explicit Unpacker(std::string_view bytes) : rest_(bytes) {}

  template <class T>
  [[nodiscard]] T get() {
    if constexpr (std::is_same_v<T, std::string>) {
      const auto told = get<std::uint64_t>();
      const auto size = std::min<std::size_t>(told, rest_.size());
      T text(rest_.substr(0, size));
      rest_.remove_prefix(size);
      return text;
    } else if constexpr (std::is_same_v<T, Error>) {
      Error error{get<ErrorCode>(), {}, {}};
      error.message = get<std::string>();
      const auto steps = get<std::uint64_t>();
      for (std::uint64_t s = 0; s < steps; ++s) {
        const auto remedy = get<Remedy>();
        const auto setting = get<Setting>();
        error.hint.steps.emplace_back(remedy, setting, get<std::string>());
      }
      return error;
    } else {
      static_assert(std::is_trivially_copyable_v<T>);
      T value{};
      if (rest_.size() >= sizeof(T)) std::memcpy(&value, rest_.data(), sizeof(T));
      rest_.remove_prefix(std::min(sizeof(T), rest_.size()));
      return value;
    }
  }

 private:
  std::string_view rest_;
};

}  // namespace isoextract
