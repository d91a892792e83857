// write_sample_meshes FOLDER: writes every kind of mesh in every format that the writers know, for programs of others
// to open: the glTF validator here, Blender and MeshLab in scripts/check_in_viewers.py.
#include <cstdio>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mesh_io/animation_writer.hpp"
#include "mesh_io/mesh_writer.hpp"
#include "support/sample_attributes.hpp"
#include "support/sample_meshes.hpp"

namespace {

using namespace isoextract;
using namespace isoextract::test;

struct Sample {
  std::string name;
  std::function<std::vector<mesh::Mesh>()> make;
  bool flat_normals = false;
  bool ascii = false;
  mesh_io::MeshPacking packing = {};
};

template <class... Meshes>
std::vector<mesh::Mesh> list(Meshes... meshes) {
  std::vector<mesh::Mesh> all;
  (all.push_back(std::move(meshes)), ...);
  return all;
}

mesh::Mesh nothing(std::string name) { return make_mesh(std::move(name), {}, {}); }

mesh::Mesh one_triangle() { return make_mesh("triangle", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}); }

// Attributes of sizes that fill four bytes and that do not.
mesh::Mesh with_attributes(mesh::ComponentType color, std::size_t components) {
  mesh::Mesh mesh = sphere(24, false, "colored");
  add_color(mesh, color, components);
  add_attribute(mesh, "TEMPERATURE", mesh::ComponentType::f32, 1);
  add_attribute(mesh, "label", mesh::ComponentType::u8, 1);
  add_attribute(mesh, "way", mesh::ComponentType::i16, 3, true);
  return mesh;
}

mesh_io::MeshPacking packing(mesh_io::Compression compression, bool quantize, bool optimize_order = false) {
  mesh_io::MeshPacking packing;
  packing.compression = compression;
  packing.quantize = quantize;
  packing.optimize_order = optimize_order;
  packing.voxel = 0.1;
  return packing;
}

std::vector<std::pair<std::string, mesh_io::MeshPacking>> ways_of_packing() {
  using mesh_io::Compression;
  return {{"draco", packing(Compression::draco, false)},
          {"quantized", packing(Compression::none, true)},
          {"meshopt", packing(Compression::meshopt, false)},
          {"meshopt_quantized", packing(Compression::meshopt, true)},
          {"meshopt_quantized_ordered", packing(Compression::meshopt, true, true)},
          {"ordered", packing(Compression::none, false, true)}};
}

// Every way of packing, with vertices of their own for each triangle and without.
std::vector<Sample> packed_samples() {
  const glm::dvec3 far(4e4 + 1.0 / 3, -7e4, 1.0 / 7);
  std::vector<Sample> samples;
  for (const auto& [name, way] : ways_of_packing()) {
    samples.push_back({name, [] { return list(sphere(24, true)); }, false, false, way});
    samples.push_back({name + "_flat", [] { return list(sphere(24, false)); }, true, false, way});
    samples.push_back({name + "_far", [far] { return list(sphere(24, true, "far", far)); }, false, false, way});
    samples.push_back(
        {name + "_attributes",
         [] { return list(with_attributes(mesh::ComponentType::u8, 3), nothing("none"), one_triangle()); }, false,
         false, way});
  }
  return samples;
}

std::vector<Sample> samples() {
  const glm::dvec3 far(4e4 + 1.0 / 3, -7e4, 1.0 / 7);  // no farther than STL can have it
  return {
      {"plain", [] { return list(sphere(24, false)); }},
      {"normals", [] { return list(sphere(24, true)); }},
      {"flat", [] { return list(sphere(24, false)); }, true},
      {"ascii", [] { return list(sphere(24, false)); }, false, true},
      {"ascii_normals", [] { return list(sphere(24, true)); }, false, true},
      {"ascii_flat", [] { return list(sphere(24, false)); }, true, true},
      {"far", [far] { return list(sphere(24, true, "far", far)); }},
      {"far_flat", [far] { return list(sphere(24, false, "far", far)); }, true},
      {"several",
       [] { return list(one_triangle(), sphere(8, true, "iso 1"), tetrahedron(), sphere(200, false, "2")); }},
      {"several_flat", [] { return list(one_triangle(), sphere(8, false, "iso 1"), tetrahedron()); }, true},
      {"tiny", [] { return list(one_triangle()); }},
      {"many", [] { return list(sphere(200, true)); }},
      {"attributes", [] { return list(with_attributes(mesh::ComponentType::u8, 3)); }},
      {"attributes_flat", [] { return list(with_attributes(mesh::ComponentType::u16, 3)); }, true},
      {"attributes_and_none", [] { return list(with_attributes(mesh::ComponentType::f32, 4), one_triangle()); }},
      {"empty", [] { return list(nothing("nothing")); }},
      {"no_mesh", [] { return list(); }},
      {"empty_and_more", [] { return list(nothing("nothing"), tetrahedron(), nothing("")); }},
      {"ünï \"code\" 50% #1", [] { return list(tetrahedron("Ünï \"quoted\" \\ 等値面 \n\U0001F480")); }},
  };
}

