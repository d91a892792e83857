// Reads volumes and meshes, extracts surfaces, and builds the scene for `isoextract render`.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "cli/emission_source.hpp"
#include "cli/render_plan.hpp"
#include "convert/events.hpp"
#include "convert/source.hpp"
#include "field/statistics.hpp"
#include "mesh/mesh.hpp"
#include "render/scene.hpp"

namespace isoextract::cli {

// Holds one volume with its emission and surfaces at a time. Keeps the mesh files for all volumes. Also keeps the
// transfer function and its unit length, which options or the first volume determine.
class SceneSource {
 public:
  // Reads the meshes, and the transfer function if it is a file. `plan` must outlive the result.
  [[nodiscard]] static Result<SceneSource> open(const RenderPlan& plan, const Context& context,
                                                convert::Events& events);

  // Replaces the volume and its surfaces; after a failure the source may hold no volume. `output` is the picture's
  // path: the extraction of surfaces names it in messages and checks that it is writable, but writes no file. In a
  // sequence that draws the volume, a frame without surface gives a note, not an error.
  [[nodiscard]] Result<void> read_volume(const std::string& input, const std::string& output, const Context& context,
                                         convert::Events& events);

  // Removes the volume and its surfaces.
  void remove_volume();

  // Returns the current scene. The scene refers to this object: it is valid until the next call of read_volume() or
  // remove_volume(), and until this object is moved.
  [[nodiscard]] render::Scene scene() const;
  // Returns the grid that emits light; null without one, or if it has no voxels.
  [[nodiscard]] const EmissionSource* emission() const { return emission_ ? &*emission_ : nullptr; }
  // Returns the up axis of the options. Default: y without a volume and if the placement records of all mesh files
  // state y up, otherwise z.
  [[nodiscard]] render::UpAxis up() const { return plan_->up.value_or(up_of_meshes_); }
  // Returns the azimuth of the volume's front (convert::front_azimuth()); 0 without a volume.
  [[nodiscard]] double front() const { return front_; }
  // Call after each drawing. Fails with ErrorCode::input if the volume's mapped file was truncated or unreadable
  // meanwhile (volume_io::check_mapping_intact); the picture must then be discarded.
  [[nodiscard]] Result<void> check_mapping_intact() const;

 private:
  explicit SceneSource(const RenderPlan& plan) : plan_(&plan) {}

  // Sets volume_ from source_. Without options, the first volume determines the transfer function and the unit length.
  [[nodiscard]] Result<void> place_volume(const Context& context, convert::Events& events);
  [[nodiscard]] Result<void> choose_transfer(const field::ScalarField& field, const field::FieldStatistics& statistics);
  void add_surface(render::Scene& scene, const mesh::Mesh& mesh) const;

  const RenderPlan* plan_;
  std::vector<mesh::Mesh> meshes_;  // from files
  render::UpAxis up_of_meshes_ = render::UpAxis::z;
  std::optional<convert::Source> source_;
  std::optional<render::Volume> volume_;
  std::optional<EmissionSource> emission_;
  render::Volume emission_volume_;  // refers to emission_
  std::vector<mesh::Mesh> surfaces_;
  double front_ = 0;
  std::optional<render::TransferFunction> transfer_;
  std::optional<double> unit_length_;
  bool printed_label_note_ = false;    // an earlier volume was checked for labels, with or without a note
  bool printed_up_axis_note_ = false;  // the note about the up axis was printed for an earlier volume
};

}  // namespace isoextract::cli
