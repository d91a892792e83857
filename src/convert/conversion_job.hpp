// One conversion as a value: what to read, which surfaces, how they are placed, where they are written. Made of plain
// values, so that jobs can be compared, stored and hashed; nothing is opened, and defaults are those of the program.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <glm/glm.hpp>

#include "base/words.hpp"
#include "convert/backends.hpp"
#include "convert/iso_choice.hpp"
#include "convert/json_type.hpp"
#include "convert/placement.hpp"
#include "convert/surface_edits.hpp"
#include "convert/vertex_choices.hpp"
#include "extract/extractor.hpp"
#include "field/interpolant.hpp"
#include "field/resample.hpp"
#include "mesh_io/mesh_writer.hpp"
#include "points/method.hpp"
#include "render/camera.hpp"
#include "volume_io/grid_tools.hpp"
#include "volume_io/volume_reader.hpp"

namespace isoextract::convert {

enum class Normals {
  none,
  flat,    // one a triangle
  smooth,  // at vertices: the field's gradient, as far as it agrees with the triangles (mesh/shading_normals.hpp)
  area,    // at vertices: of the triangles around, weighted by their areas
};
constexpr auto words_of(Normals /*type*/) {
  return std::array{Word{Normals::none, "none"}, Word{Normals::flat, "flat"}, Word{Normals::smooth, "smooth"},
                    Word{Normals::area, "area"}};
}

[[nodiscard]] constexpr bool are_of_triangles(Normals normals) {
  return normals == Normals::flat || normals == Normals::area;
}

// What becomes of a surface without triangles.
enum class EmptyPolicy {
  error,  // ErrorCode::input
  skip,   // it is left out; a file without any surface is not written, and an old one of its name is removed
  write,  // an empty mesh
};
constexpr auto words_of(EmptyPolicy /*type*/) {
  return std::array{Word{EmptyPolicy::error, "error"}, Word{EmptyPolicy::skip, "skip"},
                    Word{EmptyPolicy::write, "write"}};
}

// How particles become the field that is extracted. A volume needs none of it.
struct ParticleOptions {
  static constexpr std::array kMembers{"expected", "method",  "radius",     "cell_size", "smoothing_length",
                                       "weight",   "deposit", "not_finite", "columns"};

  // The input is of particles: one that could be either is read so, and a volume is refused. Otherwise its content
  // decides.
  bool expected = false;
  points::Method method = points::Method::sph;
  std::optional<double> radius;     // of a particle, world units; else by the distances of the particles, and for level
                                    // sets first of all by points::kRadiusAttributes
  std::optional<double> cell_size;  // spacing of the samples, in radii; else that of the method
  double smoothing_length = 2;      // sph, anisotropic, smooth: in radii
  double weight = 0.1;              // weight: what a particle adds
  points::Deposit deposit = points::Deposit::trilinear;
  points::BadParticles bad = points::BadParticles::error;
  std::optional<std::array<std::string, 3>> columns;  // x, y and z: names, or numbers counted from 1

  friend bool operator==(const ParticleOptions&, const ParticleOptions&) = default;
};

// One filter of a level set.
struct FilterStep {
  static constexpr std::array kMembers{"filter", "width"};

  volume_io::LevelSetFilter filter = volume_io::LevelSetFilter::gaussian;
  std::uint64_t width = 1;  // voxels on either side that a value is taken from

  friend bool operator==(const FilterStep&, const FilterStep&) = default;
};

// What is read, what of it is wanted, and where it goes.
struct SourceOptions {
  std::string input;            // a path, "-" for standard input, or demo:NAME
  volume_io::ReadOptions read;  // of particles its format, and its volume as the number of a frame
  // Further grids of the input: their surfaces follow those of read.grid. Each has the same iso values, placement and
  // filters. Of volumes only.
  std::vector<std::string> more_grids;
  ParticleOptions particles;
  std::vector<FilterStep> filters;          // of what was read or made, one after the other
  std::vector<BlurStep> blurs;              // and then these
  std::vector<AttributeChoice> attributes;  // of the vertices; their names differ
  std::optional<glm::ivec3> resolution;     // of the grid to extract from, in place of the input's own samples
  std::optional<glm::dvec3> voxel_size;     // likewise, in the input's world; not with resolution
  // In place of read.kind: inside is above an iso value that is positive, below one that is negative, and at 0 as the
  // field has it. Of volumes only.
  bool away_from_zero = false;
  field::ResampleKernel kernel = field::ResampleKernel::linear;  // between the input's samples, for that
  std::optional<field::Box> roi;                                 // in the coordinates of placement.space
  bool roi_snap = false;                                         // RegionEnds::samples
  std::vector<ClipPlane> clip;                                   // likewise; of the surfaces, not of the samples
  Placement placement;

