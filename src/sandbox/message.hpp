// Messages between this program and its child processes: a length, then numbers and texts.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/packed_values.hpp"
#include "sandbox/descriptor.hpp"

namespace isoextract::sandbox {

// The receiver rejects longer messages: large data goes through shared memory.
inline constexpr std::uint64_t kMaxMessageBytes = std::uint64_t{64} << 20;

class MessageWriter {
 public:
  MessageWriter& number(std::uint64_t value);
  MessageWriter& real(double value);
  MessageWriter& text(std::string_view value);
  [[nodiscard]] std::span<const std::byte> bytes() const { return std::as_bytes(std::span(packer_.bytes())); }

 private:
  Packer packer_;
};

// Reads the fields of a MessageWriter in order. Past the end of the message it returns 0 and "", and is_whole() becomes
// false.
class MessageReader {
 public:
  MessageReader() = default;
  explicit MessageReader(std::vector<std::byte> bytes)
      : bytes_(std::move(bytes)), values_({reinterpret_cast<const char*>(bytes_.data()), bytes_.size()}) {}
  MessageReader(MessageReader&&) = default;  // values_ keeps its place: the bytes stay where they are
  MessageReader& operator=(MessageReader&&) = default;
  MessageReader(const MessageReader&) = delete;
  MessageReader& operator=(const MessageReader&) = delete;
  ~MessageReader() = default;

  [[nodiscard]] std::uint64_t number() { return values_.get<std::uint64_t>(); }
  [[nodiscard]] double real() { return values_.get<double>(); }
  [[nodiscard]] std::string text();
  // Returns whether every field read so far was there.
  [[nodiscard]] bool is_whole() const { return values_.is_whole(); }
  // Returns the number of unread bytes, an upper bound for the number of entries of a list; 0 if a field was missing.
  [[nodiscard]] std::uint64_t left() const { return values_.left(); }

 private:
  std::vector<std::byte> bytes_;
  Unpacker values_;
};

// Sends a message, with a descriptor unless it is -1. If `wait` is false, fails instead of blocking when the socket's
// buffer is full. Returns false on failure; the socket is unusable then, as a part of the message may have been sent.
[[nodiscard]] bool send_message(int socket, const MessageWriter& message, int descriptor = -1, bool wait = true);

// Sends raw bytes that follow a message. Returns false on failure.
[[nodiscard]] bool send_bytes(int socket, std::span<const std::byte> bytes);

struct ReceivedMessage {
  MessageReader message;
  Descriptor descriptor;  // open if the message came with one
};
// Waits for a message. Returns nothing if the other side has closed the socket or announces more than kMaxMessageBytes.
[[nodiscard]] std::optional<ReceivedMessage> receive_message(int socket);

// Sends at most eight descriptors with one byte, without blocking. Returns false on failure.
[[nodiscard]] bool send_descriptors(int socket, std::span<const int> descriptors);
// Waits for one call of send_descriptors() and returns its descriptors; none if the other side has closed the socket.
[[nodiscard]] std::vector<Descriptor> receive_descriptors(int socket);

}  // namespace isoextract::sandbox
