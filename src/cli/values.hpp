// Parses the values of options. Fails with ErrorCode::usage; messages say what was expected and found, and the caller
// prepends the option's name.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <glm/glm.hpp>

#include "base/error.hpp"
#include "base/note.hpp"
#include "convert/conversion_job.hpp"
#include "extract/extractor.hpp"
#include "field/affine.hpp"
#include "gl/gpu_device.hpp"
#include "simulate/water.hpp"

namespace isoextract::cli {

// One volume of a file by its number, or all volumes.
struct AllVolumes {};
using VolumeChoice = std::variant<std::int64_t, AllVolumes>;

// A radius of particles. Unset: the program finds the radius, for each frame separately if `is_of_each_frame`, else
// once for all frames.
struct RadiusChoice {
  std::optional<double> radius;
  bool is_of_each_frame = false;
};

// The floor of terrain; unset height: no floor (the word "none").
struct HeightBase {
  std::optional<double> height;
};

[[nodiscard]] Result<std::string> parse_text(std::string_view text);        // anything, the empty text too
[[nodiscard]] Result<double> parse_number(std::string_view text);           // finite
[[nodiscard]] Result<convert::IsoChoice> parse_iso(std::string_view text);  // a finite number, auto, zero or p0..p100
[[nodiscard]] Result<std::int64_t> parse_label(std::string_view text);
[[nodiscard]] Result<std::vector<convert::IsoChoice>> parse_labels(std::string_view text);  // all or 1,2 or 1-9,A*,!3
[[nodiscard]] Result<double> parse_positive(std::string_view text);                         // finite, above 0
[[nodiscard]] Result<RadiusChoice> parse_radius(std::string_view text);                     // above 0, auto, auto:each
[[nodiscard]] Result<double> parse_not_negative(std::string_view text);                     // finite, 0 or above
[[nodiscard]] Result<convert::SimplifyBound> parse_simplify_bound(
    std::string_view text);  // 0.1, 0.1voxel or 0.5world, above 0; 0.1 is in voxels
[[nodiscard]] Result<convert::TriangleCount> parse_triangle_count(std::string_view text);  // 100000, 50k, 2M or 2.5%
[[nodiscard]] Result<double> parse_part(std::string_view text);                            // 0 to 1
[[nodiscard]] Result<double> parse_one_or_more(std::string_view text);                     // finite, 1 or above
[[nodiscard]] Result<std::uint64_t> parse_count(std::string_view text);                    // a whole number, 0 or above
[[nodiscard]] Result<std::uint64_t> parse_components(std::string_view text);               // 1..64
[[nodiscard]] Result<std::uint64_t> parse_relaxations(std::string_view text);              // 0..10000
[[nodiscard]] Result<std::uint64_t> parse_positive_count(std::string_view text);           // a whole number, 1 or above
[[nodiscard]] Result<glm::ivec2> parse_grid_size(std::string_view text);    // NXxNY or NX,NY, each 2 to 32768
[[nodiscard]] Result<glm::dvec3> parse_sides(std::string_view text);        // AxBxC or one for all, above 0
[[nodiscard]] Result<simulate::WaterTap> parse_tap(std::string_view text);  // X,Y,RATE: a cell, a rate above 0
[[nodiscard]] Result<glm::dvec3> parse_vector(std::string_view text);       // X,Y,Z
[[nodiscard]] Result<glm::dvec3> parse_spacing(std::string_view text);      // SX,SY,SZ or one for all, above 0
[[nodiscard]] Result<glm::ivec3> parse_dims(std::string_view text);         // NX,NY,NZ or NXxNYxNZ, above 0
[[nodiscard]] Result<glm::ivec3> parse_resolution(std::string_view text);   // as dims or one for all, 2 or above
[[nodiscard]] Result<render::PictureSize> parse_picture_size(std::string_view text);  // WxH, each from 1 to 16384
[[nodiscard]] Result<convert::FilterStep> parse_filter(std::string_view text);    // gaussian|median|mean[:N], N 1 to 64
[[nodiscard]] Result<std::array<bool, 3>> parse_periodic(std::string_view text);  // x,y,z, some of them, or none
[[nodiscard]] Result<field::Box> parse_box(std::string_view text);                // X0,Y0,Z0,X1,Y1,Z1, min <= max
[[nodiscard]] Result<convert::ClipPlane> parse_clip_plane(std::string_view text);       // NX,NY,NZ,D; a normal not 0
[[nodiscard]] Result<std::array<std::string, 3>> parse_columns(std::string_view text);  // x=A,y=B,z=C in any order
// These three return a condition on particles (points/selection_expression.hpp).
[[nodiscard]] Result<std::string> parse_selection(std::string_view text);                 // a condition
[[nodiscard]] Result<std::string> parse_types(std::string_view text);                     // 2,3 or 1..3
[[nodiscard]] Result<std::string> parse_species(std::string_view text);                   // O,H
[[nodiscard]] Result<VolumeChoice> parse_volume(std::string_view text);                   // 0 or above, or all
[[nodiscard]] Result<std::int64_t> parse_volume_number(std::string_view text);            // 0 or above
[[nodiscard]] Result<volume_io::ComponentChoice> parse_component(std::string_view text);  // 0 or above, or length
[[nodiscard]] Result<int> parse_thread_count(std::string_view text);                      // 1..1024
[[nodiscard]] Result<std::uint64_t> parse_size(std::string_view text);  // bytes, below 2^63: 512, 16M, 1.5GiB
// Parses as parse_size() does, but refuses a number below convert::kProgramBytes (15 MiB) without a unit: "20" more
// likely means 20G.
[[nodiscard]] Result<std::uint64_t> parse_memory_size(std::string_view text);

[[nodiscard]] Result<convert::MinComponentSize> parse_min_component_size(
    std::string_view text);                                                          // 100, area:40, volume:5world
[[nodiscard]] Result<HeightBase> parse_height_base(std::string_view text);           // a finite number, or none
[[nodiscard]] Result<convert::RepairChoice> parse_repair(std::string_view text);     // 0..1000 edges of a hole
[[nodiscard]] Result<convert::SmoothChoice> parse_smoothing(std::string_view text);  // 20, 20:sinc, 20:taubin:0.05
[[nodiscard]] Result<convert::HollowChoice> parse_hollow(std::string_view text);     // 2mm, 2world, 3voxel
[[nodiscard]] Result<convert::BlurStep> parse_blur(std::string_view text);           // 2, 2voxel, 0.5world, median:1

// Parses finite numbers separated by commas, at least one; nullopt for anything else.
[[nodiscard]] std::optional<std::vector<double>> parse_numbers(std::string_view text);

// Parses a list separated by commas, without repetition. The result is in ascending order unless noted.
[[nodiscard]] Result<std::vector<int>> parse_thread_counts(std::string_view text);        // 1..1024
[[nodiscard]] Result<std::vector<int>> parse_demo_sizes(std::string_view text);           // 8..2048
[[nodiscard]] Result<std::vector<int>> parse_coarse_factors(std::string_view text);       // powers of two from 2 to 64
[[nodiscard]] Result<std::vector<extract::Method>> parse_methods(std::string_view text);  // in the order given

[[nodiscard]] Result<std::vector<NoteId>> parse_note_ids(std::string_view text);  // in the order given

[[nodiscard]] Result<gl::DeviceChoice> parse_device(std::string_view text);  // N, cuda:N or a name

[[nodiscard]] Result<int> parse_repeats(std::string_view text);  // 1..1000

// Returns `text` as one word of a shell, quoted only if needed. If printable() would change it, returns the form
// $'a\nb' with all control characters and non-ASCII bytes escaped, which POSIX shells have only since POSIX.1-2024.
[[nodiscard]] std::string shell_quoted(std::string_view text);

}  // namespace isoextract::cli
