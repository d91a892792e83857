// PLY (Greg Turk, 1994): a text header, then vertices and faces, binary or text.
#include <algorithm>
#include <array>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "base/version.hpp"
#include "files/record_stream.hpp"
#include "mesh_io/detail/placement_entry.hpp"
#include "mesh_io/write/first_array.hpp"
#include "mesh_io/write/mesh_encoding.hpp"
#include "mesh_io/write/mesh_format_writers.hpp"
#include "mesh_io/write/partwise_writer.hpp"
#include "mesh_io/write/waiting_part.hpp"

namespace isoextract::mesh_io {
namespace {

constexpr std::uint8_t kCorners = 3;

constexpr std::array<std::string_view, 8> kTypeNames{"char", "uchar", "short", "ushort",
                                                     "int",  "uint",  "float", "double"};

// Returns the name as a property name: replaces all but printable ASCII by '_'; "attribute" if empty.
std::string property_name(const std::string& name) {
  std::string text = name.empty() ? std::string("attribute") : name;
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c <= ' ' || c > '~'; }, '_');
  return text;
}

// Returns the header lines of the attributes' properties, component by component.
std::string attribute_properties(const mesh::Mesh& mesh, Notes& notes) {
  constexpr std::array<std::string_view, mesh::kMaxComponents> kColor{"red", "green", "blue", "alpha"};
  std::set<std::string, std::less<>> taken{"x", "y", "z", "nx", "ny", "nz"};
  for (const mesh::Attribute& attribute : mesh.attributes) {
    if (attribute.role == mesh::AttributeRole::color) taken.insert(kColor.begin(), kColor.end());
  }
  std::string text;
  for (const mesh::Attribute& attribute : mesh.attributes) {
    const auto add = [&](std::string_view name) {
      text += fmt::format("property {} {}\n", kTypeNames[static_cast<std::size_t>(attribute.type)], name);
    };
    if (attribute.role == mesh::AttributeRole::color) {
      for (std::size_t c = 0; c < attribute.components; ++c) add(kColor[c]);
      continue;
    }
    std::string stem = property_name(attribute.name);
    const auto name_of = [&](std::size_t c) {
      return attribute.components == 1 ? stem : fmt::format("{}_{}", stem, c);
    };
    const auto is_taken = [&] {
      for (std::size_t c = 0; c < attribute.components; ++c) {
        if (taken.contains(name_of(c))) return true;
      }
      return false;
    };
    while (is_taken()) stem += '_';
    if (stem != attribute.name) {
      notes.push_back({NoteId::attribute_renamed, fmt::format("the writer renames the attribute '{}' to '{}': the name "
                                                              "is not valid in PLY, or another attribute has it",
                                                              attribute.name, stem)});
    }
    if (attribute.normalized) {
      notes.push_back({NoteId::attribute_kind, fmt::format("PLY cannot mark the attribute '{}' as normalized: "
                                                           "other programs read its integers as plain numbers",
                                                           stem)});
    }
    for (std::size_t c = 0; c < attribute.components; ++c) {
      add(name_of(c));
      taken.insert(name_of(c));
    }
  }
  return text;
}

std::size_t attribute_bytes(const mesh::Mesh& mesh) {
  std::size_t bytes = 0;
  for (const mesh::Attribute& attribute : mesh.attributes) bytes += attribute.stride();
  return bytes;
}

using Attributes = std::span<const mesh::Attribute>;

char* put_attributes(char* out, Attributes attributes, std::size_t vertex) {
  for (const mesh::Attribute& attribute : attributes) {
    std::memcpy(out, attribute.values.data() + vertex * attribute.stride(), attribute.stride());
    out += attribute.stride();
  }
  return out;
}

// Returns an upper bound of the text bytes of one vertex's attributes.
std::size_t attribute_text(Attributes attributes) {
  std::size_t size = 0;
  for (const mesh::Attribute& attribute : attributes) size += attribute.components * (1 + kMaxNumberText<double>);
  return size;
}

template <class T>
char* put_component(char* out, const std::byte* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof value);
  if constexpr (std::is_floating_point_v<T>) {
    return put_number(out, value);
  } else {
    return std::to_chars(out, out + kMaxNumberText<T>, value).ptr;
  }
}

char* put_component(char* out, mesh::ComponentType type, const std::byte* bytes) {
  using Type = mesh::ComponentType;
  switch (type) {
    case Type::i8: return put_component<std::int8_t>(out, bytes);
    case Type::u8: return put_component<std::uint8_t>(out, bytes);
    case Type::i16: return put_component<std::int16_t>(out, bytes);
    case Type::u16: return put_component<std::uint16_t>(out, bytes);
    case Type::i32: return put_component<std::int32_t>(out, bytes);
    case Type::u32: return put_component<std::uint32_t>(out, bytes);
    case Type::f32: return put_component<float>(out, bytes);
    case Type::f64: break;
  }
  return put_component<double>(out, bytes);
}

