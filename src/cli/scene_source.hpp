// What `isoextract render` draws: read, extracted, and put together as a scene.
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

// One volume with its surfaces; meshes of files stay from one to the next, and so do the range of the transfer function
// and the unit of its opacities, which the first volume says where options do not.
class SceneSource {
 public:
  // Reads the meshes and the transfer function. `plan` outlives this.
  [[nodiscard]] static Result<SceneSource> open(const RenderPlan& plan, const Context& context,
                                                convert::Events& events);

  // In place of the volume before. `output` is what is to be drawn, for messages.
  [[nodiscard]] Result<void> read_volume(const std::string& input, const std::string& output, const Context& context,
                                         convert::Events& events);

  // In place of the volume before: none.
  void leave_volume_out();

  // What there is now; it is lent until the next call of read_volume().
  [[nodiscard]] render::Scene scene() const;
  // As asked for, or as the meshes of files say.
  [[nodiscard]] render::UpAxis up() const { return plan_->up.value_or(up_of_meshes_); }
  // Fails where a part of the volume's file got lost meanwhile.
  [[nodiscard]] Result<void> check_not_lost() const;

 private:
  explicit SceneSource(const RenderPlan& plan) : plan_(&plan) {}

  // Of the source; the first one says what a unit of length is.
  [[nodiscard]] Result<void> place_volume(const Context& context, convert::Events& events);
  [[nodiscard]] Result<void> choose_transfer(const field::ScalarField& field, const field::FieldStatistics& statistics);
  void add_surface(render::Scene& scene, const mesh::Mesh& mesh) const;

  const RenderPlan* plan_;
  std::vector<mesh::Mesh> meshes_;  // of files
  render::UpAxis up_of_meshes_ = render::UpAxis::z;
  std::optional<convert::Source> source_;
  std::optional<render::Volume> volume_;
  std::vector<mesh::Mesh> surfaces_;
  std::optional<render::TransferFunction> transfer_;
  std::optional<double> unit_length_;
  bool told_up_axis_ = false;  // of a volume before
};

}  // namespace isoextract::cli
