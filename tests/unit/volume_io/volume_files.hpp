// Shared by the tests of the volume readers: files made by hand, and comparisons of what a reader returns.
#pragma once

#include <bit>
#include <cstring>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <zlib.h>
#include <glm/glm.hpp>

#include "support/fields.hpp"
#include "support/hints.hpp"
#include "support/temp_folder.hpp"
#include "volume_io/volume_reader.hpp"

namespace isoextract::test {

inline std::string in_order(std::string bytes, std::endian endian) {
  if (endian != std::endian::native) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

template <class T>
std::string pack(T value, std::endian endian = std::endian::little) {
  std::string bytes(sizeof value, '\0');
  std::memcpy(bytes.data(), &value, sizeof value);
  return in_order(std::move(bytes), endian);
}

// Writes a value into a header at an offset.
template <class T>
void put(std::string& bytes, std::size_t offset, T value, std::endian endian = std::endian::little) {
  bytes.replace(offset, sizeof value, pack(value, endian));
}

// Differs along every axis, so that swapped axes show; negative for signed types. Fits into 8 bits for kDims.
inline constexpr glm::ivec3 kDims{3, 4, 5};
template <class T>
T ramp(int i, int j, int k) {
  const int base = std::is_unsigned_v<T> ? 0 : -20;
  return sample<T>(base + i + 7 * j + 31 * k);
}

template <class T>
std::string ramp_bytes(std::endian endian = std::endian::little, glm::ivec3 dims = kDims) {
  std::string bytes;
  for (int k = 0; k < dims.z; ++k) {
    for (int j = 0; j < dims.y; ++j) {
      for (int i = 0; i < dims.x; ++i) bytes += pack(ramp<T>(i, j, k), endian);
    }
  }
  return bytes;
}

// Compresses to one gzip member.
inline std::string gzip(const std::string& bytes) {
  z_stream stream{};
  if (::deflateInit2(&stream, Z_BEST_COMPRESSION, Z_DEFLATED, 16 + MAX_WBITS, 8, Z_DEFAULT_STRATEGY) != Z_OK) throw 0;
  std::string packed(::deflateBound(&stream, bytes.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  ::deflate(&stream, Z_FINISH);
  packed.resize(stream.total_out);
  ::deflateEnd(&stream);
  return packed;
}

inline field::ScalarField must_read(const std::filesystem::path& path, const volume_io::ReadOptions& options = {},
                                    const Context& context = Context()) {
  auto field = volume_io::read_volume(path.string(), options, context);
  if (!field) throw std::runtime_error(field.error().message + "\n" + test::text_of(field.error().hint));
  return std::move(*field);
}

// Returns the error of reading an invalid file, which must name the file.
inline Error refusal(const std::filesystem::path& path, const volume_io::ReadOptions& options = {},
                     const Context& context = Context()) {
  const auto field = volume_io::read_volume(path.string(), options, context);
  if (field) throw std::runtime_error(path.string() + " was read");
  EXPECT_NE(field.error().message.find(path.filename().string()), std::string::npos) << field.error().message;
  return field.error();
}

inline Context with_memory(std::uint64_t bytes) { return Context(MemoryBudget(bytes)); }

inline void expect_in(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << "expected '" << part << "' in: " << text;
}

template <class T>
T dense_value(const field::ScalarField& field, int i, int j, int k) {
  const auto& samples = std::get<field::DenseSamples>(field.samples);
  const auto at =
      static_cast<std::size_t>(i) +
      static_cast<std::size_t>(samples.dims.x) *
          (static_cast<std::size_t>(j) + static_cast<std::size_t>(samples.dims.y) * static_cast<std::size_t>(k));
  return static_cast<const T*>(samples.data)[at];
}

template <class T>
void expect_ramp(const field::ScalarField& field, glm::ivec3 dims = kDims) {
  const auto& samples = std::get<field::DenseSamples>(field.samples);
  ASSERT_EQ(samples.type, field::sample_type_of<T>());
  ASSERT_EQ(samples.dims, dims);
  for (int k = 0; k < dims.z; ++k) {
    for (int j = 0; j < dims.y; ++j) {
      for (int i = 0; i < dims.x; ++i) {
        ASSERT_EQ(dense_value<T>(field, i, j, k), ramp<T>(i, j, k)) << i << ' ' << j << ' ' << k;
      }
    }
  }
}

inline void expect_near(const glm::dvec3& found, const glm::dvec3& expected, double tolerance = 1e-12) {
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(found[axis], expected[axis], tolerance * std::max(1.0, std::abs(expected[axis]))) << "axis " << axis;
  }
}

inline bool has_note(const field::ScalarField& field, const std::string& part) {
  return std::ranges::any_of(field.notes, [&](const Note& note) { return note.text.find(part) != std::string::npos; });
}

// An invalid file, and parts of the expected message.
struct BadFile {
  const char* what;
  std::string bytes;
  std::string message;
};

inline void expect_all_refused(const std::string& file_name, const std::vector<BadFile>& files) {
  for (const BadFile& bad : files) {
    SCOPED_TRACE(bad.what);
    const TempFolder folder;
    write_bytes(folder / file_name, bad.bytes);
    const Error error = refusal(folder / file_name);
    EXPECT_EQ(error.code, ErrorCode::input);
    expect_in(error.message, bad.message);
  }
}

}  // namespace isoextract::test
