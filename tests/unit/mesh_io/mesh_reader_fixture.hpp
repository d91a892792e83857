// Shared by the tests of the mesh readers: writes bytes to files, reads them and checks errors.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "mesh_io/mesh_reader.hpp"
#include "support/temp_folder.hpp"

namespace isoextract::test {

inline std::string bytes_of(std::initializer_list<float> values) {
  std::string bytes;
  for (const float value : values) bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  return bytes;
}

inline std::string word(std::uint32_t value) { return {reinterpret_cast<const char*>(&value), sizeof value}; }

class MeshReaderTest : public testing::Test {
 protected:
  mesh_io::MeshFile must_read(const std::string& name) {
    auto read = mesh_io::read_mesh(folder_ / name, Context());
    if (!read) {
      ADD_FAILURE() << read.error().message;
      return {};
    }
    return std::move(*read);
  }

  mesh_io::MeshFile read_text(const std::string& name, const std::string& text) {
    write_bytes(folder_ / name, text);
    return must_read(name);
  }

  void expect_error(const std::string& name, const std::string& bytes, const std::string& part) {
    write_bytes(folder_ / name, bytes);
    const auto read = mesh_io::read_mesh(folder_ / name, Context());
    ASSERT_FALSE(read) << part;
    EXPECT_EQ(read.error().code, ErrorCode::input);
    EXPECT_TRUE(read.error().message.starts_with((folder_ / name).string() + ": ")) << read.error().message;
    EXPECT_NE(read.error().message.find(part), std::string::npos) << read.error().message;
  }

  TempFolder folder_;
};

// Returns a model of one triangle, with the given `nodes` and `scene`.
inline std::string gltf(const std::string& nodes, const std::string& scene = R"({"nodes":[0]})") {
  return fmt::format(
      R"({{"asset":{{"version":"2.0"}},"scenes":[{}],"nodes":[{}],"meshes":[{{"primitives":[{{"attributes":)"
      R"({{"POSITION":0}}}}]}}],"accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}}],)"
      R"("bufferViews":[{{"buffer":0,"byteLength":36}}],"buffers":[{{"byteLength":36,"uri":"data:;base64,)"
      R"(AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}}]}})",
      scene, nodes);
}

}  // namespace isoextract::test
