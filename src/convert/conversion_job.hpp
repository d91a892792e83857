// One conversion as a value type: the input, the surfaces to extract, their placement and the output files. A job has
// plain values only, so that it can be compared, stored and hashed. The defaults are those of the command line for
// marching cubes of a volume into GLB. For other methods, inputs and formats the command line sets some members
// differently, such as `normals`.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <glm/glm.hpp>

#include "base/enum_words.hpp"
#include "convert/backends.hpp"
#include "convert/iso_choice.hpp"
#include "convert/json_type.hpp"
#include "convert/placement.hpp"
#include "convert/surface_edits.hpp"
#include "convert/vertex_choices.hpp"
#include "extract/extractor.hpp"
#include "extract/height_field.hpp"
#include "field/interpolant.hpp"
#include "field/resample.hpp"
#include "mesh_io/mesh_writer.hpp"
#include "particle_io/particle_writer.hpp"
#include "points/element_radii.hpp"
#include "points/method.hpp"
#include "render/camera.hpp"
#include "render/preview.hpp"
#include "volume_io/grid_tools.hpp"
#include "volume_io/volume_reader.hpp"
#include "volume_io/volume_writer.hpp"

namespace isoextract::convert {

enum class Normals {
  none,
  flat,  // one normal for each triangle
  // At vertices: the field's gradient. Caps get the normal of their plane. Simplified meshes get normals of the
  // triangles where the gradient disagrees (mesh/shading_normals.hpp), smoothed meshes everywhere (edit::smooth()).
  smooth,
  area,  // at vertices: area-weighted mean of the adjacent triangles' normals
};
constexpr auto words_of(Normals /*type*/) {
  return std::array{Word{Normals::none, "none"}, Word{Normals::flat, "flat"}, Word{Normals::smooth, "smooth"},
                    Word{Normals::area, "area"}};
}

// Returns whether the normals follow from the triangles alone, without the field's gradient.
[[nodiscard]] constexpr bool are_per_triangle(Normals normals) {
  return normals == Normals::flat || normals == Normals::area;
}

// Handling of a surface without triangles.
enum class EmptyPolicy {
  error,  // fails with ErrorCode::no_surface or ErrorCode::empty_grid
  skip,   // leaves the surface out; a file without any surface is not written, and an old file of that name is removed
  write,  // writes an empty mesh
};
constexpr auto words_of(EmptyPolicy /*type*/) {
  return std::array{Word{EmptyPolicy::error, "error"}, Word{EmptyPolicy::skip, "skip"},
                    Word{EmptyPolicy::write, "write"}};
}

// The box of a particle simulation. Unset members are as the file says.
struct BoxOptions {
  static constexpr std::array kMembers{"bounds", "periodic", "unwrap"};

  std::optional<field::Box> bounds;
  // Along which edges the box is periodic. Unset: as the file's box, or along all edges if the file has no box.
  std::optional<std::array<bool, 3>> periodic;
  bool unwrap = false;  // moves particles by their image flags, so that bodies cut by the box are whole

  // Returns whether the options request a periodic box.
  [[nodiscard]] bool is_periodic() const { return periodic && ((*periodic)[0] || (*periodic)[1] || (*periodic)[2]); }

  friend bool operator==(const BoxOptions&, const BoxOptions&) = default;
};

// How particles become the field that is extracted. Unused for volumes.
struct ParticleOptions {
  static constexpr std::array kMembers{"expected",      "method",    "radius",           "sequence_radius",
                                       "element_radii", "cell_size", "sequence_spacing", "smoothing_length",
                                       "weight",        "deposit",   "not_finite",       "columns",
                                       "select",        "stride",    "simulation_box"};

  // Reads the input as particles even if it could be a volume too, and refuses a volume. If false, the input's content
  // decides.
  bool expected = false;
  points::Method method = points::Method::sph;
  // Particle radius in world units. If unset, the radius is that of the particles' elements (`element_radii`), or of
  // their own attribute (points::kRadiusAttributes), else `sequence_radius`, else points::suggest_radius().
  std::optional<double> radius;
  std::optional<double> sequence_radius;  // found for all frames of a sequence (find_radius())
  // Radii of atoms (points/element_radii.hpp), in the unit of the placement or else of the file; in angstrom if neither
  // states a unit.
  std::optional<points::ElementRadii> element_radii;
  std::optional<double> cell_size;  // sample spacing, in particle radii; unset: default of the method
  // Sample spacing in world units for spheres of unlike radii without a cell size, found for all frames of a sequence
  // (find_sphere_spacing()).
  std::optional<double> sequence_spacing;
  double smoothing_length = 2;  // for sph, anisotropic, smooth; in particle radii
  double weight = 0.1;          // for weight: the value that each particle adds
  points::Deposit deposit = points::Deposit::trilinear;
  points::NonFiniteParticles non_finite = points::NonFiniteParticles::error;
  std::optional<std::array<std::string, 3>> columns;  // the x, y and z columns: names, or numbers counted from 1
  std::optional<std::string> select;  // condition that particles have to fulfill (points/selection_expression.hpp)
  std::uint64_t stride = 1;           // uses every stride-th of the particles that fulfill `select`, from the first on
  BoxOptions simulation_box;

