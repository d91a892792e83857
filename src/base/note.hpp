// Notes: facts about a result that the user may not expect. They are not errors.
// Any room (library, a folder of src) may create notes; only `cli` prints them, as "isoextract: note[ID]: TEXT".
// `cli/note_guide.hpp` tells the cause and the remedy of each id.
#pragma once

#include <array>
#include <compare>
#include <string>
#include <vector>

#include "base/enum_words.hpp"

namespace isoextract {

// The cause of a note. People silence notes by the words of their ids; a word stays the same in later versions.
enum class NoteId {
  // Input
  assumed_columns,
  axes_dropped,
  box_ignored,
  data_left_out,
  decimal_commas,
  element_radii,
  extra_bytes,
  format_not_by_name,
  frame_order,
  grid_chosen,
  incomplete_frame,
  missing_frames,
  newer_version,
  other_files,
  placement_assumed,
  placement_replaced,
  placement_unknown,
  placement_differs,
  plugin_output,
  staggered_grid,
  unclear_positions,
  value_scale,
  // Samples and particles
  attribute_kind,
  attribute_left_out,
  attribute_missing,
  attribute_of_nearest,
  attribute_outside,
  attribute_placement,
  attribute_renamed,
  cell_size,
  color_range,
  label_table,
  labels_assumed,
  labels_empty,
  labels_lost,
  labels_small,
  labels_unmatched,
  level_set_interpolated,
  masks_overlap,
  means_not_possible,  // the volume is too large to resample by averages, so the program interpolates
  nan_attribute,
  nan_samples,
  no_data,  // how many samples have the no-data value and become NaN
  particle_radius,
  particles_left_out,
  periodic_box,
  region_at_samples,   // the surface ends at samples near the faces of the region
  samples_in_file,     // a temporary file holds the samples, as memory is short
  samples_in_windows,  // the program maps a few layers at a time, as the address space is limited
  sparse_made_dense,
  voxel_size,
  voxels_in_files,  // temporary files hold the voxels of labels and the points of surface nets, as memory is short
  // Surfaces
  backend,
  cap_overlaps,
  clipped,
  corners_joined,  // merged corners of triangles had different attributes
  error_not_measured,
  faces_not_merged,
  iso_chosen,
  iso_of_labels,
  labels_part,  // an edit changes each label's mesh separately, so neighbors no longer share their faces
  many_components,
  moved_apart,
  no_surface,
  open_components_kept,
  open_mesh,
  repeated_iso,
  simplified_in_windows,
  simplified_shells,
  volume_changed,
  zero_area,
  // Output
  animation_kept,
  animation_times,
  empty_picture,
  flat_normals,
  frames_kept,
  frames_move,
  length_unit,
  memory_unknown,
  no_effect,
  no_plot,
  not_coarsened,
  not_verified,
  old_pieces,
  one_camera,
  placement_not_stored,
  renamed_meshes,
  rounded_positions,
  several_files,
  shard,
  simulation_limits,
  up_axis,
};
constexpr auto words_of(NoteId /*type*/) {
  return std::array{
      Word{NoteId::assumed_columns, "assumed-columns"},
      Word{NoteId::axes_dropped, "axes-dropped"},
      Word{NoteId::box_ignored, "box-ignored"},
      Word{NoteId::data_left_out, "data-left-out"},
      Word{NoteId::decimal_commas, "decimal-commas"},
      Word{NoteId::element_radii, "element-radii"},
      Word{NoteId::extra_bytes, "extra-bytes"},
      Word{NoteId::format_not_by_name, "format-not-by-name"},
      Word{NoteId::frame_order, "frame-order"},
      Word{NoteId::grid_chosen, "grid-chosen"},
      Word{NoteId::incomplete_frame, "incomplete-frame"},
      Word{NoteId::missing_frames, "missing-frames"},
      Word{NoteId::newer_version, "newer-version"},
      Word{NoteId::other_files, "other-files"},
      Word{NoteId::placement_assumed, "placement-assumed"},
      Word{NoteId::placement_replaced, "placement-replaced"},
      Word{NoteId::placement_unknown, "placement-unknown"},
      Word{NoteId::placement_differs, "placement-differs"},
      Word{NoteId::plugin_output, "plugin-output"},
      Word{NoteId::staggered_grid, "staggered-grid"},
      Word{NoteId::unclear_positions, "unclear-positions"},
      Word{NoteId::value_scale, "value-scale"},
      Word{NoteId::attribute_kind, "attribute-kind"},
      Word{NoteId::attribute_left_out, "attribute-left-out"},
      Word{NoteId::attribute_missing, "attribute-missing"},
      Word{NoteId::attribute_of_nearest, "attribute-of-nearest"},
      Word{NoteId::attribute_outside, "attribute-outside"},
      Word{NoteId::attribute_placement, "attribute-placement"},
      Word{NoteId::attribute_renamed, "attribute-renamed"},
      Word{NoteId::cell_size, "cell-size"},
      Word{NoteId::color_range, "color-range"},
      Word{NoteId::label_table, "label-table"},
      Word{NoteId::labels_assumed, "labels-assumed"},
      Word{NoteId::labels_empty, "labels-empty"},
      Word{NoteId::labels_lost, "labels-lost"},
      Word{NoteId::labels_small, "labels-small"},
      Word{NoteId::labels_unmatched, "labels-unmatched"},
      Word{NoteId::level_set_interpolated, "level-set-interpolated"},
      Word{NoteId::masks_overlap, "masks-overlap"},
      Word{NoteId::means_not_possible, "means-not-possible"},
      Word{NoteId::nan_attribute, "nan-attribute"},
      Word{NoteId::nan_samples, "nan-samples"},
      Word{NoteId::no_data, "no-data"},
      Word{NoteId::particle_radius, "particle-radius"},
      Word{NoteId::particles_left_out, "particles-left-out"},
      Word{NoteId::periodic_box, "periodic-box"},
      Word{NoteId::region_at_samples, "region-at-samples"},
      Word{NoteId::samples_in_file, "samples-in-file"},
      Word{NoteId::samples_in_windows, "samples-in-windows"},
      Word{NoteId::sparse_made_dense, "sparse-made-dense"},
      Word{NoteId::voxel_size, "voxel-size"},
      Word{NoteId::voxels_in_files, "voxels-in-files"},
      Word{NoteId::backend, "backend"},
      Word{NoteId::cap_overlaps, "cap-overlaps"},
      Word{NoteId::clipped, "clipped"},
      Word{NoteId::corners_joined, "corners-joined"},
      Word{NoteId::error_not_measured, "error-not-measured"},
      Word{NoteId::faces_not_merged, "faces-not-merged"},
      Word{NoteId::iso_chosen, "iso-chosen"},
      Word{NoteId::iso_of_labels, "iso-of-labels"},
      Word{NoteId::labels_part, "labels-part"},
      Word{NoteId::many_components, "many-components"},
      Word{NoteId::moved_apart, "moved-apart"},
      Word{NoteId::no_surface, "no-surface"},
      Word{NoteId::open_components_kept, "open-components-kept"},
      Word{NoteId::open_mesh, "open-mesh"},
      Word{NoteId::repeated_iso, "repeated-iso"},
      Word{NoteId::simplified_in_windows, "simplified-in-windows"},
      Word{NoteId::simplified_shells, "simplified-shells"},
      Word{NoteId::volume_changed, "volume-changed"},
      Word{NoteId::zero_area, "zero-area"},
      Word{NoteId::animation_kept, "animation-kept"},
      Word{NoteId::animation_times, "animation-times"},
      Word{NoteId::empty_picture, "empty-picture"},
      Word{NoteId::flat_normals, "flat-normals"},
      Word{NoteId::frames_kept, "frames-kept"},
      Word{NoteId::frames_move, "frames-move"},
      Word{NoteId::length_unit, "length-unit"},
      Word{NoteId::memory_unknown, "memory-unknown"},
      Word{NoteId::no_effect, "no-effect"},
      Word{NoteId::no_plot, "no-plot"},
      Word{NoteId::not_coarsened, "not-coarsened"},
      Word{NoteId::not_verified, "not-verified"},
      Word{NoteId::old_pieces, "old-pieces"},
      Word{NoteId::one_camera, "one-camera"},
      Word{NoteId::placement_not_stored, "placement-not-stored"},
      Word{NoteId::renamed_meshes, "renamed-meshes"},
      Word{NoteId::rounded_positions, "rounded-positions"},
      Word{NoteId::several_files, "several-files"},
      Word{NoteId::shard, "shard"},
      Word{NoteId::simulation_limits, "simulation-limits"},
      Word{NoteId::up_axis, "up-axis"},
  };
}

// One note. The text is one sentence without its full stop.
// Text that comes from files is made printable. A note may mention options only if `cli` creates it.
struct Note {
  NoteId id = NoteId::no_effect;
  std::string text;

  // NOLINTNEXTLINE(modernize-use-nullptr): there is no pointer here to replace
  friend auto operator<=>(const Note&, const Note&) = default;
};
using Notes = std::vector<Note>;

// Returns the note with `start` before its text.
[[nodiscard]] inline Note prefixed(const std::string& start, const Note& note) { return {note.id, start + note.text}; }

}  // namespace isoextract
