#include "io/vdb_stream.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <streambuf>

#include <fmt/format.h>

namespace isoextract {
namespace {

// The bitmasks of a node with 8^3, 16^3 or 32^3 entries, in bytes.
bool is_mask_size(std::uint64_t bytes) { return bytes == 64 || bytes == 512 || bytes == 4096; }

std::uint64_t count_bits(const char* bytes, std::uint64_t count) {
  std::uint64_t on = 0;
  for (std::uint64_t i = 0; i < count; i += sizeof(std::uint64_t)) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes + i, sizeof word);
    on += static_cast<std::uint64_t>(std::popcount(word));
  }
  return on;
}

}  // namespace

void VdbNodeCheck::start(const VdbValueLayout& layout) {
  *this = VdbNodeCheck();
  layout_ = layout;
  started_ = true;
}

void VdbNodeCheck::choose_after_prefix() {
  const bool empty = masked_ && mask_on_ == 0;
  const bool compressed = (layout_.compression & (kVdbZip | kVdbBlosc)) != 0;
  next_ = compressed && !(empty && layout_.skips_empty) ? Next::chunk_size : Next::masks;
  if (next_ == Next::masks) mask_bits_ = 0;
}

void VdbNodeCheck::after_read(const char* bytes, std::uint64_t count, std::uint64_t left) {
  if (!started_) return;
  switch (next_) {
    case Next::masks: {
      if (is_mask_size(count)) {
        mask_bits_ = 8 * count;
        mask_on_ = count_bits(bytes, count);
      } else if (count == 1 && mask_bits_ > 0) {
        // Codes 2 and 4 come with one inactive value, 5 with two; 3 to 5 with a mask; 6 stores all values.
        const auto code = static_cast<unsigned char>(bytes[0]);
        prefix_left_ = (code == 2 || code == 4 ? 1 : 0) + (code == 5 ? 2 : 0) + (code >= 3 && code <= 5 ? 1 : 0);
        masked_ = (layout_.compression & kVdbActiveMask) != 0 && code != 6;
        next_ = Next::prefix;
        if (prefix_left_ == 0) choose_after_prefix();
      } else if (count == 1 && static_cast<unsigned char>(bytes[0]) > 1) {
        throw VdbDamaged(fmt::format("a tile's flag is {}", static_cast<unsigned char>(bytes[0])));
      } else {
        mask_bits_ = 0;
      }
      return;
    }
    case Next::prefix:
      if (--prefix_left_ == 0) choose_after_prefix();
      return;
    case Next::chunk_size: {
      std::memcpy(&chunk_size_, bytes, sizeof chunk_size_);
      const std::uint64_t expected = (masked_ ? mask_on_ : mask_bits_) * layout_.stored_size;
      const bool plain_fits =
          chunk_size_ <= 0 && std::uint64_t{0} - static_cast<std::uint64_t>(chunk_size_) == expected;
      const bool packed_fits = chunk_size_ > 0 && static_cast<std::uint64_t>(chunk_size_) <= left;
      if (count != sizeof chunk_size_ || !(plain_fits || packed_fits)) {
        throw VdbDamaged(fmt::format("a chunk of {} bytes is said to be {} long", expected, chunk_size_));
      }
      next_ = Next::chunk;
      return;
    }
    case Next::chunk: {
      // A blosc chunk begins with 16 bytes of which the last four are its length.
      if ((layout_.compression & kVdbBlosc) != 0 && chunk_size_ > 0) {
        std::uint32_t length = 0;
        if (count >= 16) std::memcpy(&length, bytes + 12, sizeof length);
        if (length != count) throw VdbDamaged(fmt::format("a blosc chunk of {} bytes claims {}", count, length));
      }
      next_ = Next::masks;
      mask_bits_ = 0;
      return;
    }
  }
}

// Reads through a window of the file; what is larger than the window goes to its place directly.
class VdbStream::Bytes : public std::streambuf {
 public:
  Bytes(const InputFile& file, Progress* progress) : file_(file), progress_(progress), window_(kWindow) {}

  VdbNodeCheck check;

  [[nodiscard]] std::uint64_t size() const { return file_.size(); }
  [[nodiscard]] std::uint64_t position() const { return window_end_ - static_cast<std::uint64_t>(egptr() - gptr()); }

