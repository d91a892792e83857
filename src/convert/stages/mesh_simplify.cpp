#include "convert/stages/mesh_simplify.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "base/counted.hpp"
#include "convert/stages/surface_stages.hpp"
#include "edit/bounded_simplify.hpp"
#include "edit/label_net.hpp"
#include "mesh/adjacency.hpp"
#include "mesh/components.hpp"
#include "mesh/metrics.hpp"
#include "mesh/shells.hpp"

namespace isoextract::convert {
namespace {

constexpr double kPatchVoxels = 32;
constexpr double kPatchEdges = 40;  // typical edges of the mesh; those of marching cubes have 0.8 voxels

struct Stretch {
  double least = 1;
  double most = 1;
  // Returns whether the map scales all lengths alike up to rounding (a similarity).
  [[nodiscard]] bool is_even() const { return most - least <= 1e-9 * most; }
};

// Returns the least and greatest factor by which the map scales a length: its extreme singular values. The eigenvalues
// of the symmetric matrix map^T map follow from the trigonometric formula (O. K. Smith, Eigenvalues of a symmetric 3 x
// 3 matrix, Comm. ACM 4(4), 1961).
Stretch stretch_of(const glm::dmat3& map) {
  const glm::dmat3 a = glm::transpose(map) * map;
  const double mean = (a[0][0] + a[1][1] + a[2][2]) / 3;
  const glm::dmat3 rest = a - mean * glm::dmat3(1.0);
  double squares = 0;
  for (int column = 0; column < 3; ++column) squares += glm::dot(rest[column], rest[column]);
  const double spread = std::sqrt(squares / 6);
  if (!(spread > 0)) return {std::sqrt(mean), std::sqrt(mean)};
  const double half = std::clamp(glm::determinant(rest / spread) / 2, -1.0, 1.0);
  const double angle = std::acos(half) / 3;
  const double most = mean + 2 * spread * std::cos(angle);
  const double least = mean + 2 * spread * std::cos(angle + 2 * std::numbers::pi / 3);
  return {std::sqrt(std::max(least, 0.0)), std::sqrt(most)};
}

struct ComponentCount {
  std::uint64_t components = 0;
  std::uint64_t cavities = 0;  // closed components that face inward
  std::uint64_t outside = 0;   // cavities inside no body: an even number of closed components around them
};

// Counts components; runs before and after each simplification. measure_components() also examines edges and takes
// several times as long. A component is closed if the vector areas of its triangles sum to 0; its volume is
// then the same from any point.
Result<ComponentCount> count_components(const mesh::Mesh& mesh, const Context& context) {
  struct Sum {
    glm::dvec3 vector{0.0};
    double area = 0;
    double volume = 0;
  };
  const auto memory =
      TRY(context.reserve(mesh::Components::bytes(mesh.positions.size()), mesh.name + ": its components"));
  const mesh::Components components(mesh.triangles.span(), mesh.positions.size());
  const auto sums_memory = TRY(
      context.reserve(components.count() * (sizeof(Sum) + sizeof(mesh::Surroundings)), mesh.name + ": its components"));
  std::vector<Sum> sums(components.count());
  for (const glm::uvec3& t : mesh.triangles) {
    if (mesh::has_repeated_index(t)) continue;
    Sum& sum = sums[components.of_vertex(t.x)];
    const glm::dvec3 a(mesh.positions[t.x]);
    const glm::dvec3 vector =
        0.5 * glm::cross(glm::dvec3(mesh.positions[t.y]) - a, glm::dvec3(mesh.positions[t.z]) - a);
    sum.vector += vector;
    sum.area += glm::length(vector);
    sum.volume += glm::dot(a, vector) / 3;
  }
  ComponentCount count{sums.size(), 0, 0};
  mesh::ShellQuery question{.test_outward = false};
  for (const Sum& sum : sums) {
    const bool is_closed = glm::length(sum.vector) < 1e-6 * sum.area;
    const bool is_cavity = is_closed && sum.volume < -1e-9 * sum.area * std::sqrt(sum.area);
    question.facing.push_back(is_cavity   ? mesh::Facing::inward
                              : is_closed ? mesh::Facing::outward
                                          : mesh::Facing::open);
    count.cavities += is_cavity ? 1 : 0;
  }
  if (count.cavities == 0) return count;
  const auto surroundings = TRY(mesh::find_enclosing_shells(mesh, components, question, context));
  for (std::size_t c = 0; c < sums.size(); ++c) {
    count.outside += question.facing[c] == mesh::Facing::inward && !surroundings[c].in_material() ? 1 : 0;
  }
  return count;
}

std::string bound_text(const SimplifyBound& bound) {
  return fmt::format("{} {}", bound.distance, bound.in_world_units ? "of the mesh's units" : "voxels");
}

std::string asked_text(const SimplifyChoice& asked) {
  std::string text;
  if (asked.triangles) {
    text = triangle_count_text(*asked.triangles);
    if (!asked.triangles->in_percent) text += " triangles";
  }
  if (asked.triangles && asked.within) text += " and ";
  if (asked.within) text += "at most " + bound_text(*asked.within);
  return text;
}

struct DistanceRange {
  double lower = 0;
  double upper = 0;
};

Figures figures_of(const DistanceRange& range) { return {{Key::lower, range.lower}, {Key::upper, range.upper}}; }

// Bounds of the Hausdorff distance between the simplified mesh and the one before untangling, and changes of the
// components.
struct Simplified {
  edit::SimplifyFigures facts;
  std::uint64_t asked = 0;  // requested triangles; 0: no number was requested
  DistanceRange voxels;
  DistanceRange world;  // in the mesh's units
  std::uint64_t components = 0;
  // Lower bound of the components turned inside out; shells thinner than the distance may turn.
  std::uint64_t turned = 0;
  std::uint64_t left_bodies = 0;  // cavities (closed components that face inward) that no longer lie in a body
};

std::string why_unchanged(const SimplifyChoice& asked, const Simplified& done) {
  const std::uint64_t before = done.facts.triangles_before;
  if (before == 0) return "the mesh has no triangles";
  if (done.asked >= before && done.asked > 0) {
    return fmt::format("the mesh has {}, and the target is {}", counted(before, "triangle"), done.asked);
  }
  if (!asked.within) {
    return fmt::format("removing any of the {} triangles would change the topology", before);
  }
  return fmt::format("removing any of the {} triangles would move the surface by more than {}", before,
                     bound_text(*asked.within));
}

std::string range_text(const DistanceRange& range) { return fmt::format("{:.4g} to {:.4g}", range.lower, range.upper); }

std::string line_of(const SimplifyChoice& asked, const Simplified& done, const std::string& surface,
                    const Source& source) {
  const edit::SimplifyFigures& facts = done.facts;
  const double seconds = facts.time.wall_seconds;
  if (facts.triangles_after == facts.triangles_before) {
    return fmt::format("not simplified{}: {}; {:.2f} s", surface, why_unchanged(asked, done), seconds);
  }
  std::string text =
      fmt::format("simplified{}: {} of {} left ({:.1f} %); requested {}, measured {}; {:.2f} s", surface,
                  facts.triangles_after, counted(facts.triangles_before, "triangle"),
                  100.0 * static_cast<double>(facts.triangles_after) / static_cast<double>(facts.triangles_before),
                  asked_text(asked), source.length_text(range_text(done.voxels), range_text(done.world)), seconds);
  if (done.asked > 0 && facts.triangles_after > done.asked) {
    text += asked.within ? "; fewer triangles would exceed the distance or change the topology"
                         : "; fewer triangles would change the topology or flip triangles";
  }
  return text;
}

Notes notes_of(const Simplified& done, const std::string& surface) {
  const edit::SimplifyFigures& facts = done.facts;
  Notes notes;
  if (done.turned > 0) {
    notes.push_back(
        {NoteId::simplified_shells,
         fmt::format("{}: simplification turned {} of {} components inside out, because they are too thin for the "
                     "simplification; set a smaller distance or more triangles, or remove the smallest components",
                     surface, done.turned, done.components)});
  }
  if (done.left_bodies > 0) {
    notes.push_back(
        {NoteId::simplified_shells,
         fmt::format(
             "{}: simplification moved {} out of the surrounding body, because the wall between them is too thin "
             "for the simplification; set a smaller distance or more triangles, or fill cavities",
             surface, counted(done.left_bodies, "cavity", "cavities"))});
  }
  if (facts.windows > 0) {
    notes.push_back(
        {NoteId::simplified_in_windows,
         fmt::format("{}: simplified in {}, because the memory limit does not allow the whole mesh at once; with "
                     "another limit, the mesh has other triangles",
                     surface, counted(facts.windows, "window"))});
  }
  // A closed component has at least four triangles.
  const std::uint64_t asked = done.asked;
  const bool is_much = done.components > 1 && 4 * done.components > asked / 2;
  if (asked > 0 && is_much && (facts.triangles_after > asked || done.voxels.lower > 1)) {
    notes.push_back(
        {NoteId::many_components,
         fmt::format("{}: {} components, each of which stays, have many of the {} remaining triangles; remove the "
                     "smallest components to bring the others nearer to the surface",
                     surface, done.components, facts.triangles_after)});
  }
  return notes;
}

}  // namespace

std::uint64_t wanted_triangles(const TriangleCount& count, std::uint64_t triangles) {
  const double whole =
      count.in_percent ? std::floor(count.amount / 100 * static_cast<double>(triangles)) : count.amount;
  return std::max<std::uint64_t>(1, static_cast<std::uint64_t>(std::min(whole, static_cast<double>(triangles))));
}

std::string triangle_count_text(const TriangleCount& count) {
  return fmt::format("{}{}", count.amount, count.in_percent ? "%" : "");
}

std::string simplify_bound_text(const SimplifyBound& bound) {
  return fmt::format("{}{}", bound.distance, bound.in_world_units ? "world" : "voxel");
}

namespace {

// Options of a simplification, without the number of triangles.
struct SimplifyPlan {
  edit::SimplifyOptions options;
  Stretch voxel;