bool write(const Sample& sample, const mesh_io::MeshFormatInfo& format, const std::filesystem::path& folder) {
  const std::vector<mesh::Mesh> meshes = sample.make();
  if ((meshes.size() != 1 && !format.can_hold_several_meshes) || (sample.ascii && !format.has_text_option)) return true;
  if (!mesh_io::check_packing(sample.packing, format.format)) return true;
  if (format.format == mesh_io::MeshFormat::drc && meshes[0].triangles.empty()) return true;
  // One folder a format: the .bin of one model must not have the name of another's.
  const std::filesystem::path path = folder / format.name / (sample.name + "." + std::string(format.name));
  std::filesystem::create_directories(path.parent_path());
  const auto written = mesh_io::write_meshes(
      meshes, path, {format.format, sample.flat_normals, sample.ascii, sample.packing}, Context());
  if (!written) std::fprintf(stderr, "%s\n", written.error().message.c_str());
  return written.has_value();
}

// Around all of them.
std::optional<mesh::Bounds> box_of(const std::vector<mesh::Mesh>& surfaces) {
  std::optional<mesh::Bounds> box;
  for (const mesh::Mesh& surface : surfaces) {
    for (std::size_t v = 0; v < surface.positions.size(); ++v) {
      const glm::dvec3 p = surface.position(v);
      box = box ? mesh::Bounds{glm::min(box->min, p), glm::max(box->max, p)} : mesh::Bounds{p, p};
    }
  }
  return box;
}

// Sequences, with gaps and frames of all kinds; several files of one, where `largest` is what a file may be.
bool write_animation(const std::string& name, bool flat_normals, const std::filesystem::path& folder,
                     std::uint64_t largest = mesh_io::kLargestGlb, mesh_io::MeshPacking packing = {}) {
  const std::filesystem::path path = folder / "animated" / (name + ".glb");
  std::filesystem::create_directories(path.parent_path());
  mesh_io::AnimationWriter writer(path, {mesh_io::MeshFormat::glb, flat_normals, false}, 24, 8, Context(), largest);
  Result<void> added;
  const auto add = [&](std::int64_t frame, const std::vector<mesh::Mesh>& surfaces) {
    packing.box = box_of(surfaces);
    if (added) added = writer.add("frame " + std::to_string(frame), frame, surfaces, packing);
  };
  add(1, list(nothing("nothing")));
  add(2, list(sphere(24, false)));
  add(3, list(one_triangle(), nothing("nothing"), sphere(8, false, "iso 1", {5, 0, 0})));
  add(7, list(with_attributes(mesh::ComponentType::u8, 3)));
  add(8, list());
  add(9, list(sphere(24, false, "far", {1e4 + 1.0 / 3, 0, 0})));
  add(10, list(tetrahedron("Ünï \"quoted\" 等値面")));
  const auto finished = added ? writer.finish() : tl::unexpected<Error>(added.error());
  if (!finished) std::fprintf(stderr, "%s\n", finished.error().message.c_str());
  return finished.has_value();
}

bool write_empty_animation(const std::filesystem::path& folder) {
  mesh_io::AnimationWriter writer(folder / "animated" / "empty.glb", {}, 24, 1, Context());
  return writer.add("nothing", 1, nothing("nothing")) && writer.finish();
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: write_sample_meshes FOLDER\n");
    return 1;
  }
  bool good = true;
  std::vector<Sample> all = samples();
  for (Sample& sample : packed_samples()) all.push_back(std::move(sample));
  for (const Sample& sample : all) {
    for (const mesh_io::MeshFormatInfo& format : mesh_io::mesh_formats()) good = write(sample, format, argv[1]) && good;
  }
  constexpr std::uint64_t kSmall = 80'000;  // less than two of the spheres together
  good = write_animation("smooth", false, argv[1]) && good;
  good = write_animation("flat", true, argv[1]) && good;
  good = write_animation("split", false, argv[1], kSmall) && good;
  for (const auto& [name, way] : ways_of_packing()) {
    good = write_animation(name + "_smooth", false, argv[1], mesh_io::kLargestGlb, way) && good;
    good = write_animation(name + "_flat", true, argv[1], mesh_io::kLargestGlb, way) && good;
  }
  good = write_empty_animation(argv[1]) && good;
  return good ? 0 : 1;
}
