#include "unit/mesh_io/mesh_file_parsers.hpp"

#include <cstdlib>
#include <cstring>
#include <sstream>
#include <stdexcept>

#include <tiny_gltf.h>

namespace isoextract::test {
namespace {

void expect(bool condition, const std::string& what) {
  if (!condition) throw std::runtime_error(what);
}

class ByteReader {
 public:
  ByteReader(const std::string& bytes, std::size_t offset) : bytes_(bytes), offset_(offset) {}

  template <class T>
  T get() {
    expect(offset_ + sizeof(T) <= bytes_.size(), "the file ends early");
    T value;
    std::memcpy(&value, bytes_.data() + offset_, sizeof(T));
    offset_ += sizeof(T);
    return value;
  }
  [[nodiscard]] bool at_end() const { return offset_ == bytes_.size(); }

 private:
  const std::string& bytes_;
  std::size_t offset_;
};

// Parses as type T, so that the text of a float must read back as that float.
double text_number(const std::string& word, const std::string& type) {
  char* end = nullptr;
  const double value =
      type == "float" ? static_cast<double>(std::strtof(word.c_str(), &end)) : std::strtod(word.c_str(), &end);
  expect(end == word.c_str() + word.size(), "not a number: " + word);
  return value;
}

std::string next_word(std::istream& stream) {
  std::string word;
  expect(static_cast<bool>(stream >> word), "the text ends early");
  return word;
}

void expect_word(std::istream& stream, const std::string& expected) {
  const std::string word = next_word(stream);
  expect(word == expected, "expected " + expected + ", found " + word);
}

glm::vec3 float_vector(std::istream& stream) {
  glm::vec3 v;
  for (int axis = 0; axis < 3; ++axis) v[axis] = static_cast<float>(text_number(next_word(stream), "float"));
  return v;
}

struct PlyProperty {
  std::string type;  // "list" for the one list
  std::string name;
};
struct PlyElement {
  std::string name;
  std::size_t count = 0;
  std::vector<PlyProperty> properties;
};

}  // namespace

ParsedPly parse_ply(const std::string& bytes) {
  ParsedPly ply;
  const std::string end = "end_header\n";
  const std::size_t data = bytes.find(end);
  expect(data != std::string::npos, "no end_header");
  ply.header = bytes.substr(0, data + end.size());

  std::vector<PlyElement> elements;
  std::string format;
  std::istringstream lines(ply.header);
  std::string line;
  expect(std::getline(lines, line) && line == "ply", "no magic");
  while (std::getline(lines, line) && line != "end_header") {
    std::istringstream words(line);
    const std::string word = next_word(words);
    if (word == "format") {
      format = next_word(words);
      expect_word(words, "1.0");
    } else if (word == "element") {
      elements.push_back({next_word(words), std::stoul(next_word(words)), {}});
    } else if (word == "property") {
      std::string type = next_word(words);
      if (type == "list") {
        expect_word(words, "uchar");
        expect_word(words, "uint");
      }
      elements.back().properties.push_back({type, next_word(words)});
    } else {
      expect(word == "comment", "unknown line: " + line);
    }
  }
  expect(elements.size() == 2 && elements[0].name == "vertex" && elements[1].name == "face", "other elements");
  ply.position_type = elements[0].properties.at(0).type;

  const bool ascii = format == "ascii";
  expect(ascii || format == "binary_little_endian", "unknown format " + format);
  ByteReader reader(bytes, ascii ? bytes.size() : ply.header.size());
  std::istringstream text(ascii ? bytes.substr(ply.header.size()) : std::string());
  const auto number = [&](const std::string& type) -> double {
    if (ascii) return text_number(next_word(text), type);
    if (type == "float") return reader.get<float>();
    if (type == "double") return reader.get<double>();
    if (type == "uint") return reader.get<std::uint32_t>();
    expect(type == "uchar", "unknown type " + type);
    return reader.get<std::uint8_t>();
  };
  for (const PlyElement& element : elements) {
    for (std::size_t i = 0; i < element.count; ++i) {
      glm::dvec3 position(0);
      glm::vec3 normal(0);
      for (const PlyProperty& property : element.properties) {
        if (property.type == "list") {
          expect(property.name == "vertex_indices", "unknown list " + property.name);
          expect(number("uchar") == 3, "not a triangle");
          glm::uvec3 triangle;
          for (int corner = 0; corner < 3; ++corner) triangle[corner] = static_cast<unsigned>(number("uint"));
          ply.mesh.triangles.push_back(triangle);
          continue;
        }
        const double value = number(property.type);
        const int axis = property.name.back() - 'x';
        if (property.name.size() == 1) position[axis] = value;
        if (property.name.size() == 2) normal[axis] = static_cast<float>(value);
      }
      const bool has_normal = element.properties.back().name == "nz";
      const bool is_vertex = element.name == "vertex";
      if (is_vertex) ply.mesh.positions.push_back(position);
      if (has_normal) (is_vertex ? ply.mesh.normals : ply.mesh.face_normals).push_back(normal);
    }
  }
  expect(reader.at_end() && (!ascii || (text >> std::ws).eof()), "more data than the header says");
  return ply;
}

std::vector<ParsedMesh> parse_obj(const std::string& text) {
  std::vector<ParsedMesh> meshes;
  std::vector<glm::vec3> normals;  // of the whole file
  std::size_t first_vertex = 1;
  std::istringstream lines(text);
  std::string line;
  while (std::getline(lines, line)) {
    std::istringstream words(line);
    const std::string word = next_word(words);
    if (word == "o") {
      if (!meshes.empty()) first_vertex += meshes.back().positions.size();
      meshes.emplace_back().name = line.substr(2);
    } else if (word == "v") {
      glm::dvec3 v;
      for (int axis = 0; axis < 3; ++axis) v[axis] = text_number(next_word(words), "double");
      meshes.back().positions.push_back(v);
    } else if (word == "vn") {
      normals.push_back(float_vector(words));
    } else if (word == "f") {
      ParsedMesh& mesh = meshes.back();
      glm::uvec3 triangle;
      glm::uvec3 normal(0);
      for (int corner = 0; corner < 3; ++corner) {
        const std::string reference = next_word(words);
        triangle[corner] = static_cast<unsigned>(std::stoul(reference) - first_vertex);
        if (const std::size_t slashes = reference.find("//"); slashes != std::string::npos) {
          normal[corner] = static_cast<unsigned>(std::stoul(reference.substr(slashes + 2)));
        }
      }
      mesh.triangles.push_back(triangle);
      if (normal[0] == 0) continue;
      if (normal[0] == normal[1] && normal[1] == normal[2]) {
        mesh.face_normals.push_back(normals.at(normal[0] - 1));
        continue;
      }
      mesh.normals.resize(mesh.positions.size());
      for (int corner = 0; corner < 3; ++corner) mesh.normals.at(triangle[corner]) = normals.at(normal[corner] - 1);
    } else {
      expect(word == "#", "unknown line: " + line);
    }
  }
  return meshes;
}

ParsedMesh parse_binary_stl(const std::string& bytes) {
  ParsedMesh mesh;
  ByteReader reader(bytes, 80);
  const auto count = reader.get<std::uint32_t>();
  for (std::uint32_t t = 0; t < count; ++t) {
    mesh.face_normals.push_back(reader.get<glm::vec3>());
    for (int corner = 0; corner < 3; ++corner) mesh.positions.emplace_back(reader.get<glm::vec3>());
    expect(reader.get<std::uint16_t>() == 0, "attribute bytes");
    mesh.triangles.emplace_back(3 * t, 3 * t + 1, 3 * t + 2);
  }
  expect(reader.at_end(), "more data than the header says");
  return mesh;
}

ParsedMesh parse_ascii_stl(const std::string& text) {
  ParsedMesh mesh;
  std::istringstream stream(text);
  std::string line;
  std::getline(stream, line);
  expect(line.starts_with("solid "), "no solid");
  mesh.name = line.substr(6);
  for (std::string word = next_word(stream); word != "endsolid"; word = next_word(stream)) {
    expect(word == "facet", "expected a facet, found " + word);
    expect_word(stream, "normal");
    mesh.face_normals.push_back(float_vector(stream));
    expect_word(stream, "outer");
    expect_word(stream, "loop");
    const unsigned first = static_cast<unsigned>(mesh.positions.size());
    for (int corner = 0; corner < 3; ++corner) {
      expect_word(stream, "vertex");
      mesh.positions.emplace_back(float_vector(stream));
    }
    mesh.triangles.emplace_back(first, first + 1, first + 2);
    expect_word(stream, "endloop");
    expect_word(stream, "endfacet");
  }
  std::getline(stream, line);
  expect(line == " " + mesh.name, "another name at the end:" + line);
  return mesh;
}

std::vector<ParsedMesh> load_gltf(const std::string& path) {
  tinygltf::TinyGLTF loader;
  tinygltf::Model model;
  std::string error;
  std::string warning;
  const bool loaded = path.ends_with(".glb") ? loader.LoadBinaryFromFile(&model, &error, &warning, path)
                                             : loader.LoadASCIIFromFile(&model, &error, &warning, path);
  expect(loaded && error.empty() && warning.empty(), error + warning);

  const auto element = [&](int accessor_index, std::size_t i, std::size_t component) {
    const tinygltf::Accessor& accessor = model.accessors.at(static_cast<std::size_t>(accessor_index));
    const tinygltf::BufferView& view = model.bufferViews.at(static_cast<std::size_t>(accessor.bufferView));
    const int stride = accessor.ByteStride(view);
    expect(stride > 0, "no stride");
    return &model.buffers.at(0).data.at(view.byteOffset + accessor.byteOffset + i * static_cast<std::size_t>(stride) +
                                        component);
  };
  const auto vectors = [&](int accessor) {
    std::vector<glm::vec3> values(model.accessors.at(static_cast<std::size_t>(accessor)).count);
    for (std::size_t i = 0; i < values.size(); ++i) std::memcpy(&values[i], element(accessor, i, 0), sizeof(glm::vec3));
    return values;
  };
  const auto index = [&](int accessor, std::size_t i) -> unsigned {
    std::uint32_t value = 0;
    const int type = model.accessors.at(static_cast<std::size_t>(accessor)).componentType;
    std::memcpy(&value, element(accessor, i, 0), type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ? 2 : 4);
    return value;
  };

  std::vector<ParsedMesh> meshes;
  for (const int node_index : model.scenes.at(static_cast<std::size_t>(model.defaultScene)).nodes) {
    const tinygltf::Node& node = model.nodes.at(static_cast<std::size_t>(node_index));
    ParsedMesh& mesh = meshes.emplace_back();
    mesh.name = node.name;
    if (!node.translation.empty()) mesh.origin = {node.translation[0], node.translation[1], node.translation[2]};
    if (node.mesh < 0) continue;
    const tinygltf::Primitive& primitive = model.meshes.at(static_cast<std::size_t>(node.mesh)).primitives.at(0);
    const auto positions = vectors(primitive.attributes.at("POSITION"));
    mesh.positions.assign(positions.begin(), positions.end());
    if (primitive.attributes.contains("NORMAL")) mesh.normals = vectors(primitive.attributes.at("NORMAL"));
    const bool indexed = primitive.indices >= 0;
    const std::size_t corners =
        indexed ? model.accessors.at(static_cast<std::size_t>(primitive.indices)).count : mesh.positions.size();
    for (std::size_t i = 0; i < corners; i += 3) {
      glm::uvec3& triangle = mesh.triangles.emplace_back();
      for (unsigned c = 0; c < 3; ++c) {
        triangle[static_cast<int>(c)] = indexed ? index(primitive.indices, i + c) : static_cast<unsigned>(i + c);
      }
    }
  }
  return meshes;
}

}  // namespace isoextract::test
