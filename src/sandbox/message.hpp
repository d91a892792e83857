// Messages between this program and its child processes: numbers and texts, one after the other, behind their length.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sandbox/descriptor.hpp"

namespace isoextract::sandbox {

// Longer messages are refused: what is large goes through shared memory.
inline constexpr std::uint64_t kMostMessageBytes = std::uint64_t{64} << 20;

class MessageWriter {
 public:
  MessageWriter& number(std::uint64_t value);
  MessageWriter& real(double value);
  MessageWriter& text(std::string_view value);
  [[nodiscard]] std::span<const std::byte> bytes() const { return bytes_; }

 private:
  std::vector<std::byte> bytes_;
};

// Reads what a MessageWriter wrote. A message that ends too early gives 0 and "" from there on, and is not whole.
class MessageReader {
 public:
  MessageReader() = default;
  explicit MessageReader(std::vector<std::byte> bytes) : bytes_(std::move(bytes)) {}

  [[nodiscard]] std::uint64_t number();
  [[nodiscard]] double real();
  [[nodiscard]] std::string text();
  // Everything that was read was there.
  [[nodiscard]] bool is_whole() const { return is_whole_; }
  // Bytes that are not read yet: no list has more entries.
  [[nodiscard]] std::uint64_t left() const { return bytes_.size() - at_; }

 private:
  bool take(void* to, std::size_t count);

  std::vector<std::byte> bytes_;
  std::size_t at_ = 0;
  bool is_whole_ = true;
};

// Sends a message, with a descriptor unless that is -1. With `wait` false it fails where the other side has not read
// earlier ones. False where it failed.
[[nodiscard]] bool send_message(int socket, const MessageWriter& message, int descriptor = -1, bool wait = true);

// Sends numbers that follow a message, as they are.
[[nodiscard]] bool send_bytes(int socket, std::span<const std::byte> bytes);

struct ReceivedMessage {
  MessageReader message;
  Descriptor descriptor;  // open where one came along
};
// Waits for a message; nothing where the other side has closed, or sent no message.
[[nodiscard]] std::optional<ReceivedMessage> receive_message(int socket);

// Sends `descriptors`, eight at most, through a socket that keeps messages apart. False where it failed.
[[nodiscard]] bool send_descriptors(int socket, std::span<const int> descriptors);
// Receives them, and their number; none where the other side has closed.
[[nodiscard]] std::vector<Descriptor> receive_descriptors(int socket);

}  // namespace isoextract::sandbox
