// The report of one conversion stage: named figures, sentences about them, and the stage's time. JSON reports, tables,
// pages and printed lines are all made from these reports.
//
// A new figure needs a value of Key. An edit with StageInfo::done and without lines of its own prints the figures of
// its first entry as they are (run_stage()). A new section of the report is a stage with a `section` in kStages. It
// needs an optional property in report.schema.json, which rejects unknown properties. tests/cli/report_test.py
// validates reports, and compares their figures with the files. Work that a stage left out is a WorkFact
// (work_facts.hpp), so that --explain prints it as well.
#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include <glm/glm.hpp>

#include "base/enum_words.hpp"
#include "base/error.hpp"
#include "base/note.hpp"
#include "base/stopwatch.hpp"
#include "convert/json_type.hpp"
#include "convert/stages.hpp"
#include "convert/work_facts.hpp"

namespace isoextract::convert {

// Keys of figures; the JSON report uses the same names.
// clang-format off
#define ISOEXTRACT_FIGURES(NAME) \
  NAME(welded) NAME(without_area) NAME(duplicates) NAME(turned) NAME(contradictions) NAME(holes_filled) NAME(fill_triangles) NAME(holes_left) NAME(vertices_split) NAME(unused_removed) NAME(components_turned) NAME(verdict) \
  NAME(after) NAME(analytic) NAME(area) NAME(asked) NAME(asked_triangles) NAME(attribute) NAME(axis) NAME(backends) \
  NAME(before) NAME(bits) NAME(bodies) NAME(border_vertices) NAME(bounds) NAME(box) NAME(bricks_inside) \
  NAME(bricks_stored) NAME(bytes_after) NAME(bytes_before) NAME(cap_triangles) NAME(cap_vertices) NAME(cavities) NAME(cavity) \
  NAME(changed) NAME(changed_components) NAME(chosen) NAME(chosen_of) NAME(closed) NAME(closed_form) NAME(component_table) NAME(components) \
  NAME(compression) NAME(corrected) NAME(coverage) NAME(cpu_seconds) NAME(creator) NAME(degrees) \
  NAME(degrees_allowed) NAME(differences) NAME(dims) NAME(distance) NAME(distances) NAME(edges) NAME(error) NAME(euler) \
  NAME(exact) NAME(file) NAME(file_bytes) NAME(flat_normals) NAME(flattened_triangles) NAME(flips) NAME(format) NAME(found_by) NAME(frame) \
  NAME(genus) NAME(greatest_move) NAME(grid) NAME(held_vertices) NAME(index_to_world) NAME(inside) NAME(intercept) NAME(interior) \
  NAME(interpolant) NAME(iso) NAME(kind) NAME(largest) NAME(left_bodies) NAME(left_out_inside) NAME(length_unit) \
  NAME(lost_components) NAME(lower) NAME(map) NAME(max) NAME(max_at_most) NAME(max_degrees) NAME(mean_weight) NAME(measured) \
  NAME(method) NAME(min) NAME(misoriented_edges) NAME(moved) NAME(moved_by) NAME(name) NAME(nonmanifold_edges) \
  NAME(nonmanifold_vertices) NAME(normal_degrees) NAME(not_applicable) NAME(not_finite) NAME(not_numbers) \
  NAME(one_by_one) NAME(open_edges) NAME(origin) NAME(others) NAME(out_of_reach) NAME(output_from_index) \
  NAME(outside) NAME(outside_region) NAME(own_range) NAME(pairs) NAME(particles) NAME(parts) NAME(pass_band) NAME(passed) NAME(passes) NAME(path) NAME(periodic) \
  NAME(percentile99) NAME(placement) NAME(points) NAME(positions) NAME(radius) NAME(radius_attribute) \
  NAME(radius_suggested) NAME(range) NAME(region) NAME(refused_collapses) NAME(relative_error) NAME(rms) NAME(rms_degrees) NAME(sample_type) \
  NAME(samples) NAME(scale) NAME(simulation_box) NAME(slope) NAME(smooth_normals) NAME(smoothing_length) NAME(source) NAME(spacing) \
  NAME(sparse) NAME(splits) NAME(step) NAME(storage) NAME(stored_bytes) NAME(support) NAME(time) NAME(to_unit) \
  NAME(too_small) NAME(touching) NAME(triangles) NAME(triangles_after) NAME(triangles_before) NAME(triangles_only) \
  NAME(turned_inside_out) NAME(ulps) NAME(ulps_allowed) NAME(unit) NAME(unit_of_lengths) NAME(unreached) NAME(upper) \
  NAME(value_scale) NAME(vertices) NAME(vertices_only) NAME(volume) NAME(voxels) NAME(wall_seconds) \
  NAME(windows) NAME(without_volume) NAME(work) NAME(world) NAME(world_space) NAME(worst) NAME(worst_component) \
  NAME(zero_area_triangles)
// clang-format on
#define ISOEXTRACT_NAME(name) name,
#define ISOEXTRACT_WORD(name) Word{Key::name, #name},
enum class Key { ISOEXTRACT_FIGURES(ISOEXTRACT_NAME) };
constexpr auto words_of(Key /*type*/) { return std::array{ISOEXTRACT_FIGURES(ISOEXTRACT_WORD)}; }
#undef ISOEXTRACT_FIGURES
#undef ISOEXTRACT_NAME
#undef ISOEXTRACT_WORD

struct Figure;
using Figures = std::vector<Figure>;

// A number, text, boolean, null, a list of values, or figures by name. Not the JSON type: reports are made while memory
// may run out, and the destructor of a JSON value allocates.
class Value {
 public:
  using List = std::vector<Value>;

