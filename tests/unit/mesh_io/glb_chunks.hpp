// The chunks of a .glb.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace isoextract::test {

struct GlbChunks {
  nlohmann::json model;
  std::string binary;
};

// Splits a .glb strictly by the specification.
inline GlbChunks take_apart(const std::string& bytes) {
  const auto word = [&](std::size_t offset) {
    std::uint32_t value = 0;
    EXPECT_LE(offset + sizeof(value), bytes.size());
    std::memcpy(&value, bytes.data() + offset, sizeof(value));
    return value;
  };
  EXPECT_EQ(bytes.substr(0, 4), "glTF");
  EXPECT_EQ(word(4), 2U);
  EXPECT_EQ(word(8), bytes.size());
  const std::uint32_t json_bytes = word(12);
  EXPECT_EQ(json_bytes % 4, 0U);
  EXPECT_EQ(bytes.substr(16, 4), "JSON");
  GlbChunks chunks{nlohmann::json::parse(bytes.substr(20, json_bytes)), {}};
  const std::size_t binary = 20 + json_bytes;
  if (binary == bytes.size()) return chunks;
  EXPECT_EQ(word(binary) % 4, 0U);
  EXPECT_EQ(bytes.substr(binary + 4, 4), std::string("BIN\0", 4));
  chunks.binary = bytes.substr(binary + 8);
  EXPECT_EQ(chunks.binary.size(), word(binary));
  return chunks;
}

}  // namespace isoextract::test