  friend bool operator==(const ParticleOptions&, const ParticleOptions&) = default;
};

// One filter of a level set.
struct FilterStep {
  static constexpr std::array kMembers{"filter", "width"};

  volume_io::LevelSetFilter filter = volume_io::LevelSetFilter::gaussian;
  std::uint64_t reach = 1;  // in voxels

  friend bool operator==(const FilterStep&, const FilterStep&) = default;
};

// The input, the part of it that is wanted, and its placement.
struct SourceOptions {
  std::string input;  // a path, "-" for standard input, or demo:NAME
  bool mesh = false;  // the input is a mesh file; only `clip` and `placement` then have an effect
  // The files of masks, one mesh each, which together are the input (convert/mask_layers.hpp). read.volume is unset
  // then.
  std::vector<std::string> masks;
  volume_io::ReadOptions read;  // for particles: the format, the point grid, and `volume` as the number of a frame
  // Further grids of the input. Their surfaces follow those of read.grid, with the same iso values, placement and
  // filters, in outputs without OutputFileJob::grid. Volumes only.
  std::vector<std::string> more_grids;
  ParticleOptions particles;
  std::vector<FilterStep> filters;          // applied in order to the field that was read or made from particles
  std::vector<BlurStep> blurs;              // applied in order after the filters
  std::vector<AttributeChoice> attributes;  // vertex attributes; their names differ
  // Number of samples per axis after resampling; unset: the input's samples. At most one of resolution and voxel_size
  // is set.
  std::optional<glm::ivec3> resolution;
  // Edge lengths of a voxel after resampling, in units of the input's world. The actual lengths differ a little, so
  // that a whole number of steps fits the data (field::resolution_of_voxel_size()).
  std::optional<glm::dvec3> voxel_size;
  // Chooses the inside by the sign of the iso value instead of by read.kind: inside is above a positive iso value and
  // below a negative one. At 0 the field's own kind decides. Volumes only.
  bool away_from_zero = false;
  field::ResampleKernel kernel = field::ResampleKernel::linear;  // interpolates the input's samples when resampling
  // Region to extract, in the coordinates of placement.space.
  std::optional<field::Box> roi;
  bool roi_snap = false;  // ends surfaces at samples (RegionEnds::samples) instead of cutting them at the faces
  // Clips the surfaces, not the samples; in the coordinates of placement.space.
  std::vector<ClipPlane> clip;
  Placement placement;

  // Returns whether the input is resampled before extraction.
  [[nodiscard]] bool resamples() const { return resolution || voxel_size; }

  friend bool operator==(const SourceOptions&, const SourceOptions&) = default;
};

struct SurfaceOptions {
  extract::Method method = extract::Method::mc;
  extract::NanPolicy nan = extract::NanPolicy::error;
  bool cap = false;
  extract::VoxelFaces voxel_faces = extract::VoxelFaces::merged;
  std::uint64_t relaxations = extract::kDefaultRelaxations;
  std::int64_t background = 0;     // of a label map: the label without a mesh, unless it is listed
  std::uint64_t least_voxels = 0;  // labels with fewer voxels get no mesh
  // Makes terrain of heights (extract/height_field.hpp) instead of an isosurface; read.flat is set then.
  std::optional<extract::HeightOptions> heights = {};

  // Returns whether surface nets smooth their vertices.
  [[nodiscard]] bool relaxes() const { return method == extract::Method::surface_nets && relaxations > 0; }

  friend bool operator==(const SurfaceOptions&, const SurfaceOptions&) = default;
};

// One file to write (for glTF: the .gltf and .bin pair), and the surfaces in it.
struct OutputFileJob {
  static constexpr std::array kMembers{"path", "iso", "grid"};

  // "-" is standard output. With PieceChoice::split, kPiecePlaceholder gives each body a file; kLabelPlaceholder and
  // kNamePlaceholder give each label one.
  std::string path;
  std::vector<IsoChoice> isos;
  std::optional<std::string> grid = {};  // the grid whose surfaces go into the file; nullopt: surfaces of all grids