  // Distances are in voxels, whose size output_from_index gives, or in the mesh's units. `edge` is a typical edge of
  // the mesh: patches depend on the mesh alone, so that a mesh file gives the same triangles as the volume it came
  // from.
  SimplifyPlan(const SimplifyChoice& choice, const field::Affine& output_from_index, double edge)
      : voxel(stretch_of(output_from_index.linear)) {
    options.max_distance = choice.within ? choice.within->distance : std::numeric_limits<double>::infinity();
    options.patch_size = kPatchEdges * edge;
    const bool in_world_units = choice.within && choice.within->in_world_units;
    if (!in_world_units && voxel.is_even()) {
      options.max_distance *= voxel.least;
    } else if (!in_world_units) {
      options.to_metric = glm::inverse(output_from_index.linear);
      options.patch_size = kPatchVoxels;
    }
  }

  // `untangled_by` is the largest distance, in voxels, by which untangling moved the surface before.
  void set_distance(Simplified& result, double untangled_by) const {
    const bool is_in_voxels = options.to_metric != glm::dmat3(1.0);
    const double before = is_in_voxels ? untangled_by : untangled_by * voxel.most;
    const DistanceRange measured{std::max(0.0, result.facts.distance_lower - before),
                                 result.facts.distance_upper + before};
    if (is_in_voxels) {
      result.voxels = measured;
      result.world = {measured.lower * voxel.least, measured.upper * voxel.most};
    } else {
      result.world = measured;
      result.voxels = {measured.lower / voxel.most, measured.upper / voxel.least};
    }
  }
};

void set_components(Simplified& result, const ComponentCount& before, const ComponentCount& after) {
  result.components = after.components;
  result.turned = std::max(before.cavities, after.cavities) - std::min(before.cavities, after.cavities);
  // A body turned inside out counts as an inward component, but is no cavity that left its body.
  const std::uint64_t known = before.outside + after.cavities - std::min(before.cavities, after.cavities);
  result.left_bodies = after.outside - std::min(known, after.outside);
}

// Returns a report with the figures of one surface, without sentences.
StageReport report_of(const SimplifyChoice& choice, const Simplified& result, const Surface& surface,
                      const StageContext& stage) {
  const edit::SimplifyFigures& facts = result.facts;
  const auto& within = choice.within;
  const Value asked =
      !within
          ? Value()
          : Value(Figures{{Key::distance, within->distance}, {Key::unit, within->in_world_units ? "world" : "voxel"}});
  StageReport report = stage.report_on(StageName::simplify, surface);
  report.add_timed(
      {{Key::asked, asked},
       {Key::asked_triangles, choice.triangles ? Value(triangle_count_text(*choice.triangles)) : Value()},
       {Key::measured, Figures{{Key::voxels, figures_of(result.voxels)}, {Key::world, figures_of(result.world)}}},
       {Key::triangles_before, facts.triangles_before},
       {Key::triangles_after, facts.triangles_after},
       {Key::passes, facts.passes},
       {Key::refused_collapses, facts.refused_collapses},
       {Key::components, result.components},
       {Key::turned_inside_out, result.turned},
       {Key::left_bodies, result.left_bodies},
       {Key::windows, facts.windows}},
      facts.time);
  return report;
}

void add_sentences(StageReport& report, const SimplifyChoice& choice, const Simplified& result,
                   const std::string& surface, const std::string& subject, const Source& source) {
  const edit::SimplifyFigures& facts = result.facts;
  report.did = "simplified";
  report.details.push_back(
      fmt::format("{} over {}; {} of {} undone in {}, {} because triangles intersected "
                  "afterwards; {} refused because triangles would have intersected; {:.2f} s of processor time",
                  counted(facts.rounds, "round"), counted(facts.patches, "patch", "patches"),
                  facts.undone_collapses + facts.untangled_collapses, counted(facts.collapses, "collapse"),
                  counted(facts.passes, "pass", "passes"), facts.untangled_collapses,
                  counted(facts.refused_collapses, "collapse"), facts.time.cpu_seconds));
  report.lines.push_back({line_of(choice, result, surface, source)});
  report.notes = notes_of(result, subject);
}

// Returns the part of the time that goes to `part` of `whole` triangles.
StageTime share_of(const StageTime& time, std::uint64_t part, std::uint64_t whole) {
  const double share = whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 0;
  StageTime result = time;
  result.wall_seconds *= share;
  result.cpu_seconds *= share;
  return result;
}

// Returns the line that tells by how much the volume of a label changes most.
StageReport::Line line_of_volumes(std::span<const HeldLabel> labels, std::span<const double> before) {
  constexpr double kLeast = 1e-6;  // less is rounding
  std::size_t most = 0;
  double greatest = 0;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const double after = mesh::measure_size(labels[i].surface->mesh).volume;
    const double change = before[i] != 0 ? after / before[i] - 1 : 0;
    if (std::abs(change) <= std::abs(greatest)) continue;
    most = i;
    greatest = change;
  }
  if (std::abs(greatest) < kLeast) return {"no label changed its volume"};
  return {fmt::format("the volume changed most at {}: {:.3g} % {}", labels[most].surface->id.name(),
                      100 * std::abs(greatest), greatest > 0 ? "more" : "less")};
}

}  // namespace