  // Whether the grid to extract from is another than the input's.
  [[nodiscard]] bool resamples() const { return resolution || voxel_size; }

  friend bool operator==(const SourceOptions&, const SourceOptions&) = default;
};

struct SurfaceOptions {
  extract::Method method = extract::Method::mc;
  extract::NanPolicy nan = extract::NanPolicy::error;
  bool cap = false;
  extract::VoxelFaces voxel_faces = extract::VoxelFaces::merged;
  std::uint64_t relaxations = extract::kUsualRelaxations;

  // Whether vertices are moved from the corners of voxels.
  [[nodiscard]] bool relaxes() const { return method == extract::Method::surface_nets && relaxations > 0; }

  friend bool operator==(const SurfaceOptions&, const SurfaceOptions&) = default;
};

// One file to write (glTF: one pair of files), and the surfaces in it.
struct OutputFileJob {
  static constexpr std::array kMembers{"path", "iso", "grid"};

  std::string path;  // "-" is standard output; with kPieceWord in it, each piece of the surface has a file
  std::vector<IsoChoice> isos;
  std::optional<std::string> grid = {};  // whose surfaces are in it; none: those of all grids

  friend bool operator==(const OutputFileJob&, const OutputFileJob&) = default;
};

// Meshes of the surfaces.
struct MeshFileOptions {
  mesh_io::MeshFormat format = mesh_io::MeshFormat::glb;
  bool ascii = false;
  mesh_io::PackingOptions packing = {};

  friend bool operator==(const MeshFileOptions&, const MeshFileOptions&) = default;
};

// The field itself, as an OpenVDB file: outputs have no iso values then, and what is about meshes does nothing.
struct FieldFileOptions {
  static constexpr std::array kMembers{"half"};

  bool as_half = false;  // values of 16 bits

  friend bool operator==(const FieldFileOptions&, const FieldFileOptions&) = default;
};

// A picture of the surfaces, as a PNG file (render/preview.hpp). Its up axis is that of the input's world.
struct PictureFileOptions {
  static constexpr int kMaxSide = render::PictureSize::kMaxSide;

  std::int64_t width = 960;  // pixels, from 1 to kMaxSide
  std::int64_t height = 720;
  render::ViewAngles angles;

  friend bool operator==(const PictureFileOptions&, const PictureFileOptions&) = default;
};

using FileOptions = std::variant<MeshFileOptions, FieldFileOptions, PictureFileOptions>;

// What labels of a label map are called, and their colours (label_table.hpp).
struct LabelTableFile {
  static constexpr std::array kMembers{"path", "hash"};

  std::string path;
  std::string hash;  // of its content, when the job was made

  friend bool operator==(const LabelTableFile&, const LabelTableFile&) = default;
};

struct ConversionJob {
  SourceOptions source;
  SurfaceOptions surface;
  Normals normals = Normals::smooth;
  std::optional<ColourChoice> colour;
  std::optional<LabelTableFile> label_names;
  // Of the surfaces, as many as there are iso values and in their order, each above 0 and at most 1; or one for all.
  // Empty: they are opaque, unless iso values colour several: then outer ones let inner ones be seen.
  std::vector<double> opacity;
  SurfaceEdits edits;
  std::optional<field::Interpolation> error;  // what the meshes are measured against; nothing: they are not
  bool verify = false;                        // the other backend is asked as well, and must agree
  BackendChoice backend;
  EmptyPolicy empty = EmptyPolicy::error;
  FileOptions file;  // of each output
  std::vector<OutputFileJob> outputs;

  // The options of that kind of file; null where another kind is written.
  template <class Options>
  [[nodiscard]] const Options* writes() const {
    return std::get_if<Options>(&file);
  }
  // The options of meshes; those of a glb file where the field or a picture is written.
  [[nodiscard]] MeshFileOptions meshes() const;

  // Of all outputs, in their order.
  [[nodiscard]] std::vector<IsoChoice> isos() const;

  friend bool operator==(const ConversionJob&, const ConversionJob&) = default;
};

// Every member by name; what is not set is null. As text it is UTF-8, which paths need not be.
[[nodiscard]] Json json_of(const ConversionJob& job);

// 32 hexadecimal digits that stand for everything in the job: the same for equal jobs, on every machine and in every
// run of a version, and different for different ones but for chance. XXH3, 128 bits, of the CBOR of its JSON.
[[nodiscard]] std::string hash_of(const ConversionJob& job);

}  // namespace isoextract::convert
