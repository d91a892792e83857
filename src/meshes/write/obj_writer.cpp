// Wavefront OBJ: text; indices start at 1 and count through the whole file.
#include <string>
#include <utility>

#include <fmt/format.h>

#include "base/version.hpp"
#include "files/record_stream.hpp"
#include "meshes/write/mesh_encoding.hpp"
#include "meshes/write/mesh_format_writers.hpp"

namespace isoextract::meshes {
namespace {

// The indices that the next mesh starts with.
struct Next {
  std::uint64_t vertex = 1;
  std::uint64_t normal = 1;
};

Result<void> write_vertices(const mesh::Mesh& mesh, files::OutputFile& file) {
  return visit_positions(mesh, [&](auto position) {
    constexpr std::size_t kLine = 2 + kMaxVectorText<typename decltype(position(0))::value_type>;
    return files::write_records(file, mesh.positions.size(), kLine,
                                [&](std::size_t first, std::size_t last, char* out) {
                                  for (std::size_t v = first; v < last; ++v) {
                                    *out++ = 'v';
                                    out = put_vector(out, position(v));
                                    *out++ = '\n';
                                  }
                                  return out;
                                });
  });
}

template <class Normal>
Result<void> write_normals(std::size_t count, Normal normal, files::OutputFile& file) {
  constexpr std::size_t kLine = 3 + kMaxVectorText<float>;
  return files::write_records(file, count, kLine, [&](std::size_t first, std::size_t last, char* out) {
    for (std::size_t n = first; n < last; ++n) {
      out = put_text(out, "vn");
      out = put_vector(out, normal(n));
      *out++ = '\n';
    }
    return out;
  });
}

enum class Normals { none, of_vertices, of_faces };

Result<void> write_faces(const mesh::Mesh& mesh, Normals normals, const Next& next, files::OutputFile& file) {
  constexpr std::size_t kCorner = 1 + kMaxNumberText<std::uint64_t> + 2 + kMaxNumberText<std::uint64_t>;
  constexpr std::size_t kLine = 1 + 3 * kCorner + 1;
  return files::write_records(file, mesh.triangles.size(), kLine, [&](std::size_t first, std::size_t last, char* out) {
    for (std::size_t t = first; t < last; ++t) {
      *out++ = 'f';
      for (int corner = 0; corner < 3; ++corner) {
        const std::uint64_t vertex = mesh.triangles[t][corner];
        *out++ = ' ';
        out = put_number(out, next.vertex + vertex);
        if (normals == Normals::none) continue;
        out = put_text(out, "//");
        out = put_number(out, next.normal + (normals == Normals::of_faces ? t : vertex));
      }
      *out++ = '\n';
    }
    return out;
  });
}

class ObjWriter final : public FormatWriter {
 public:
  ObjWriter(bool flat_normals, files::OutputFile& file) : flat_normals_(flat_normals), file_(file) {}

  Result<void> add(const mesh::Mesh& mesh, Notes& /*notes*/) override {
    const Normals normals = flat_normals_           ? Normals::of_faces
                            : !mesh.normals.empty() ? Normals::of_vertices
                                                    : Normals::none;
    const auto write_all_normals = [&]() -> Result<void> {
      if (normals == Normals::of_faces) {
        return write_normals(
            mesh.triangles.size(), [&](std::size_t t) { return face_normal(mesh, mesh.triangles[t]); }, file_);
      }
      return write_normals(
          mesh.normals.size(), [&](std::size_t v) { return mesh.normals[v]; }, file_);
    };
    auto written = write_header();
    if (written && !mesh.name.empty()) written = file_.write(fmt::format("o {}\n", one_line(mesh.name)));
    if (written) written = write_vertices(mesh, file_);
    if (written) written = write_all_normals();
    if (written) written = write_faces(mesh, normals, next_, file_);
    next_.vertex += mesh.positions.size();
    next_.normal += normals == Normals::of_faces ? mesh.triangles.size() : mesh.normals.size();
    return written;
  }

  Result<void> finish(Notes& /*notes*/) override { return write_header(); }

 private:
  // Once, before the first mesh; also of a file without any.
  Result<void> write_header() { return file_.write(std::exchange(header_, {})); }

  bool flat_normals_;
  files::OutputFile& file_;
  std::string header_ = fmt::format("# {}\n", generator());
  Next next_;
};

}  // namespace

std::unique_ptr<FormatWriter> make_obj_writer(const MeshWriteOptions& options, files::OutputFile& file) {
  return std::make_unique<ObjWriter>(options.flat_normals, file);
}

}  // namespace isoextract::meshes
