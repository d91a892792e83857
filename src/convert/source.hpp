// The stage that reads: a field, on the grid that was asked for, and its place in the output.
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

// read_volume(), with its notes told.
[[nodiscard]] Result<field::ScalarField> read_field(const std::string& input, const volume_io::ReadOptions& options,
                                                    const Context& context, Events& events);

struct Source {
  field::ScalarField field;                // to extract from
  std::optional<field::ScalarField> data;  // what was read, where `field` was made of it and the data were asked for
  ResolvedPlacement placement;
  field::Affine output_from_index;
  std::optional<field::IndexBox> region;
  std::vector<mesh::HalfSpace> clip;  // what of the surfaces is kept, in their coordinates: clip_mesh()
  std::vector<ResolvedIso> isos;      // one for each that was asked for
  std::string label;                  // what messages call it
  bool empty = false;                 // what was read has no voxels, or no particles
  bool of_particles = false;
  std::optional<field::FieldKind> kind_at_zero;  // SourceOptions::away_from_zero: what the field itself has
  std::optional<AttributeSource> attributes;     // of the vertices, where some were asked for

  // Where `empty`.
  [[nodiscard]] const char* why_empty() const {
    return of_particles ? "there are no particles" : "the grid is empty: it has no voxels";
  }

  // Before a surface is extracted: the field, and the data, get the side that is inside of this iso value. Nothing
  // changes unless SourceOptions::away_from_zero asked for it.
  void face_outward(double iso);

  // Of the attributes that the mesh keeps.
  [[nodiscard]] std::vector<NamedKind> written_kinds() const;

  // How a surface of it is extracted.
  [[nodiscard]] extract::ExtractOptions extract_options(const SurfaceOptions& surface, double iso) const;
};

// What will be done with a source.
struct SourceUse {
  bool keep_data = false;          // Source::data is asked for
  std::optional<double> only_iso;  // nothing is asked of the samples of particles but the surface at this iso value
  std::vector<IsoChoice> isos;     // whose values are asked for
  bool empty_is_fine = false;      // as in resolve_isos()
  RegionEnds region_ends = RegionEnds::faces;
  field::NanSamples nan = field::NanSamples::left_out;  // where the resolution changes
};
[[nodiscard]] SourceUse use_of(const ConversionJob& job);

// Fails as read_volume(), filter_field(), blur_field(), resample() and place_field() do, and for particles as
// is_particles(), read_particles(), make_particle_field() and find_attributes() do, as resolve_isos(), and with
// attributes of volumes as read_volume_attributes() does.
[[nodiscard]] Result<Source> open_source(const SourceOptions& options, const SourceUse& use, const Context& context,
                                         Events& events);

}  // namespace isoextract::convert