char* put_attribute_text(char* out, Attributes attributes, std::size_t vertex) {
  for (const mesh::Attribute& attribute : attributes) {
    const std::byte* component = attribute.values.data() + vertex * attribute.stride();
    for (std::size_t c = 0; c < attribute.components; ++c) {
      *out++ = ' ';
      out = put_component(out, attribute.type, component);
      component += mesh::component_size(attribute.type);
    }
  }
  return out;
}

std::string header(const mesh::Mesh& mesh, const mesh::MeshShape& shape, const MeshWriteOptions& options,
                   Notes& notes) {
  const auto vector = [](std::string_view type, std::string_view prefix) {
    return fmt::format("property {0} {1}x\nproperty {0} {1}y\nproperty {0} {1}z\n", type, prefix);
  };
  const bool is_double = mesh.origin != glm::dvec3(0);
  std::string text =
      fmt::format("ply\nformat {} 1.0\ncomment {}\n", options.ascii ? "ascii" : "binary_little_endian", generator());
  if (!options.placement.empty()) text += fmt::format("comment {} {}\n", kPlacementEntry, options.placement);
  text += fmt::format("element vertex {}\n", shape.vertices) + vector(is_double ? "double" : "float", "");
  if (!options.flat_normals && shape.has_normals) text += vector("float", "n");
  text += attribute_properties(mesh, notes);
  text += fmt::format("element face {}\nproperty list uchar uint vertex_indices\n", shape.triangles);
  if (options.flat_normals) text += vector("float", "n");
  return text + "end_header\n";
}

constexpr std::size_t kFaceBytes = sizeof(kCorners) + sizeof(glm::uvec3);

char* put_triangle(char* out, const glm::uvec3& triangle) { return put_bytes(put_bytes(out, kCorners), triangle); }

Result<void> write_binary(const mesh::Mesh& mesh, bool vertex_normals, bool face_normals, files::OutputFile& file) {
  const auto write_vertices = [&](auto position) -> Result<void> {
    using Position = decltype(position(0));
    if (std::is_same_v<Position, glm::vec3> && !vertex_normals && mesh.attributes.empty())
      return file.write(std::as_bytes(mesh.positions.span()));
    const std::size_t record = sizeof(Position) + (vertex_normals ? sizeof(glm::vec3) : 0) + attribute_bytes(mesh);
    return files::write_records(file, mesh.positions.size(), record,
                                [&](std::size_t first, std::size_t last, char* out) {
                                  for (std::size_t v = first; v < last; ++v) {
                                    out = put_bytes(out, position(v));
                                    if (vertex_normals) out = put_bytes(out, mesh.normals[v]);
                                    out = put_attributes(out, mesh.attributes, v);
                                  }
                                  return out;
                                });
  };
  TRY(with_world_positions(mesh, write_vertices));

  const std::size_t record = kFaceBytes + (face_normals ? sizeof(glm::vec3) : 0);
  return files::write_records(file, mesh.triangles.size(), record, [&](std::size_t first, std::size_t last, char* out) {
    for (std::size_t t = first; t < last; ++t) {
      out = put_triangle(out, mesh.triangles[t]);
      if (face_normals) out = put_bytes(out, face_normal(mesh, mesh.triangles[t]));
    }
    return out;
  });
}

// put_rest(out, v) writes what follows the position, in at most `most_rest` bytes.
template <class Position, class PutRest>
Result<void> write_vertex_lines(std::size_t count, Position position, std::size_t most_rest, PutRest put_rest,
                                files::OutputFile& file) {
  using Number = typename decltype(position(0))::value_type;
  const std::size_t line_bytes = kMaxVectorText<Number> + most_rest + 1;
  return files::write_records(file, count, line_bytes, [&](std::size_t first, std::size_t last, char* out) {
    for (std::size_t v = first; v < last; ++v) {
      // Overwrites the vector's leading blank, which some readers do not accept.
      char* line = out;
      out = put_vector(out, position(v));
      out = std::copy(line + 1, out, line);
      out = put_rest(out, v);
      *out++ = '\n';
    }
    return out;
  });
}

// put_rest(out, t) writes what follows the indices of a triangle: nothing or a vector.
template <class PutRest>
Result<void> write_face_lines(std::span<const glm::uvec3> triangles, PutRest put_rest, files::OutputFile& file) {
  constexpr std::size_t kLine = 1 + kMaxVectorText<std::uint32_t> + kMaxVectorText<float> + 1;
  return files::write_records(file, triangles.size(), kLine, [&](std::size_t first, std::size_t last, char* out) {
    for (std::size_t t = first; t < last; ++t) {
      *out++ = '0' + kCorners;
      out = put_vector(out, triangles[t]);
      out = put_rest(out, t);
      *out++ = '\n';
    }
    return out;
  });
}

