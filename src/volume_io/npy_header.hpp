// The header of NumPy's array files (.npy), versions 1 to 3: a magic, a length, a Python dictionary as text.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.hpp"
#include "files/file_bytes.hpp"

namespace isoextract::volume_io {

inline constexpr std::string_view kNpyMagic("\x93NUMPY", 6);

// A named part of each element of a structured array.
struct NpyField {
  std::string name;
  std::string descr;                 // "<f4"
  std::vector<std::uint64_t> shape;  // empty for one number
};

struct NpyHeader {
  std::string descr;             // "<f4"; "a structure" for a structured array
  std::vector<NpyField> fields;  // of a structured array; none where they are nested, or written in another way
  bool fortran_order = false;    // the first axis is the fastest
  std::vector<std::uint64_t> shape;
  std::uint64_t data_offset = 0;
};

// Fails with ErrorCode::input where there is no such header. What types and shape mean is not looked at.
[[nodiscard]] Result<NpyHeader> read_npy_header(const files::InputFile& file);

// No header is longer than this, or it is refused.
inline constexpr std::uint64_t kMaxNpyHeader = (std::uint64_t{1} << 20) + 12;
// The same of `size` bytes, of which `start` are the first: all of them, or kMaxNpyHeader. `name` is for messages.
[[nodiscard]] Result<NpyHeader> parse_npy_header(const std::string& name, std::span<const std::byte> start,
                                                 std::uint64_t size);

// The same of the first bytes of a file; nothing where the header is none, or longer than they are.
[[nodiscard]] std::optional<NpyHeader> npy_header_in(std::span<const std::byte> start);

}  // namespace isoextract::volume_io
