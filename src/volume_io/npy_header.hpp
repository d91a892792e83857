// The header of NumPy's array files (.npy), versions 1 to 3: a signature, a length, and a Python dictionary as text.
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

// A named member of each element of a structured array.
struct NpyField {
  std::string name;
  std::string descr;                 // "<f4"
  std::vector<std::uint64_t> shape;  // empty for a scalar
};

struct NpyHeader {
  std::string descr;             // "<f4"; "a structure" for a structured array
  std::vector<NpyField> fields;  // of a structured array; empty if they are nested or have an unknown form
  bool fortran_order = false;    // the first axis is the fastest
  std::vector<std::uint64_t> shape;
  std::uint64_t data_offset = 0;
};

// Reads the header. Fails with ErrorCode::input if there is none, or if it is damaged or compressed. Does not interpret
// types and shape.
[[nodiscard]] Result<NpyHeader> read_npy_header(const files::InputFile& file);

// Longest header that is accepted.
inline constexpr std::uint64_t kMaxNpyHeader = (std::uint64_t{1} << 20) + 12;
// Parses the header of an array file of `size` bytes; `start` is the whole file or its first kMaxNpyHeader bytes.
// `name` is for messages. Fails as read_npy_header() does.
[[nodiscard]] Result<NpyHeader> parse_npy_header(const std::string& name, std::span<const std::byte> start,
                                                 std::uint64_t size);

// Parses the header from the first bytes of a file; leaves data_offset 0. Returns nothing if the header is invalid or
// longer than these bytes.
[[nodiscard]] std::optional<NpyHeader> npy_header_in(std::span<const std::byte> start);

}  // namespace isoextract::volume_io