Result<StageReport> simplify_surface(Surface& surface, const StageContext& stage) {
  if (!stage.job.edits.simplify) return StageReport();
  const SimplifyChoice& choice = *stage.job.edits.simplify;
  SimplifyPlan plan(choice, stage.source.output_from_index, mesh::typical_edge(surface.mesh));
  if (choice.triangles) plan.options.triangles = wanted_triangles(*choice.triangles, surface.mesh.triangles.size());
  const auto before = TRY(count_components(surface.mesh, stage.context));
  auto simplified = TRY(edit::simplify_mesh(std::move(surface.mesh), plan.options, stage.context));
  surface.mesh = std::move(simplified.mesh);
  const auto after = TRY(count_components(surface.mesh, stage.context));

  Simplified result;
  result.asked = plan.options.triangles;
  result.facts = simplified.facts;
  set_components(result, before, after);
  plan.set_distance(result, surface.untangled_by);
  // Untangling keeps caps in their planes, so only simplification can have moved them.
  Simplified alone = result;
  plan.set_distance(alone, 0);
  surface.simplified_by = alone.voxels.upper;
  StageReport report = report_of(choice, result, surface, stage);
  add_sentences(report, choice, result, surface.id.at_text(), report.subject, stage.source);
  return report;
}

Result<void> simplify_labels(std::span<const HeldLabel> labels, const StageContext& stage) {
  if (labels.empty()) return {};
  const SimplifyChoice& choice = *stage.job.edits.simplify;
  const double voxel = std::cbrt(std::abs(stage.source.output_from_index.determinant()));
  SimplifyPlan plan(choice, stage.source.output_from_index, kPatchVoxels / kPatchEdges * voxel);
  std::vector<mesh::Mesh*> meshes;
  std::vector<ComponentCount> before;
  std::vector<std::uint64_t> triangles_before;
  std::vector<double> volumes_before;
  std::uint64_t triangles = 0;
  for (const HeldLabel& label : labels) {
    mesh::Mesh& mesh = label.surface->mesh;
    meshes.push_back(&mesh);
    before.push_back(TRY(count_components(mesh, stage.context)));
    triangles_before.push_back(mesh.triangles.size());
    volumes_before.push_back(mesh::measure_size(mesh).volume);
    triangles += mesh.triangles.size();
  }
  Simplified whole;
  std::uint64_t sheets = 0;
  {
    const auto net = TRY(edit::LabelNet::join(meshes, stage.context));
    if (choice.triangles) plan.options.triangles = wanted_triangles(*choice.triangles, net.triangles());
    whole.asked = plan.options.triangles;
    sheets = net.sheets();
    whole.facts = TRY(net.simplify(meshes, plan.options, stage.context));
  }
  plan.set_distance(whole, 0);
  std::vector<StageReport> reports;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    Surface& surface = *labels[i].surface;
    Simplified own = whole;
    own.facts.triangles_before = triangles_before[i];
    own.facts.triangles_after = surface.mesh.triangles.size();
    own.facts.time = share_of(whole.facts.time, triangles_before[i], triangles);
    const auto after = TRY(count_components(surface.mesh, stage.context));
    set_components(own, before[i], after);
    whole.components += own.components;
    whole.turned += own.turned;
    whole.left_bodies += own.left_bodies;
    surface.simplified_by = own.voxels.upper;
    reports.push_back(report_of(choice, own, surface, stage));
  }
  const std::string name =
      labels.size() == 1 ? labels.front().surface->id.name() : fmt::format("{} labels together", labels.size());
  const bool is_one = labels.size() == 1;
  add_sentences(reports.front(), choice, whole, is_one ? labels.front().surface->id.at_text() : " " + name,
                fmt::format("{} {}", stage.source.label, name), stage.source);
  const bool are_closed = stage.source.clip.empty() || stage.job.surface.cap;
  if (are_closed) reports.front().lines.push_back(line_of_volumes(labels, volumes_before));
  if (!is_one) {
    reports.front().lines.push_back(
        {fmt::format(
             "simplified {} as one net of {} sheets, each between two labels or a label and no label; all meshes "
             "were in memory together, and triangles of two labels count once",
             name, sheets),
         true});
  }
  for (std::size_t i = 0; i < labels.size(); ++i) TRY(tell(reports[i], *labels[i].events));
  return {};
}

}  // namespace isoextract::convert