  // Implicit conversions keep figure lists readable.
  // NOLINTBEGIN(google-explicit-constructor)
  Value() = default;
  Value(bool yes) : kind_(Kind::yes_or_no), integer_(yes ? 1 : 0) {}
  template <std::integral T>
  Value(T number) : kind_(Kind::integer), integer_(static_cast<std::int64_t>(number)) {}
  Value(double number) : kind_(Kind::number), number_(number) {}
  Value(std::string text) : kind_(Kind::text), text_(std::move(text)) {}
  Value(std::string_view text) : kind_(Kind::text), text_(text) {}
  Value(const char* text) : kind_(Kind::text), text_(text) {}
  Value(List list) : kind_(Kind::list), list_(std::move(list)) {}
  Value(Figures parts);
  Value(const glm::dvec3& v) : kind_(Kind::list), list_{v.x, v.y, v.z} {}
  Value(const field::Box& box);
  Value(const field::IndexBox& box);  // null if the box is empty
  Value(const field::Affine& map);    // three rows of four numbers: linear part, then offset
  Value(const StageTime& time);
  Value(const SurfaceId& id);  // a number for an iso value, an integer for a label, a text for a mesh of a file
  template <class T>
  Value(const std::optional<T>& value) {
    if (value) *this = Value(*value);
  }
  template <class T, std::size_t N>
  Value(const std::array<T, N>& all) : kind_(Kind::list), list_(all.begin(), all.end()) {}
  // NOLINTEND(google-explicit-constructor)

  [[nodiscard]] bool is_none() const { return kind_ == Kind::none; }
  [[nodiscard]] bool is_integer() const { return kind_ == Kind::integer; }
  [[nodiscard]] bool is_text() const { return kind_ == Kind::text; }
  [[nodiscard]] const Figures* parts() const { return parts_.get(); }
  template <class T>
  [[nodiscard]] T as() const {
    if constexpr (std::is_same_v<T, std::string>) return text_;
    if constexpr (std::is_arithmetic_v<T>)
      return kind_ == Kind::number ? static_cast<T>(number_) : static_cast<T>(integer_);
  }
  [[nodiscard]] Json json() const;

 private:
  enum class Kind { none, yes_or_no, integer, number, text, list, parts };

  Kind kind_ = Kind::none;
  std::int64_t integer_ = 0;
  double number_ = 0;
  std::string text_;
  List list_;
  std::shared_ptr<const Figures> parts_;  // shared by copies; a pointer, because Figure is incomplete here
};

struct Figure {
  Figure(Key name, Value figure) : key(name), value(std::move(figure)) {}
  // Makes a figure that appears in tables only, not in the JSON report.
  [[nodiscard]] static Figure of_tables(Key name, Value figure) {
    Figure made(name, std::move(figure));
    made.in_report = false;
    return made;
  }

