// The traits in the method table hold for every method's surfaces, and benchmarks do not measure what a method does not
// claim.
#include "extract/method.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include <gtest/gtest.h>

#include "accuracy/analytic_error.hpp"
#include "accuracy/field_error.hpp"
#include "bench/benchmark.hpp"
#include "bench/convergence.hpp"
#include "bench/stability.hpp"
#include "changed_extractor.hpp"
#include "field/demo_field.hpp"
#include "support/fields.hpp"
#include "support/meshes.hpp"

namespace isoextract::bench {
namespace {

using Changed = test::ChangedExtractor;

// Moves every vertex to moved(index), both in index space.
Changed::Change with_vertices(const std::function<glm::dvec3(const glm::dvec3&)>& moved) {
  return [moved](const extract::ExtractOptions& options, mesh::Mesh& mesh) {
    const field::Affine& place = options.output_from_index;
    const glm::dmat3 back = glm::inverse(place.linear);
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
      const glm::dvec3 index = back * (mesh.position(v) - place.offset);
      mesh.positions[v] = glm::vec3(place.linear * moved(index) + place.offset - mesh.origin);
    }
  };
}

// The midpoint between samples, where a voxel surface has its vertices.
glm::dvec3 halfway(const glm::dvec3& index) {
  glm::dvec3 moved = index;
  for (int axis = 0; axis < 3; ++axis) {
    const double nearest = std::round(index[axis]);
    if (std::abs(index[axis] - nearest) > 1e-4) moved[axis] = std::floor(index[axis]) + 0.5;
  }
  return moved;
}

// Off the edge into the cell by less than the mesh's error, as vertices of a dual method.
glm::dvec3 off_the_edge(const glm::dvec3& index) { return index + 0.01 * glm::sin(index); }

extract::ExtractOptions placed(const field::ScalarField& field, extract::Method method) {
  extract::ExtractOptions options;
  options.method = method;
  options.output_from_index = field.index_to_world;
  return options;
}

// Finds a method's traits by measuring its surfaces.
extract::MethodTraits observed_traits(extract::Extractor& extractor, extract::Method method) {
  extract::MethodTraits seen;
  const field::ScalarField bumpy = test::dense_field<float>({14, 13, 12}, [](int i, int j, int k) {
    return 4.3 - glm::length(glm::dvec3(i, j, k) - glm::dvec3(6.4, 6.1, 5.7)) + 0.4 * std::sin(2.0 * i + j - 1.7 * k);
  });
  extract::MethodTraits any_edge = seen;
  any_edge.axis_edges_only = false;
  const extract::ExtractOptions options = placed(bumpy, method);
  const auto extraction = extractor.extract(bumpy, options, Context());
  const mesh::Mesh& mesh = extraction.value().mesh;
  EXPECT_GT(mesh.positions.size(), 100U);
  const auto edges = grid_edges(mesh, bumpy, options, any_edge);
  const auto along_axis = [](const std::optional<GridEdge>& edge) {
    return edge && edge->step.x + edge->step.y + edge->step.z == 1;
  };
  seen.vertices_on_edges = std::ranges::all_of(edges, [](const auto& edge) { return edge.has_value(); }) &&
                           check_stability(mesh, bumpy, options, any_edge).repeated == 0;
  seen.axis_edges_only = std::ranges::all_of(edges, along_axis);

  // Second order in the spacing: positions inside triangles, and normals.
  const auto error_at = [&](int size, bool normals) -> std::optional<accuracy::AnalyticError> {
    const field::ScalarField torus =
        field::make_demo_field("demo:torus?size=" + std::to_string(size), Context()).value();
    extract::ExtractOptions of_torus = placed(torus, method);
    of_torus.smooth_normals = normals;
    const auto made = extractor.extract(torus, of_torus, Context());
    return made ? accuracy::measure_analytic_error(made->mesh, torus, of_torus, nullptr, {}, Context()).value()
                : std::nullopt;
  };
  const auto is_second_order = [](double coarse, double fine) { return std::log2(coarse / fine) > 1.7; };
  // Smooth surface nets seem to be of second order as long as the grid is coarse.
  const auto interior = [&](int size) { return error_at(size, false)->interior.rms.world; };
  seen.follows_interpolant = is_second_order(interior(24), interior(47)) && is_second_order(interior(47), interior(93));
  const auto coarse = error_at(24, true);
  const auto fine = error_at(47, true);
  seen.gradient_normals = coarse && fine && coarse->smooth_normals.points > 0 &&
                          is_second_order(coarse->smooth_normals.rms_degrees, fine->smooth_normals.rms_degrees);
  const field::ScalarField cut = field::make_demo_field("demo:gyroid?size=12", Context()).value();
  seen.always_closed =
      mesh::measure_topology(extractor.extract(cut, placed(cut, method), Context())->mesh).open_edges == 0;
  return seen;
}

TEST(MethodTraits, HoldForEveryMethod) {
  const auto cpu = extract::make_cpu_extractor();
  for (const extract::MethodInfo& method : extract::kMethods) {
    SCOPED_TRACE(std::string(method.title));
    const extract::MethodTraits seen = observed_traits(*cpu, method.method);
    EXPECT_EQ(seen.vertices_on_edges, method.traits.vertices_on_edges);
    EXPECT_EQ(seen.axis_edges_only, method.traits.axis_edges_only);
    EXPECT_EQ(seen.follows_interpolant, method.traits.follows_interpolant);
    EXPECT_EQ(seen.gradient_normals, method.traits.gradient_normals);
    EXPECT_EQ(seen.always_closed, method.traits.always_closed);
  }
}

TEST(MethodTraits, DetectFalseClaims) {
  using extract::Method;
  Changed halfway_on_edges(with_vertices(halfway));
  EXPECT_EQ(observed_traits(halfway_on_edges, Method::mc),
            (extract::MethodTraits{.follows_interpolant = false, .gradient_normals = false}));
  Changed dual(with_vertices(off_the_edge));
  const extract::MethodTraits of_dual = observed_traits(dual, Method::mc);
  EXPECT_FALSE(of_dual.vertices_on_edges);
  EXPECT_FALSE(of_dual.axis_edges_only);
  Changed flat([](const extract::ExtractOptions&, mesh::Mesh& mesh) {
    for (glm::vec3& normal : mesh.normals) normal = glm::vec3(0, 0, 1);
  });
  EXPECT_EQ(observed_traits(flat, Method::mc), (extract::MethodTraits{.gradient_normals = false}));
  // Stability finds it, too: it measures crossings if the method claims them.
  const auto shell = std::ranges::find(stability_cases(), "thin-shell", &StabilityCase::name);
  ASSERT_NE(shell, stability_cases().end());
  EXPECT_FALSE(run_stability_case(*shell, extract::method_info(Method::mc), dual, Context()).failures.empty());
}

TEST(MethodTraits, NamesAreUnique) {
  for (const extract::MethodInfo& method : extract::kMethods) {
    EXPECT_EQ(word_of(method.method), method.id);
    EXPECT_EQ(value_of<extract::Method>(method.id), method.method);
    EXPECT_EQ(std::ranges::count(extract::kMethods, method.id, &extract::MethodInfo::id), 1);
    EXPECT_EQ(std::ranges::count(extract::kMethods, method.title, &extract::MethodInfo::title), 1);
  }
}

// Methods that do not exist yet; their surfaces are changed surfaces of marching cubes.
extract::MethodInfo made_up(const extract::MethodTraits& traits) {
  extract::MethodInfo info = extract::method_info(extract::Method::mc);
  info.id = "nets";
  info.title = "made-up nets";
  info.traits = traits;
  return info;
}
extract::MethodInfo dual_method() { return made_up({.vertices_on_edges = false, .axis_edges_only = false}); }
extract::MethodInfo voxel_method() {
  return made_up({.vertices_on_edges = false, .follows_interpolant = false, .gradient_normals = false});
}

TEST(NotApplicable, StabilityChecksOnlyClaimedTraits) {
  Changed dual(with_vertices(off_the_edge));
  for (const StabilityCase& test : stability_cases()) {
    const StabilityScene scene = test.make();
    if (scene.outcome == StabilityOutcome::refusal) continue;
    const StabilityRow row = run_stability_case(test, dual_method(), dual, Context());
    EXPECT_FALSE(row.findings.edges_checked);
    EXPECT_FALSE(row.findings.crossings_checked);
    EXPECT_EQ(row.findings.off_edge, 0U);
    EXPECT_EQ(row.findings.voxels, 0);
    EXPECT_EQ(row.not_applicable,
              std::vector<std::string>{"made-up nets: the vertices do not lie on edges of the grid"});
  }
  const StabilityCase& shell = *std::ranges::find(stability_cases(), "thin-shell", &StabilityCase::name);
  EXPECT_TRUE(run_stability_case(shell, dual_method(), dual, Context()).failures.empty());
  EXPECT_FALSE(run_stability_case(shell, extract::method_info(extract::Method::mc), dual, Context()).failures.empty());
  // The other checks still apply.
  Changed repeating([](const extract::ExtractOptions&, mesh::Mesh& mesh) { mesh.triangles[0] = mesh.triangles[1]; });
  const StabilityRow row = run_stability_case(shell, dual_method(), repeating, Context());
  EXPECT_GT(row.findings.repeated, 0U);
  EXPECT_FALSE(row.failures.empty());
}

TEST(NotApplicable, MidpointsSkipCrossingChecks) {
  Changed halfway_on_edges(with_vertices(halfway));
  const StabilityCase& shell = *std::ranges::find(stability_cases(), "thin-shell", &StabilityCase::name);
  const StabilityRow row =
      run_stability_case(shell, made_up({.follows_interpolant = false}), halfway_on_edges, Context());
  EXPECT_TRUE(row.findings.edges_checked);
  EXPECT_FALSE(row.findings.crossings_checked);
  EXPECT_TRUE(row.failures.empty()) << row.failures.front();
}

// Such a surface is closed even without a cap, and NaN samples leave no hole.
TEST(NotApplicable, StabilityAcceptsAlwaysClosedMethods) {
  const auto cpu = extract::make_cpu_extractor();
  for (const extract::Method method : {extract::Method::voxels, extract::Method::surface_nets}) {
    for (const StabilityCase& test : stability_cases()) {
      const StabilityScene scene = test.make();
      const StabilityRow row = run_stability_case(test, extract::method_info(method), *cpu, Context());
      EXPECT_TRUE(row.failures.empty()) << test.name << ": " << row.failures.front();
      EXPECT_EQ(row.findings.open_edges, 0U) << test.name;
      const bool holes = scene.options.nan == extract::NanPolicy::hole;
      EXPECT_EQ(row.not_applicable.size(), holes ? 4U : 3U) << test.name;
    }
  }
}

BenchOptions bench_of(const std::vector<extract::MethodInfo>& methods, BenchBackend backend) {
  BenchOptions options;
  options.methods = methods;
  options.backends = {std::move(backend)};
  options.threads = {1};
  options.repeats = 1;
  return options;
}

TEST(NotApplicable, BenchNotesMissingNormals) {
  // A second identity, so that both fit in one table.
  extract::MethodInfo voxels = voxel_method();
  voxels.method = extract::Method::mt;
  const BenchOptions options =
      bench_of({voxels, extract::method_info(extract::Method::mc)}, {"cpu", extract::make_cpu_extractor(), {}});
  const field::ScalarField torus = field::make_demo_field("demo:torus?size=32", Context()).value();
  for (const BenchResult& result : {bench_demo("torus", {16, 32}, options, Context()).value(),
                                    bench_field(torus, {2, 1}, options, Context()).value()}) {
    ASSERT_EQ(result.rows.size(), 4U);
    for (const BenchRow& row : result.rows) {
      EXPECT_GT(row.median_seconds, 0);
      EXPECT_GT(row.triangles, 0U);
      EXPECT_TRUE(row.position.has_value());
      if (row.method != extract::Method::mc) {
        EXPECT_FALSE(row.smooth_normals);
      }
    }
    EXPECT_EQ(std::ranges::count(result.rows, true, &BenchRow::on_front) > 0, true);
    ASSERT_EQ(result.orders.size(), 2U);
    EXPECT_FALSE(result.orders[0].smooth_normals);
    const std::string_view why = "not applicable: made-up nets: the method has no normals from the field's gradient";
    EXPECT_EQ(std::ranges::count_if(result.notes, [&](const std::string& note) { return note.starts_with(why); }), 1);
  }
}

TEST(NotApplicable, BenchSkipsMissingNormals) {
  const BenchOptions options =
      bench_of({made_up({.gradient_normals = false})}, {"cpu", extract::make_cpu_extractor(), {}});
  const BenchResult result = bench_demo("torus", {16, 32}, options, Context()).value();
  for (const BenchRow& row : result.rows) {
    EXPECT_TRUE(row.position && row.flat_normals && row.area_error);
    EXPECT_FALSE(row.smooth_normals);
  }
  EXPECT_FALSE(result.orders[0].smooth_normals);
}

// A backend without a method.
class Without final : public extract::Extractor {
 public:
  [[nodiscard]] std::string_view name() const override { return "half"; }
  [[nodiscard]] std::string device() const override { return "none"; }
  [[nodiscard]] bool has(extract::Method method) const override { return method == extract::Method::mc; }

