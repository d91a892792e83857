// Reads volumes and meshes, extracts surfaces, and builds the scene for `isoextract render`.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "cli/render_plan.hpp"
#include "convert/events.hpp"
#include "convert/source.hpp"
#include "field/statistics.hpp"
#include "mesh/mesh.hpp"
#include "render/scene.hpp"

namespace isoextract::cli {

// Holds one volume with its surfaces at a time. Mesh files are kept for all volumes. So are the range of the transfer
// function and its unit length, which options or the first volume determine.
class SceneSource {
 public:
  // Reads the meshes and the transfer function. `plan` must outlive the result.
  [[nodiscard]] static Result<SceneSource> open(const RenderPlan& plan, const Context& context,
                                                convert::Events& events);

  // Replaces the volume. `output` is the picture's path, for messages.
  [[nodiscard]] Result<void> read_volume(const std::string& input, const std::string& output, const Context& context,
                                         convert::Events& events);

  // Removes the volume.
  void remove_volume();

  // Returns the current scene, which is valid until the next call of read_volume().
  [[nodiscard]] render::Scene scene() const;
  // Returns the up axis of the options, or else of the mesh files.
  [[nodiscard]] render::UpAxis up() const { return plan_->up.value_or(up_of_meshes_); }
  // Fails if a later read of the volume's file has failed.
  [[nodiscard]] Result<void> check_mapping_intact() const;

 private:
  explicit SceneSource(const RenderPlan& plan) : plan_(&plan) {}

  // Sets the volume of the source. The first volume determines the unit length.
  [[nodiscard]] Result<void> place_volume(const Context& context, convert::Events& events);
  [[nodiscard]] Result<void> choose_transfer(const field::ScalarField& field, const field::FieldStatistics& statistics);
  void add_surface(render::Scene& scene, const mesh::Mesh& mesh) const;

  const RenderPlan* plan_;
  std::vector<mesh::Mesh> meshes_;  // from files
  render::UpAxis up_of_meshes_ = render::UpAxis::z;
  std::optional<convert::Source> source_;
  std::optional<render::Volume> volume_;
  std::vector<mesh::Mesh> surfaces_;
  std::optional<render::TransferFunction> transfer_;
  std::optional<double> unit_length_;
  bool printed_up_axis_note_ = false;  // the note about the up axis was printed for an earlier volume
};

}  // namespace isoextract::cli
