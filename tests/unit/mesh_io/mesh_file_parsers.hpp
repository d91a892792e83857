// What tests read written meshes with. Apart from glTF, which TinyGLTF loads, these know no more of a format than what
// its description says, and throw on all they do not expect.
#pragma once

#include <string>
#include <vector>

#include <glm/glm.hpp>

namespace isoextract::test {

struct ParsedMesh {
  std::string name;
  glm::dvec3 origin{0.0};
  std::vector<glm::dvec3> positions;
  std::vector<glm::vec3> normals;       // one a vertex
  std::vector<glm::vec3> face_normals;  // one a triangle
  std::vector<glm::uvec3> triangles;
};

struct ParsedPly {
  std::string header;
  std::string position_type;
  ParsedMesh mesh;
};
ParsedPly parse_ply(const std::string& bytes);

// Vertex normals are told from face normals by whether the three of each face are one.
std::vector<ParsedMesh> parse_obj(const std::string& text);

// Triangle t has the positions 3t, 3t + 1, 3t + 2.
ParsedMesh parse_binary_stl(const std::string& bytes);
ParsedMesh parse_ascii_stl(const std::string& text);

// `path` ends in .glb or .gltf. One entry a node of the default scene; nodes without a mesh have no positions. Where
// there are no indices, triangle t has the corners 3t, 3t + 1, 3t + 2.
std::vector<ParsedMesh> load_gltf(const std::string& path);

}  // namespace isoextract::test