  Key key;
  Value value;
  bool in_report = true;
};
[[nodiscard]] Json json_of(const Figures& figures);

// Returns the figure at this path of keys, or null if it is missing or its value is null.
[[nodiscard]] const Value* find(const Figures& figures, std::initializer_list<Key> path);
template <class T>
[[nodiscard]] std::optional<T> value_at(const Figures& figures, std::initializer_list<Key> path) {
  const Value* const found = find(figures, path);
  return found != nullptr ? std::optional<T>(found->as<T>()) : std::nullopt;
}

// Returns the surface that Key::iso names; the figures must have it.
[[nodiscard]] SurfaceId surface_id_at(const Figures& figures);

// Replaces the value of the figure `key`, if it exists.
void set(Figures& figures, Key key, Value value);

// Returns "24 triangles, greatest move 0.5 voxels, 0.1 world, method taubin": the printed line of a stage without its
// own sentences. Leaves out Key::time and figures of tables.
[[nodiscard]] std::string text_of(const Figures& figures);

// Where a surface has boundary edges, as far as extraction and clipping tell.
struct OpenBoundary {
  bool at_data_boundary = false;  // at the data boundary or at the region's sides
  bool periodic = false;          // the region ends at the faces of a periodic box
  bool cut = false;               // at a clip plane, and not capped
  bool needs_count = false;       // clipped without caps: only WrittenOutput::open_edges tells whether it is open
  std::uint64_t hole_cells = 0;   // cells left out because of NaN samples
};

// Defects that readers of the file find: readers that weld vertices by position, or, if the input was
// a mesh, all readers.
struct WeldedDefects {
  std::uint64_t open_edges = 0;
  std::uint64_t nonmanifold_edges = 0;
  std::uint64_t nonmanifold_vertices = 0;
  std::uint64_t misoriented_edges = 0;  // used only if the input is a mesh
};

// An output that was written, or that was skipped because none of its surfaces has triangles (then `surfaces` and
// `samples` are empty).
struct WrittenOutput {
  struct Part {
    std::string label;  // of the surface's field
    SurfaceId id;
    OpenBoundary end;
    std::string name = {};        // of the mesh
    std::uint64_t triangles = 0;  // of the mesh
    bool closed = false;          // the mesh has no boundary edge; used for labels only
    std::uint64_t voxels = 0;     // of a label, in the region
    double volume = 0;            // of these voxels, in output coordinates
  };
  std::vector<Part> surfaces;  // in the job's order
  std::string samples;         // of a field or particle file, without surfaces: "8 x 8 x 8 samples, as 32 bits each"
  std::string placement;       // "world coordinates, turned from z up to y up"
  std::uint64_t triangles = 0;
  std::uint64_t vertices = 0;
  std::uint64_t bytes = 0;
  std::size_t files = 0;
  std::optional<std::uint64_t> open_edges;  // boundary edges of its meshes, if they were counted
  WeldedDefects welded;                     // zeros also if readers of the format keep all vertices apart
};

struct StageReport {
  StageReport() = default;
  // Replaces aggregate initialization: if a member's initializer throws there, GCC does not destroy the members before
  // it.
  explicit StageReport(StageName name, std::string about = {}, std::string field = {},
                       std::optional<SurfaceId> surface = {})
      : stage(name), subject(std::move(about)), label(std::move(field)), id(surface) {}

  StageName stage = StageName::open;
  std::string subject = {};          // "fire.vdb", "fire.vdb iso 0.5", a written file, or a device
  std::string label = {};            // of the field; empty if the report is about a mesh file, a picture or a device
  std::optional<SurfaceId> id = {};  // set if the stage worked on one surface
  std::string grid = {};             // the grid of the surface, if the job has several
  std::optional<StageTime> time = {};
  // One for each entry of the JSON report: one in all, or one for each attribute, mesh or iso value.
  std::vector<Figures> entries = {};

  struct Part {
    StageName stage = StageName::open;
    std::optional<SurfaceId> id;
    StageTime time;
  };
  std::vector<Part> parts = {};  // stages whose times are reported instead of `time`

  // Sentences, none of which names an option.
  std::string did = {};                   // "smoothed": begins the line about the stage's time; empty: no such line
  std::vector<std::string> details = {};  // the first ends that line; the others are lines of their own
  struct Line {
    std::string text;
    bool explains = false;  // printed only with explanations
  };
  std::vector<Line> lines = {};     // printed below the line about the surface's file
  std::vector<WorkFact> work = {};  // printed with explanations, unless there are `lines`
  Notes notes = {};                 // sentences without their full stop

  std::optional<Error> error = {};           // set if the conversion ends with this stage
  std::optional<WrittenOutput> output = {};  // set for StageName::write

  // Adds an entry: the figures, with the time taken as the last one. Sets `time`, too.
  void add_timed(Figures figures, const StageTime& taken);
};

// Returns an empty report of a stage that works on the field.
[[nodiscard]] StageReport report_on(StageName stage, const std::string& label);

// Returns a report of a stage that changed the field as `fact` says.
[[nodiscard]] StageReport report_on_field(StageName stage, const std::string& label, WorkFact fact,
                                          const StageTime& time);

// Returns an entry of the report's JSON section: `figures`, with the surface's iso value and grid, and for
// StageName::extract with the report's work facts.
[[nodiscard]] Json entry_of(const StageReport& report, const Figures& figures);

// Returns the times to report: those of the parts, else the stage's own if StageInfo::is_timed, else none.
[[nodiscard]] std::vector<StageReport::Part> times_of(const StageReport& report);

}  // namespace isoextract::convert