 private:
  [[nodiscard]] Result<extract::Extraction> run(const field::ScalarField& field, const extract::ExtractOptions& options,
                                                const Context& context) override {
    EXPECT_EQ(options.method, extract::Method::mc);
    return extract::make_cpu_extractor()->extract(field, options, context);
  }
};

TEST(NotApplicable, BenchSkipsBackendsWithoutMethod) {
  const std::vector<extract::MethodInfo> methods(extract::kMethods.begin(), extract::kMethods.end());
  const BenchResult result =
      bench_demo("torus", {16}, bench_of(methods, {"half", std::make_shared<Without>(), {}}), Context()).value();
  ASSERT_EQ(result.rows.size(), 1U);
  EXPECT_EQ(result.rows[0].method, extract::Method::mc);
  EXPECT_EQ(
      std::ranges::count(result.notes, "the backend half does not have marching tetrahedra, so the table omits it"), 1);

  const field::ScalarField torus = field::make_demo_field("demo:torus?size=16", Context()).value();
  const auto refused = Without().extract(torus, placed(torus, extract::Method::mt), Context());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::unavailable);
  EXPECT_EQ(refused.error().hint, Hint(Remedy::use, Setting::cpu_backend));
}

TEST(NotApplicable, RejectsOptionsTheMethodLacks) {
  extract::ExtractOptions options;
  EXPECT_TRUE(extract::check_method(voxel_method(), options));
  options.edge_keys = true;
  EXPECT_EQ(extract::check_method(voxel_method(), options).error().code, ErrorCode::usage);
  options.edge_keys = false;
  options.smooth_normals = true;
  EXPECT_EQ(extract::check_method(voxel_method(), options).error().code, ErrorCode::usage);
  EXPECT_TRUE(extract::check_method(dual_method(), options));
}

TEST(NotApplicable, SkipsStorageErrorOffEdges) {
  const field::ScalarField torus = field::make_demo_field("demo:torus?size=16", Context()).value();
  const extract::ExtractOptions options = placed(torus, extract::Method::mc);
  const mesh::Mesh mesh = test::extract(torus, options).mesh;
  accuracy::FieldErrorOptions asked;
  EXPECT_GT(accuracy::measure_field_error(mesh, torus, options, asked, Context()).value().storage.points, 0U);
  asked.vertices_on_edges = false;
  const accuracy::FieldError error = accuracy::measure_field_error(mesh, torus, options, asked, Context()).value();
  EXPECT_EQ(error.storage.points, 0U);
  EXPECT_GT(error.vertices.points, 0U);
}

}  // namespace
}  // namespace isoextract::bench
