// The stage that opens the input: reads the field, resamples it if asked to, and places it in the output.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/attribute_source.hpp"
#include "convert/conversion_job.hpp"
#include "convert/events.hpp"
#include "convert/iso_values.hpp"
#include "convert/particle_source.hpp"
#include "mesh/half_space.hpp"

namespace isoextract::convert {

// Calls read_volume() and reports its notes.
[[nodiscard]] Result<field::ScalarField> read_field(const std::string& input, const volume_io::ReadOptions& options,
                                                    const Context& context, Events& events);

struct Source {
  field::ScalarField field;  // to extract from
  // The field as read, if `field` was made from it and SourceUse::keep_data is set.
  std::optional<field::ScalarField> data;
  ResolvedPlacement placement;
  field::Affine output_from_index;
  std::optional<field::IndexBox> region;
  std::vector<mesh::HalfSpace> clip;  // half-spaces that keep the surfaces, in output coordinates: clip_surface()
  std::vector<ResolvedIso> isos;      // one for each requested iso value
  std::string label;                  // name in messages
  bool empty = false;                 // the input has no voxels or no particles
  bool of_particles = false;
  std::optional<field::FieldKind> kind_at_zero;  // with SourceOptions::away_from_zero: the field's own kind
  std::optional<AttributeSource> attributes;     // of the vertices, if the job asks for some

  // Says why `empty` is set.
  [[nodiscard]] const char* why_empty() const {
    return of_particles ? "there are no particles" : "the grid is empty: it has no voxels";
  }

  // Call before extracting a surface: sets which side of this iso value is inside, in the field and in the data. Does
  // nothing without SourceOptions::away_from_zero.
  void set_inside_side(double iso);

  // Returns the kinds of the attributes that the mesh keeps.
  [[nodiscard]] std::vector<NamedKind> written_kinds() const;

  // Returns the options to extract a surface of this source.
  [[nodiscard]] extract::ExtractOptions extract_options(const SurfaceOptions& surface, double iso) const;
};

// How a source will be used.
struct SourceUse {
  bool keep_data = false;          // keep Source::data
  std::optional<double> only_iso;  // only the surface at this iso value will be extracted from samples of particles
  std::vector<IsoChoice> isos;     // the requested iso values
  bool empty_is_fine = false;      // see resolve_isos() and read_volume_attributes()
  RegionEnds region_ends = RegionEnds::faces;
  field::NanHandling nan = field::NanHandling::left_out;  // how resampling treats NaN
};
[[nodiscard]] SourceUse use_of(const ConversionJob& job);

// Opens the input and returns a source that is ready for extraction. Fails as the functions it calls do: read_volume(),
// filter_field(), blur_field(), resample(), place_field(), resolve_isos() and read_volume_attributes(). For particles
// it fails as is_particles(), read_particles(), make_particle_field() and find_attributes() do.
[[nodiscard]] Result<Source> open_source(const SourceOptions& options, const SourceUse& use, const Context& context,
                                         Events& events);

}  // namespace isoextract::convert