Result<void> write_ascii(const mesh::Mesh& mesh, bool vertex_normals, bool face_normals, files::OutputFile& file) {
  const auto put_rest = [&](char* out, std::size_t v) {
    if (vertex_normals) out = put_vector(out, mesh.normals[v]);
    return put_attribute_text(out, mesh.attributes, v);
  };
  TRY(with_world_positions(mesh, [&](auto position) {
    return write_vertex_lines(mesh.positions.size(), position, kMaxVectorText<float> + attribute_text(mesh.attributes),
                              put_rest, file);
  }));
  return write_face_lines(
      mesh.triangles.span(),
      [&](char* out, std::size_t t) {
        return face_normals ? put_vector(out, face_normal(mesh, mesh.triangles[t])) : out;
      },
      file);
}

// Returns the bytes of a binary vertex of a mesh that comes in parts.
std::size_t vertex_record_bytes(const mesh::Mesh& head, bool has_normals) {
  return (has_normals ? 2 : 1) * sizeof(glm::vec3) + attribute_bytes(head);
}

bool has_positions_only(const mesh::MeshPart& part) { return part.normals.empty() && part.attributes.empty(); }

// Return the binary records of a part: vertices with normals and attributes, or faces. The part must outlive the
// result.
files::FillRecords vertices_of(const mesh::MeshPart& part) {
  return [&part](std::size_t first, std::size_t last, char* out) {
    for (std::size_t v = first; v < last; ++v) {
      out = put_bytes(out, part.positions[v]);
      if (!part.normals.empty()) out = put_bytes(out, part.normals[v]);
      out = put_attributes(out, part.attributes, v);
    }
    return out;
  };
}
files::FillRecords faces_of(const mesh::MeshPart& part) {
  return [&part](std::size_t first, std::size_t last, char* out) {
    for (std::size_t t = first; t < last; ++t) out = put_triangle(out, part.triangles[t]);
    return out;
  };
}

// Returns the binary records of the faces of the part that waits for the vertices in `next`, with their normals.
files::FillRecords flat_faces_of(const WaitingPart& waiting, std::span<const glm::vec3> next) {
  return [&waiting, next](std::size_t first, std::size_t last, char* out) {
    for (std::size_t t = first; t < last; ++t) {
      const std::array corners = waiting.corners(t, next);
      out = put_triangle(out, waiting.triangles()[t]);
      out = put_bytes(out, face_normal(corners[0], corners[1], corners[2]));
    }
    return out;
  };
}

// Writes each vertex and face to its place in a binary file without normals of faces.
class PartwisePlyWriter final : public PartwiseWriter {
 public:
  PartwisePlyWriter(const mesh::Mesh& head, const MeshWriteOptions& options, files::OutputFile& file)
      : head_(head), options_(options), file_(file) {}

  Result<bool> begin_early(const mesh::MeshShape& estimate) override {
    Notes notes;  // begin() adds them
    vertex_bytes_ = vertex_record_bytes(head_, estimate.has_normals);
    vertices_.begin_early(header(head_, estimate, options_, notes).size());
    return true;
  }

  Result<bool> begin(const mesh::MeshShape& shape) override {
    vertex_bytes_ = vertex_record_bytes(head_, shape.has_normals);
    TRY(vertices_.begin(file_, header(head_, shape, options_, notes_), shape.vertices * vertex_bytes_));
    triangles_at_ = TRY(file_.extend(shape.triangles * kFaceBytes));
    return true;
  }

  [[nodiscard]] std::vector<mesh::PartPass> passes() const override {
    return {{.attributes = !head_.attributes.empty()}};
  }

  Result<void> take(const mesh::MeshPart& part) override {
    const std::uint64_t vertices_at = vertices_.place() + part.first_vertex * vertex_bytes_;
    if (has_positions_only(part)) {
      TRY(file_.fill(vertices_at, std::as_bytes(part.positions)));
    } else {
      TRY(files::fill_records(file_, vertices_at, part.positions.size(), vertex_bytes_, vertices_of(part)));
    }
    return files::fill_records(file_, triangles_at_ + part.first_triangle * kFaceBytes, part.triangles.size(),
                               kFaceBytes, faces_of(part));
  }

  Result<void> finish(Notes& notes) override {
    notes.insert(notes.end(), notes_.begin(), notes_.end());
    return {};
  }

