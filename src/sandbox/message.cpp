#include "sandbox/message.hpp"

#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

namespace isoextract::sandbox {
namespace {

constexpr std::size_t kMostDescriptors = 8;
using Control = std::array<std::byte, CMSG_SPACE(kMostDescriptors * sizeof(int))>;

// Sends some of `bytes` and all descriptors with them. Returns the number of bytes sent, or -1.
ssize_t send_part(int socket, std::span<const std::byte> bytes, std::span<const int> descriptors, int flags) {
  iovec part{const_cast<std::byte*>(bytes.data()), bytes.size()};  // NOLINT: sendmsg does not write to it
  msghdr header{};
  header.msg_iov = &part;
  header.msg_iovlen = 1;
  alignas(cmsghdr) Control control{};
  if (!descriptors.empty()) {
    header.msg_control = control.data();
    header.msg_controllen = CMSG_SPACE(descriptors.size_bytes());
    cmsghdr* rights = CMSG_FIRSTHDR(&header);
    if (rights == nullptr) return -1;
    rights->cmsg_level = SOL_SOCKET;
    rights->cmsg_type = SCM_RIGHTS;
    rights->cmsg_len = CMSG_LEN(descriptors.size_bytes());
    std::memcpy(CMSG_DATA(rights), descriptors.data(), descriptors.size_bytes());
  }
  ssize_t sent = -1;
  do {
    sent = ::sendmsg(socket, &header, flags | MSG_NOSIGNAL);
  } while (sent < 0 && errno == EINTR);
  return sent;
}

bool send_all(int socket, std::span<const std::byte> bytes, std::span<const int> descriptors, int flags) {
  while (!bytes.empty()) {
    const ssize_t sent = send_part(socket, bytes, descriptors, flags);
    if (sent <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(sent));
    descriptors = {};
  }
  return true;
}

// Receives some bytes and the descriptors that come with them. Returns the number of bytes, or -1.
ssize_t receive_part(int socket, std::span<std::byte> bytes, std::vector<Descriptor>& descriptors) {
  iovec part{bytes.data(), bytes.size()};
  msghdr header{};
  header.msg_iov = &part;
  header.msg_iovlen = 1;
  alignas(cmsghdr) Control control{};
  header.msg_control = control.data();
  header.msg_controllen = control.size();
  ssize_t received = -1;
  do {
    received = ::recvmsg(socket, &header, MSG_CMSG_CLOEXEC);
  } while (received < 0 && errno == EINTR);
  if (received <= 0) return received;
  for (cmsghdr* rights = CMSG_FIRSTHDR(&header); rights != nullptr; rights = CMSG_NXTHDR(&header, rights)) {
    if (rights->cmsg_level != SOL_SOCKET || rights->cmsg_type != SCM_RIGHTS) continue;
    const std::size_t count = (rights->cmsg_len - CMSG_LEN(0)) / sizeof(int);
    for (std::size_t i = 0; i < count; ++i) {
      int number = -1;
      std::memcpy(&number, CMSG_DATA(rights) + i * sizeof(int), sizeof(int));
      descriptors.emplace_back(number);
    }
  }
  return received;
}

bool receive_all(int socket, std::span<std::byte> bytes, std::vector<Descriptor>& descriptors) {
  while (!bytes.empty()) {
    const ssize_t received = receive_part(socket, bytes, descriptors);
    if (received <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(received));
  }
  return true;
}

}  // namespace

MessageWriter& MessageWriter::number(std::uint64_t value) {
  packer_.put(value);
  return *this;
}

MessageWriter& MessageWriter::real(double value) {
  packer_.put(value);
  return *this;
}

MessageWriter& MessageWriter::text(std::string_view value) {
  packer_.put(value);
  return *this;
}

std::string MessageReader::text() {
  auto text = values_.get<std::string>();
  return values_.is_whole() ? text : std::string();
}

bool send_message(int socket, const MessageWriter& message, int descriptor, bool wait) {
  const std::span<const std::byte> body = message.bytes();
  const std::uint64_t length = body.size();
  const auto head = std::as_bytes(std::span(&length, 1));
  std::vector<std::byte> all;
  all.reserve(head.size() + body.size());
  all.insert(all.end(), head.begin(), head.end());
  all.insert(all.end(), body.begin(), body.end());
  return send_all(socket, all, {&descriptor, descriptor >= 0 ? std::size_t{1} : 0}, wait ? 0 : MSG_DONTWAIT);
}

bool send_bytes(int socket, std::span<const std::byte> bytes) { return send_all(socket, bytes, {}, 0); }

std::optional<ReceivedMessage> receive_message(int socket) {
  std::vector<Descriptor> descriptors;
  std::uint64_t length = 0;
  if (!receive_all(socket, std::as_writable_bytes(std::span(&length, 1)), descriptors)) return std::nullopt;
  if (length > kMaxMessageBytes) return std::nullopt;
  std::vector<std::byte> body(static_cast<std::size_t>(length));
  if (!receive_all(socket, body, descriptors)) return std::nullopt;
  ReceivedMessage received;
  received.message = MessageReader(std::move(body));
  if (!descriptors.empty()) received.descriptor = std::move(descriptors.front());
  return received;
}

bool send_descriptors(int socket, std::span<const int> descriptors) {
  constexpr std::byte kOne{1};
  return descriptors.size() <= kMostDescriptors && send_part(socket, {&kOne, 1}, descriptors, MSG_DONTWAIT) == 1;
}

std::vector<Descriptor> receive_descriptors(int socket) {
  std::vector<Descriptor> descriptors;
  std::byte one{};
  if (receive_part(socket, {&one, 1}, descriptors) != 1) descriptors.clear();
  return descriptors;
}

}  // namespace isoextract::sandbox
