// Values as bytes, for messages between processes of this program on machines of one kind: children
// (sandbox/message.hpp) and ranks.
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

  [[nodiscard]] const std::string& bytes() const { return bytes_; }
  [[nodiscard]] std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

// Reads values in the order in which they were put. After the end of the bytes every value is zero or empty, and
// is_whole() becomes false. The bytes must outlive the unpacker.
class Unpacker {
 public:
  Unpacker() = default;
  explicit Unpacker(std::string_view bytes) : rest_(bytes) {}

  template <class T>
  [[nodiscard]] T get() {
    if constexpr (std::is_same_v<T, std::string>) {
      const auto told = get<std::uint64_t>();
      return T(next(static_cast<std::size_t>(std::min<std::uint64_t>(told, std::string_view::npos))));
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
      const std::string_view bytes = next(sizeof(T));
      if (bytes.size() == sizeof(T)) std::memcpy(&value, bytes.data(), sizeof(T));
      return value;
    }
  }

  // Returns whether the bytes contained every value read so far.
  [[nodiscard]] bool is_whole() const { return is_whole_; }
  // Returns the number of unread bytes.
  [[nodiscard]] std::size_t left() const { return rest_.size(); }

 private:
  // Takes the next `count` bytes, or all that are left.
  std::string_view next(std::size_t count) {
    is_whole_ = is_whole_ && count <= rest_.size();
    const std::string_view bytes = rest_.substr(0, count);
    rest_.remove_prefix(bytes.size());
    return bytes;
  }

  std::string_view rest_;
  bool is_whole_ = true;
};

}  // namespace isoextract