  friend bool operator==(const OutputFileJob&, const OutputFileJob&) = default;
};

// Writes the surfaces as meshes.
struct MeshFileOptions {
  mesh_io::MeshFormat format = mesh_io::MeshFormat::glb;
  bool ascii = false;
  mesh_io::PackingOptions packing = {};

  friend bool operator==(const MeshFileOptions&, const MeshFileOptions&) = default;
};

// Writes the field itself. The outputs then have no iso values, and mesh options have no effect.
struct FieldFileOptions {
  static constexpr std::array kMembers{"half", "format"};

  bool as_half = false;                                                   // stores 16-bit floats; vdb and npy only
  volume_io::VolumeFileFormat format = volume_io::VolumeFileFormat::vdb;  // not raw

  friend bool operator==(const FieldFileOptions&, const FieldFileOptions&) = default;
};

// Writes the particles instead of a surface: the chosen ones, with all their attributes. The outputs then have no iso
// values, and options of fields, surfaces and meshes have no effect.
struct ParticleFileOptions {
  static constexpr std::array kMembers{"format"};

  particle_io::ParticleFileFormat format = particle_io::ParticleFileFormat::bgeo;

  friend bool operator==(const ParticleFileOptions&, const ParticleFileOptions&) = default;
};

// Draws the surfaces into a PNG file (render/preview.hpp). The picture's up axis is that of the input's world.
struct PictureFileOptions {
  static constexpr int kMaxSide = render::PictureSize::kMaxSide;

  std::int64_t width = 960;  // pixels, from 1 to kMaxSide
  std::int64_t height = 720;
  render::ViewAngles angles;
  double fovy = render::Camera::kDefaultFovy;                        // vertical field of view, radians
  glm::dvec4 background = render::PreviewOptions::kUsualBackground;  // linear, straight alpha

  friend bool operator==(const PictureFileOptions&, const PictureFileOptions&) = default;
};

using FileOptions = std::variant<MeshFileOptions, FieldFileOptions, PictureFileOptions, ParticleFileOptions>;

// A file with the names and colors of labels (volume_io/label_table.hpp).
struct LabelTableFile {
  static constexpr std::array kMembers{"path", "hash"};

  std::string path;
  std::string hash;  // of the file's content when the job was made

  friend bool operator==(const LabelTableFile&, const LabelTableFile&) = default;
};

struct ConversionJob {
  SourceOptions source;
  SurfaceOptions surface;
  Normals normals = Normals::smooth;
  std::optional<ColorChoice> color;
  std::optional<LabelTableFile> label_names;
  // Opacities, each above 0 and at most 1: one for all surfaces, or one for each iso value in order. Empty: surfaces
  // are opaque, except that with several iso values colored by iso value the outer surfaces are translucent.
  std::vector<double> opacity;
  SurfaceEdits edits;
  // The interpolant to measure the meshes' error against; nullopt: no measurement.
  std::optional<field::Interpolation> error;
  bool verify = false;  // extracts with the other backend as well, and fails if the two disagree
  BackendChoice backend;
  EmptyPolicy empty = EmptyPolicy::error;
  FileOptions file;  // kind and options of all outputs
  std::vector<OutputFileJob> outputs;

  // Returns the options of this kind of file, or null if the job writes another kind.
  template <class Options>
  [[nodiscard]] const Options* writes() const {
    return std::get_if<Options>(&file);
  }
  // Returns whether the job extracts surfaces, for meshes or pictures.
  [[nodiscard]] bool makes_surfaces() const {
    return writes<FieldFileOptions>() == nullptr && writes<ParticleFileOptions>() == nullptr;
  }
  // Returns whether the surfaces are extracted from a field, and not read from a mesh file.
  [[nodiscard]] bool extracts() const { return makes_surfaces() && !source.mesh; }
  // Returns the mesh options, or the default (GLB) options if the job writes something else.
  [[nodiscard]] MeshFileOptions meshes() const;

  // Returns the iso values of all outputs, in order.
  [[nodiscard]] std::vector<IsoChoice> isos() const;

  friend bool operator==(const ConversionJob&, const ConversionJob&) = default;
};

// Returns all settings by name. Unset optional settings are null; units that were not given are empty texts. JSON text
// cannot hold paths that are not UTF-8, so hash_of() uses CBOR.
[[nodiscard]] Json json_of(const ConversionJob& job);

// Returns 32 hexadecimal digits: XXH3 (128 bits) of the CBOR of the job's JSON. Equal jobs have equal hashes on every
// machine and in every run of one version of the program (0 and -0 count as different numbers); different jobs have
// different hashes, barring collisions.
[[nodiscard]] std::string hash_of(const ConversionJob& job);

}  // namespace isoextract::convert