 protected:
  int_type underflow() override {
    if (gptr() < egptr()) return traits_type::to_int_type(*gptr());
    if (position() >= size()) throw VdbDamaged("the file ends too early");
    fill();
    return traits_type::to_int_type(*gptr());
  }

  std::streamsize xsgetn(char* out, std::streamsize count) override {
    const auto wanted = static_cast<std::uint64_t>(count);
    const std::uint64_t left = size() - position();
    if (count < 0 || wanted > left) {
      throw VdbDamaged(fmt::format("expected {} bytes from byte {} on, the file has {}", wanted, position(), left));
    }
    std::uint64_t done = 0;
    while (done < wanted) {
      if (gptr() == egptr()) {
        if (wanted - done >= kWindow) {
          const std::uint64_t at = position();
          read_into(at, out + done, wanted - done);
          move_to(at + wanted - done);
          break;
        }
        fill();
      }
      const std::uint64_t part = std::min(wanted - done, static_cast<std::uint64_t>(egptr() - gptr()));
      std::memcpy(out + done, gptr(), part);
      gbump(static_cast<int>(part));
      done += part;
    }
    check.after_read(out, wanted, left - wanted);
    return count;
  }

  pos_type seekoff(off_type offset, std::ios_base::seekdir direction, std::ios_base::openmode mode) override {
    const std::uint64_t base =
        direction == std::ios_base::beg ? 0 : (direction == std::ios_base::cur ? position() : size());
    return seekpos(static_cast<off_type>(base) + offset, mode);
  }

  pos_type seekpos(pos_type target, std::ios_base::openmode) override {
    const off_type wanted = target;
    if (wanted < 0 || static_cast<std::uint64_t>(wanted) > size()) {
      throw VdbDamaged(fmt::format("refers to byte {}, the file has {}", wanted, size()));
    }
    const auto at = static_cast<std::uint64_t>(wanted);
    const std::uint64_t window_begin = window_end_ - static_cast<std::uint64_t>(egptr() - eback());
    if (at >= window_begin && at <= window_end_) {
      setg(eback(), eback() + (at - window_begin), egptr());
    } else {
      move_to(at);
    }
    return target;
  }

 private:
  static constexpr std::uint64_t kWindow = std::uint64_t{1} << 20;

  void move_to(std::uint64_t position) {
    setg(window_.data(), window_.data(), window_.data());
    window_end_ = position;
  }

  void fill() {
    const std::uint64_t count = std::min(kWindow, size() - window_end_);
    read_into(window_end_, window_.data(), count);
    setg(window_.data(), window_.data(), window_.data() + count);
    window_end_ += count;
  }

  void read_into(std::uint64_t at, char* out, std::uint64_t count) {
    const auto read = file_.read_at(at, std::as_writable_bytes(std::span(out, count)));
    if (!read) throw VdbDamaged(read.error().message);
    if (progress_ != nullptr) progress_->advance(count);
  }

  const InputFile& file_;
  Progress* progress_;
  std::vector<char> window_;
  std::uint64_t window_end_ = 0;  // of the window, in the file
};

VdbStream::VdbStream(const InputFile& file, Progress* progress)
    : std::istream(nullptr), bytes_(std::make_unique<Bytes>(file, progress)) {
  rdbuf(bytes_.get());
  // OpenVDB does not look at the state of the stream: nothing may go wrong without an exception.
  exceptions(std::ios_base::badbit | std::ios_base::failbit | std::ios_base::eofbit);
}

VdbStream::~VdbStream() = default;

std::uint64_t VdbStream::size() const { return bytes_->size(); }

std::uint64_t VdbStream::position() { return bytes_->position(); }

void VdbStream::seek(std::uint64_t position) { seekg(static_cast<off_type>(position), std::ios_base::beg); }

void VdbStream::expect_tree(const VdbValueLayout& layout) { bytes_->check.start(layout); }

void VdbStream::expect_no_tree() { bytes_->check.stop(); }

std::string VdbStream::read_name() {
  constexpr std::uint32_t kMaxLength = 64 << 10;
  const auto length = read_value<std::uint32_t>();
  if (length > kMaxLength) throw VdbDamaged(fmt::format("a name is said to be {} characters long", length));
  std::string name(length, '\0');
  read(name.data(), static_cast<std::streamsize>(length));
  return name;
}

}  // namespace isoextract
