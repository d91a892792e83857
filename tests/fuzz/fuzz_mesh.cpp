// One libFuzzer target a mesh format: the input is a whole file with the extension of the format that the target is
// built for. What is read must keep what read_mesh promises.
#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "base/finite.hpp"
#include "fuzz/fuzz_format.hpp"
#include "fuzz/requirements.hpp"
#include "mesh_io/mesh_reader.hpp"
#include "support/temp_folder.hpp"

namespace isoextract {
namespace {

using fuzz::kFormat;
using fuzz::require;

// The input, and what a .gltf may name as its data (make_seeds.cpp does): zeros are points and indices alike.
struct Files {
  Files() { test::write_bytes(folder / "beside.bin", std::string(4096, '\0')); }

  test::TempFolder folder;
  std::filesystem::path input = folder / ("mesh." + std::string(kFormat));
};

void read_one(const std::string& bytes) {
  static const Files files;
  test::write_bytes(files.input, bytes);
  const Context context(MemoryBudget(std::uint64_t{8} << 20));
  {
    const auto read = mesh_io::read_mesh(files.input, context, {.normals = true});
    if (!read) {
      fuzz::require_refusal(read.error(), files.input.string());
      return;
    }
    const mesh::Mesh& mesh = read->mesh;
    require(is_finite(mesh.origin));
    for (const glm::vec3& p : mesh.positions) require(is_finite(glm::dvec3(p)));
    for (const glm::uvec3& t : mesh.triangles) require(std::max({t.x, t.y, t.z}) < mesh.positions.size());
    require(read->normals.empty() || read->normals.numbers.size() == mesh.triangles.size());
    for (const glm::uvec3& t : read->normals.numbers) {
      for (int c = 0; c < 3; ++c) require(t[c] < read->normals.values.size() || t[c] == mesh_io::FileNormals::kNone);
    }
    for (const mesh_io::MeshPart& part : read->parts) {
      require(part.first_triangle + part.triangles <= mesh.triangles.size());
      for (std::uint64_t t = part.first_triangle; t < part.first_triangle + part.triangles; ++t) {
        for (int c = 0; c < 3; ++c) require(mesh.triangles[t][c] - part.first_vertex < part.vertices);
      }
    }
    for (const mesh::Attribute& attribute : mesh.attributes) {
      require(attribute.values.size() == mesh.positions.size() * attribute.stride());
    }
  }
  require(context.memory().reserved() == 0);
}

}  // namespace
}  // namespace isoextract

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  isoextract::read_one(std::string(reinterpret_cast<const char*>(data), size));
  return 0;
}