 private:
  const mesh::Mesh& head_;
  MeshWriteOptions options_;
  files::OutputFile& file_;
  Notes notes_;  // notes about the attributes
  std::size_t vertex_bytes_ = 0;
  FirstArray vertices_;
  std::uint64_t triangles_at_ = 0;  // file offset of the first triangle
};

// Writes vertices, then faces, in order: for text, streams and face normals. With face normals, a part waits for the
// next part, whose vertices its normals need.
class OrderedPlyWriter final : public PartwiseWriter {
 public:
  OrderedPlyWriter(const mesh::Mesh& head, const MeshWriteOptions& options, const Context& context,
                   files::OutputFile& file)
      : head_(head), options_(options), file_(file), waiting_(context, file.shown_name()) {}

  Result<bool> begin(const mesh::MeshShape& shape) override {
    TRY(file_.write(header(head_, shape, options_, notes_)));
    vertex_bytes_ = vertex_record_bytes(head_, shape.has_normals);
    if (options_.flat_normals) TRY(waiting_.begin(shape));
    return true;
  }

  [[nodiscard]] std::vector<mesh::PartPass> passes() const override {
    return {{.in_order = true, .triangles = false, .attributes = !head_.attributes.empty()},
            {.in_order = true, .positions = options_.flat_normals, .normals = false}};
  }

  Result<void> begin_pass(std::size_t pass) override {
    writes_flat_faces_ = options_.flat_normals && pass == 1;
    return {};
  }

  Result<void> take(const mesh::MeshPart& part) override {
    if (!writes_flat_faces_) return options_.ascii ? write_text(part) : write_binary_part(part);
    TRY(write_flat_faces(part.positions));
    return waiting_.keep(part);
  }

  Result<void> finish(Notes& notes) override {
    notes.insert(notes.end(), notes_.begin(), notes_.end());
    return writes_flat_faces_ ? write_flat_faces({}) : Result<void>();
  }

 private:
  Result<void> write_text(const mesh::MeshPart& part) {
    const auto put_rest = [&](char* out, std::size_t v) {
      if (!part.normals.empty()) out = put_vector(out, part.normals[v]);
      return put_attribute_text(out, part.attributes, v);
    };
    TRY(write_vertex_lines(
        part.positions.size(), [&](std::size_t v) { return part.positions[v]; },
        kMaxVectorText<float> + attribute_text(part.attributes), put_rest, file_));
    return write_face_lines(
        part.triangles, [](char* out, std::size_t /*triangle*/) { return out; }, file_);
  }

  Result<void> write_binary_part(const mesh::MeshPart& part) {
    if (has_positions_only(part)) {
      TRY(file_.write(std::as_bytes(part.positions)));
    } else {
      TRY(files::write_records(file_, part.positions.size(), vertex_bytes_, vertices_of(part)));
    }
    return files::write_records(file_, part.triangles.size(), kFaceBytes, faces_of(part));
  }

  // Writes the faces of the part that waits for the vertices in `next`, with their normals.
  Result<void> write_flat_faces(std::span<const glm::vec3> next) {
    if (!options_.ascii) {
      return files::write_records(file_, waiting_.triangles().size(), kFaceBytes + sizeof(glm::vec3),
                                  flat_faces_of(waiting_, next));
    }
    return write_face_lines(
        waiting_.triangles(),
        [&](char* out, std::size_t t) {
          const std::array corners = waiting_.corners(t, next);
          return put_vector(out, face_normal(corners[0], corners[1], corners[2]));
        },
        file_);
  }

  const mesh::Mesh& head_;
  MeshWriteOptions options_;
  files::OutputFile& file_;
  WaitingPart waiting_;
  Notes notes_;  // notes about the attributes
  std::size_t vertex_bytes_ = 0;
  bool writes_flat_faces_ = false;
};

}  // namespace

std::unique_ptr<PartwiseWriter> make_partwise_ply_writer(const mesh::Mesh& head, const MeshWriteOptions& options,
                                                         const Context& /*context*/, files::OutputFile& file) {
  return std::make_unique<PartwisePlyWriter>(head, options, file);
}

std::unique_ptr<PartwiseWriter> make_ordered_ply_writer(const mesh::Mesh& head, const MeshWriteOptions& options,
                                                        const Context& context, files::OutputFile& file) {
  return std::make_unique<OrderedPlyWriter>(head, options, context, file);
}

Result<void> write_ply(const mesh::Mesh& mesh, const MeshWriteOptions& options, files::OutputFile& file, Notes& notes) {
  TRY(file.write(header(mesh, mesh::shape_of(mesh), options, notes)));
  const bool vertex_normals = !options.flat_normals && !mesh.normals.empty();
  return (options.ascii ? write_ascii : write_binary)(mesh, vertex_normals, options.flat_normals, file);
}

}  // namespace isoextract::mesh_io
