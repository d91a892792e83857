#include "edit/partwise_bodies.hpp"

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <span>
#include <utility>

#include "base/parallel.hpp"
#include "base/stopwatch.hpp"
#include "edit/detail/body_choice.hpp"
#include "edit/detail/kept_vertices.hpp"
#include "mesh/adjacency.hpp"
#include "mesh/partwise_components.hpp"
#include "mesh/partwise_measures.hpp"
#include "mesh/shells.hpp"

namespace isoextract::edit {
namespace {

constexpr mesh::PartPass kWhole{.in_order = true, .normals = false};
constexpr std::size_t kTrianglesTogether = 1 << 14;

// The triangles of a part that stay, in the whole mesh and in the remaining one.
struct KeptTriangles {
  std::uint64_t first = 0;       // the part's first triangle
  std::uint64_t kept_first = 0;  // its number in the remaining mesh
  std::uint64_t kept = 0;
};

}  // namespace

class PartwiseBodies::State {
 public:
  State(const std::string& name, const BodySelection& options, const Context& context)
      : name_(name),
        what_(name + ": the components of its surface"),
        options_(options),
        context_(context),
        shells_(name, context),
        measuring_(name, context, options.to_metric, [this](const mesh::LocalPart& part) {
          shells_.look_at(part);
          return Result<void>();
        }) {}

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const std::vector<mesh::PartPass>& passes() const { return passes_; }
  [[nodiscard]] const BodyFigures& figures() const { return choice_.figures; }
  [[nodiscard]] const mesh::MeshShape& kept_shape() const { return kept_shape_; }

  Result<void> begin(const mesh::MeshShape& shape) {
    watch_.restart();
    shape_ = shape;
    passes_ = measuring_.passes();
    TRY(measuring_.begin(shape));
    return {};
  }

  Result<void> begin_pass(std::size_t pass) {
    if (visit_) return {};
    TRY(measuring_.begin_pass(pass));
    return pass == 0 ? Result<void>() : shells_.begin(measuring_.components().count());
  }

  Result<void> take(const mesh::MeshPart& part) {
    if (visit_) return measuring_.components().take(part, visit_);
    return measuring_.take(part);
  }

  Result<void> end_pass() {
    if (visit_) TRY(measuring_.components().finish(visit_));
    switch (stage_) {
      case Stage::linking: stage_ = Stage::measuring; return {};
      case Stage::measuring: return end_measuring();
      case Stage::nesting: return go_on(shells_.end_step());
      case Stage::marking: return end_marking();
    }
    return {};
  }

  Result<void> keep(const mesh::MeshPart& part, const TakePart& take) const {
    if (!is_filtered()) return take(part);
    const auto memory = TRY(context_.reserve(
        (part.positions.size() + part.normals.size()) * sizeof(glm::vec3) + part.triangles.size() * sizeof(glm::uvec3),
        what_));
    const auto positions = kept_of(part.positions, part.first_vertex);
    const auto normals = kept_of(part.normals, part.first_vertex);
    std::vector<glm::uvec3> triangles;
    std::uint64_t first_triangle = 0;
    if (!part.triangles.empty()) {
      const auto known = std::ranges::lower_bound(triangles_, part.first_triangle, {}, &KeptTriangles::first);
      if (known == triangles_.end() || known->first != part.first_triangle) return mesh::changed_between_passes(name_);
      first_triangle = known->kept_first;
      triangles.reserve(known->kept);
      for (const glm::uvec3& t : part.triangles) {
        if (mesh::has_repeated_index(t) || !vertices_.is_kept(t.x)) continue;
        if (triangles.size() == known->kept) return mesh::changed_between_passes(name_);
        triangles.emplace_back(vertices_.number(t.x), vertices_.number(t.y), vertices_.number(t.z));
      }
      if (triangles.size() != known->kept) return mesh::changed_between_passes(name_);
    }
    if (positions.empty() && normals.empty() && triangles.empty()) return {};
    return take({vertices_.number(part.first_vertex), positions, normals, first_triangle, triangles});
  }

 private:
  enum class Stage { linking, measuring, nesting, marking };

  [[nodiscard]] bool is_filtered() const {
    return choice_.figures.after.components < choice_.figures.before.components;
  }

  Result<void> end_measuring() {
    measures_ = TRY(measuring_.finish());
    memory_ = TRY(context_.reserve(measures_.components.size() * kComponentBytes, what_));
    if (!has_cavities(measures_.components)) {
      return choose(Nesting::without_cavities(measures_.components.size()));
    }
    stage_ = Stage::nesting;
    visit_ = [this](const mesh::LocalPart& part) {
      shells_.take(part);
      return context_.check();
    };
    return go_on(TRY(shells_.begin_steps(shell_query(measures_.components))));
  }

  Result<void> go_on(mesh::PartwiseShells::Step step) {
    if (step == mesh::PartwiseShells::Step::done) {
      return choose(nesting_of(measures_.components, TRY(shells_.finish())));
    }
    passes_.push_back(kWhole);
    return {};
  }

