// Opens the input: reads the field, filters, blurs and resamples it if requested, and places it in output coordinates.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/attribute_source.hpp"
#include "convert/conversion_job.hpp"
#include "convert/events.hpp"
#include "convert/iso_values.hpp"
#include "convert/mask_layers.hpp"
#include "convert/particle_choice.hpp"
#include "convert/particle_source.hpp"
#include "mesh/half_space.hpp"
#include "mesh/mesh.hpp"
#include "mesh_io/mesh_writer.hpp"

namespace isoextract::convert {

// Calls read_volume(), sends its notes and the report of the stage `read`, and checks that the mapped file is intact.
[[nodiscard]] Result<field::ScalarField> read_field(const std::string& input, const volume_io::ReadOptions& options,
                                                    const Context& context, Events& events);

struct Source {
  field::ScalarField field;  // the surfaces are extracted from this field
  // The field after reading and filters, before blur and resampling. Set if SourceUse::keep_data is set and blur or
  // resampling changed the field.
  std::optional<field::ScalarField> data;
  ResolvedPlacement placement;
  field::Affine output_from_index;
  std::optional<field::IndexBox> region;
  std::optional<field::IndexBox> period;  // for particles in a periodic box: the samples of one period
  // clip_surface() cuts the surface to the inside of these half-spaces, in output coordinates.
  std::vector<mesh::HalfSpace> clip;
  std::vector<ResolvedIso> isos;  // one for each requested iso value; of a mesh file, one for each mesh
  std::string label;              // name in messages
  bool empty = false;             // the input has no voxels, no particles or no triangles
  bool of_particles = false;
  std::string why_no_particles = {};  // set if the condition chose no particle, or if none lies near the region
  bool region_is_empty = false;       // no particle lies in or near the region
  // Set with SourceOptions::away_from_zero: the field's kind as read, which set_inside_side(0) restores.
  std::optional<field::FieldKind> kind_at_zero;
  std::optional<AttributeSource> attributes;  // source of the vertex attributes; set if the job asks for attributes
  std::optional<NeighborCounts> neighbors;    // set if SourceUse::counts_neighbors is set and there are particles
  // Meshes of a mesh file in output coordinates, in the order of `isos`. The conversion takes one after the other.
  // `field` then has no samples. Its voxels are cubes of the file's typical edge length, for stages that need a length.
  std::vector<mesh::Mesh> meshes;
  bool of_meshes = false;
  std::optional<ResolvedPlacement> from_world;  // of a mesh file: from the world of its original input to the output
  std::vector<NamedKind> mesh_kinds;            // of a mesh file: the kinds of its attributes

  // Records in why_no_particles and region_is_empty that no particle lies in `region`; with `or_near`, none near it
  // either. Uses only `count.of`, the number of all particles.
  void set_empty_region(const ParticleCount& count, const field::Box& region, bool or_near = false);

  // Returns the reason why the input is empty, for messages.
  [[nodiscard]] std::string why_empty() const {
    if (!why_no_particles.empty()) return why_no_particles;
    if (of_meshes) return "the file has no triangles";
    return of_particles ? "there are no particles" : "the grid is empty: it has no voxels";
  }

  // Makes the side of this iso value that is away from 0 the inside, in `field` and `data`; for 0, restores the side as
  // read. Call before extracting a surface. Does nothing without SourceOptions::away_from_zero.
  void set_inside_side(double iso);

  // Returns the kinds of the attributes that the mesh keeps.
  [[nodiscard]] std::vector<NamedKind> written_kinds() const;

  // Returns "0.5 voxels, in the mesh's units 0.1", for a mesh file "0.1 of the mesh's units".
  [[nodiscard]] std::string length_text(const std::string& voxels, const std::string& units) const;

  // Returns the record of the placement that a mesh file of this format stores (write_placement_record()).
  [[nodiscard]] std::string placement_record(mesh_io::MeshFormat format) const;

  // Returns the options of `surface` together with the iso value, region and output transform.
  [[nodiscard]] extract::ExtractOptions extract_options(const SurfaceOptions& surface, double iso) const;
};

// Returns the figures of a box, or null.
[[nodiscard]] Value box_figures(const std::optional<points::SimulationBox>& box);

// Returns the step and the time of a frame as figures, or null if it has neither.
[[nodiscard]] Value frame_figures(const particle_io::FrameTime& frame);

// How a source will be used.
struct SourceUse {
  bool keep_data = false;  // keep Source::data, to measure the error of the surface against it
  // For particles: the one iso value that will be extracted, so that particles deep inside can be left out.
  std::optional<double> only_iso;
  bool outside_region = false;  // the job uses the field outside the region, too, so the source keeps all particles
  std::vector<IsoChoice> isos;  // the requested iso values
  std::int64_t background = 0;  // of a label map (SurfaceOptions::background)
  // An empty surface is no error. So open_source() does not fail if no suggested iso value separates the samples, or if
  // an attribute is missing. A missing attribute fails later, if the surface is not empty.
  bool empty_is_fine = false;
  bool counts_neighbors = false;  // keep Source::neighbors
  RegionEnds region_ends = RegionEnds::faces;
  // The format if the output is the field itself: resampling then keeps the narrow band of level sets.
  std::optional<volume_io::VolumeFileFormat> field_format;
  field::NanHandling nan = field::NanHandling::left_out;  // how resampling treats NaN
  bool is_in_meters = false;                              // the output's format is glTF, which prescribes meters
  // For mesh files: the format of the output; glb if the output is a picture.
  mesh_io::MeshFormat mesh_format = mesh_io::MeshFormat::glb;
  const MaskLayers* masks = nullptr;  // of SourceOptions::masks; read.volume is then the layer
  bool by_layers = false;             // takes samples as volume_io::ReadOptions::by_layers
  bool meshes_apart = true;  // true: each mesh of a mesh file is a surface; false: the whole file is one surface
};
[[nodiscard]] SourceUse use_of(const ConversionJob& job);

// Opens the input and returns a source that is ready for extraction. Fails as the functions it calls do: read_volume(),
// filter_field(), blur_field(), resample(), rebuild_level_set(), place_field(), resolve_isos() and
// read_volume_attributes(). For particles it fails as is_particles(), read_particles(), make_particle_field() and
// find_attributes() do, for mesh files as open_mesh_source() does. With SourceUse::counts_neighbors it fails with
// ErrorCode::usage for volumes and for particles without kernels.
[[nodiscard]] Result<Source> open_source(const SourceOptions& options, const SourceUse& use, const Context& context,
                                         Events& events);

}  // namespace isoextract::convert
