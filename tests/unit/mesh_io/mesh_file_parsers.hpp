// Parsers with which tests read written meshes. TinyGLTF loads glTF; the other parsers know only the format's
// specification and throw on everything unexpected.
#pragma once

#include <string>
#include <vector>

#include <glm/glm.hpp>

namespace isoextract::test {

struct ParsedMesh {
  std::string name;
  glm::dvec3 origin{0.0};
  std::vector<glm::dvec3> positions;
  std::vector<glm::vec3> normals;       // one per vertex
  std::vector<glm::vec3> face_normals;  // one per triangle
  std::vector<glm::uvec3> triangles;
};

struct ParsedPly {
  std::string header;
  std::string position_type;
  ParsedMesh mesh;
};
ParsedPly parse_ply(const std::string& bytes);

// Takes normals as face normals if the three corners of every face share one.
std::vector<ParsedMesh> parse_obj(const std::string& text);

// Triangle t has positions 3t, 3t + 1 and 3t + 2.
ParsedMesh parse_binary_stl(const std::string& bytes);
ParsedMesh parse_ascii_stl(const std::string& text);

// `path` ends in .glb or .gltf. Returns one entry per node of the default scene; nodes without a mesh have no
// positions. Without indices, triangle t has corners 3t, 3t + 1 and 3t + 2.
std::vector<ParsedMesh> load_gltf(const std::string& path);

}  // namespace isoextract::test