  Result<void> choose(const Nesting& nesting) {
    choice_ = choose_bodies(measures_.components, nesting, options_, options_.least ? shells_.resolution() : 0);
    kept_shape_ = shape_;
    visit_ = nullptr;
    if (!is_filtered()) return end_choosing();
    memory_.take(TRY(context_.reserve(KeptVertices::bytes(shape_.vertices), what_)));
    vertices_ = KeptVertices(shape_.vertices);
    kept_shape_.triangles = 0;
    stage_ = Stage::marking;
    visit_ = [this](const mesh::LocalPart& part) { return mark(part); };
    passes_.push_back(kWhole);
    return {};
  }

  [[nodiscard]] bool stays(std::uint32_t component) const {
    return component != mesh::Components::kNone && choice_.stays[component];
  }

  Result<void> mark(const mesh::LocalPart& part) {
    for (std::size_t v = 0; v < part.own_components.size(); ++v) {
      if (stays(part.own_components[v])) vertices_.keep(part.first_vertex + v);
    }
    if (part.triangles.empty()) return {};
    std::atomic<std::uint64_t> kept{0};
    for_each_range(part.triangles.size(), kTrianglesTogether, [&](std::size_t begin, std::size_t end) {
      const auto remains = [&](const glm::uvec3& t) {
        return !mesh::has_repeated_index(t) && stays(part.components[t.x]);
      };
      kept += static_cast<std::uint64_t>(std::ranges::count_if(part.triangles.subspan(begin, end - begin), remains));
    });
    memory_.take(TRY(context_.reserve(sizeof(KeptTriangles), what_)));
    triangles_.push_back({part.first_triangle, kept_shape_.triangles, kept});
    kept_shape_.triangles += kept;
    return {};
  }

  Result<void> end_marking() {
    kept_shape_.vertices = vertices_.count();
    std::vector<std::uint32_t>& far = kept_shape_.far_vertices;
    std::erase_if(far, [&](std::uint32_t v) { return !vertices_.is_kept(v); });
    for (std::uint32_t& v : far) v = vertices_.number(v);
    visit_ = nullptr;
    if (kept_shape_.triangles != choice_.figures.after.triangles) return mesh::changed_between_passes(name_);
    return end_choosing();
  }

  Result<void> end_choosing() {
    choice_.figures.time = watch_.elapsed();
    measures_ = {};
    return {};
  }

  [[nodiscard]] std::vector<glm::vec3> kept_of(std::span<const glm::vec3> values, std::uint64_t first) const {
    std::vector<glm::vec3> kept;
    kept.reserve(values.empty() ? 0 : vertices_.number(first + values.size()) - vertices_.number(first));
    for (std::size_t v = 0; v < values.size(); ++v) {
      if (vertices_.is_kept(first + v)) kept.push_back(values[v]);
    }
    return kept;
  }

  std::string name_;
  std::string what_;  // starts messages about memory
  BodySelection options_;
  Context context_;
  Stopwatch watch_;
  mesh::MeshShape shape_;
  std::vector<mesh::PartPass> passes_;
  Stage stage_ = Stage::linking;
  mesh::PartwiseShells shells_;
  mesh::PartwiseMeasures measuring_;
  mesh::PartwiseComponents::Visit visit_;  // of passes after the measuring
  mesh::MeshMeasures measures_;

  Reservation memory_;  // for these:
  BodyChoice choice_;
  KeptVertices vertices_;
  std::vector<KeptTriangles> triangles_;  // of each part with triangles
  mesh::MeshShape kept_shape_;
};

PartwiseBodies::PartwiseBodies(const std::string& name, const BodySelection& options, const Context& context)
    : state_(std::make_unique<State>(name, options, context)) {}
PartwiseBodies::~PartwiseBodies() = default;

const std::vector<mesh::PartPass>& PartwiseBodies::passes() const { return state_->passes(); }
const BodyFigures& PartwiseBodies::figures() const { return state_->figures(); }
const mesh::MeshShape& PartwiseBodies::kept_shape() const { return state_->kept_shape(); }

Result<void> PartwiseBodies::begin(const mesh::MeshShape& shape) {
  return with_body_memory(state_->name(), [&] { return state_->begin(shape); });
}
Result<void> PartwiseBodies::begin_pass(std::size_t pass) {
  return with_body_memory(state_->name(), [&] { return state_->begin_pass(pass); });
}
Result<void> PartwiseBodies::take(const mesh::MeshPart& part) {
  return with_body_memory(state_->name(), [&] { return state_->take(part); });
}
Result<void> PartwiseBodies::end_pass() {
  return with_body_memory(state_->name(), [&] { return state_->end_pass(); });
}
Result<void> PartwiseBodies::keep(const mesh::MeshPart& part, const TakePart& take) const {
  return with_body_memory(state_->name(), [&] { return state_->keep(part, take); });
}

}  // namespace isoextract::edit
