// Errors are values: functions in the rooms (folders of src) below `cli` that can fail return Result<T>. These rooms do
// not print, and only the child processes of `sandbox` exit. Other exceptions than std::bad_alloc cross a room's border
// only where a header says so. `cli` prints the Error on stderr and exits with exit_code_of().
//
// Code below `cli` does not know the names of options: a hint is a list of steps, each a Remedy and a Setting, which
// `cli` turns into text.
#pragma once

#include <initializer_list>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <tl/expected.hpp>

namespace isoextract {

// The cause of a failure. Programs branch on the code; people read the message and the hint.
enum class ErrorCode {
  usage,          // the options or their combination are invalid
  placement,      // the input does not allow the requested placement
  input,          // the input cannot be read, or does not contain the requested data
  empty_grid,     // the input is valid, but it has no voxels or no particles
  no_surface,     // the input is valid, but no value crosses the iso value
  out_of_memory,  // not enough memory is free now; fewer conversions at a time may fit
  unavailable,    // a requested feature, plug-in or device is missing or fails
  output,         // the output cannot be written
  frames,         // some of many frames failed or are missing
  verification,   // a verification failed
  cancelled,      // cancelled by the user or the calling program
};

// Returns the program's exit code.
[[nodiscard]] constexpr int exit_code_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::usage:
    case ErrorCode::placement: return 1;
    case ErrorCode::input:
    case ErrorCode::empty_grid:
    case ErrorCode::no_surface:
    case ErrorCode::out_of_memory: return 2;
    case ErrorCode::unavailable: return 3;
    case ErrorCode::output: return 4;
    case ErrorCode::frames: return 5;
    case ErrorCode::verification: return 6;
    case ErrorCode::cancelled: break;
  }
  return 130;  // 128 + SIGINT
}

// Returns whether the input is valid but has no surface. Some programs do not treat this as an error.
[[nodiscard]] constexpr bool has_no_surface(ErrorCode code) {
  return code == ErrorCode::empty_grid || code == ErrorCode::no_surface;
}

// The action of a step. Where the comment says "text:", Step::text has this content.
enum class Remedy {
  say,        // the text is the whole step
  raise,      // give a larger value
  lower,      // give a smaller value
  give,       // give the missing value; text: a reason
  choose,     // choose one of several; text: "from 0 to 4", or a line break and the list
  change,     // give another value; text: which one
  leave_out,  // text: a reason
  use,
  set,        // text: the value and its effect
  try_value,  // text: the value and its source
  check,      // the given value may be wrong; text: a reason
  see,        // read a list of the possible values
  report,     // report a fault of the driver or of this program
};

// The option of a step, or several options that belong together.
enum class Setting {
  none,
  // The input
  input_format,
  grid,
  volume,  // the number of a volume or of a frame of particles
  component,
  raw_layout,     // dims and sample type of a raw file
  sample_type,    // of a raw file
  skipped_bytes,  // the length of a raw file's header
  axis_order,
  level,         // of a pyramid of resolutions
  even_spacing,  // resample unevenly spaced samples
  spacing_and_origin,
  frames,
  demo_fields,
  in_process,  // run a plug-in without a child process
  attribute,
  attribute_volume,  // this and the next two are about the file of an attribute
  attribute_component,
  attribute_spacing_and_origin,
  volume_options,  // options of volumes that particles do not have
  // Particles
  particle_options,  // all options of particles
  particle_method,
  radius,
  cell_size,
  simulation_box,
  periodic_edges,
  columns,     // of x, y and z in a table
  selection,   // a condition that chooses particles
  unwrapping,  // by image flags
  // The surface
  iso,
  region,
  parts,  // one region after another in place of the whole grid
  clip,
  cuts,  // clip planes and the faces of the region
  cap,
  labels,
  resampling,  // to another grid
  nan_policy,
  empty_policy,
  level_set_filter,
  blur,
  height_field,  // make terrain of heights
  height_base,   // the floor of terrain
  resolutions,   // the resolutions of a benchmark
  repair,        // of mesh files
  hole_edges,    // edges of the longest hole that repair fills
  smoothing,
  hollow,
  fewer_bodies,
  split_bodies,  // a mesh for each body
  // The output
  mesh_format,
  half_floats,
  output_name,
  animation,
  frame_rate,
  masks,  // one output for several mask files of one grid
  unit,
  scale,     // all options that scale the mesh
  position,  // all options that move the mesh
  // The run
  memory_limit,
  cpu_backend,
  gpu_memory,
  device,
  devices,  // the list of devices
};

struct Step {
  Remedy remedy = Remedy::say;
  Setting setting = Setting::none;
  std::string text;  // without a full stop and without the name of an option

  // Converts implicitly, so that a list of steps can contain a string.
  // NOLINTBEGIN(google-explicit-constructor)
  Step(std::string words) : text(std::move(words)) {}
  Step(const char* words) : text(words) {}
  // NOLINTEND(google-explicit-constructor)
  Step(Remedy what, Setting of, std::string words = {}) : remedy(what), setting(of), text(std::move(words)) {}

  friend bool operator==(const Step&, const Step&) = default;
};

// Alternative steps, the best one first.
struct Hint {
  std::vector<Step> steps;

  // Converts implicitly, so that fail() takes a string, one step in braces, or a list of steps.
  // NOLINTBEGIN(google-explicit-constructor)
  Hint() = default;
  Hint(std::initializer_list<Step> several) : steps(several) {}
  Hint(std::string words);  // no step if `words` is empty
  Hint(const char* words) : Hint(std::string(words)) {}
  Hint(Remedy remedy, Setting setting, std::string text = {});
  // NOLINTEND(google-explicit-constructor)

  [[nodiscard]] bool empty() const { return steps.empty(); }
  friend bool operator==(const Hint&, const Hint&) = default;
};

struct Error {
  ErrorCode code;
  std::string message;  // names the file, the expected and the found value; no trailing full stop or newline
  Hint hint;            // steps that the user can take; may be empty
};

template <class T>
using Result = tl::expected<T, Error>;

// Example: return fail(ErrorCode::input, "a.nrrd: expected ..., found ...", {Remedy::give,
// Setting::spacing_and_origin});
[[nodiscard]] inline tl::unexpected<Error> fail(ErrorCode code, std::string message, Hint hint = {}) {
  return tl::unexpected<Error>(Error{code, std::move(message), std::move(hint)});
}

namespace detail {

template <class T, class E>
T taken(tl::expected<T, E>&& result) {
  if constexpr (!std::is_void_v<T>) return *std::move(result);
}
template <class T, class E>
T taken(const tl::expected<T, E>& result) {
  if constexpr (!std::is_void_v<T>) return *result;
}

}  // namespace detail
}  // namespace isoextract

// `result` stays without parentheses: it is the name of the declared variable, and decltype((result)) is another type.
// NOLINTBEGIN(bugprone-macro-parentheses)
#define ISOEXTRACT_JOINED(a, b) a##b
#define ISOEXTRACT_TRY(expression, result)                                              \
  __extension__({                                                                       \
    auto&& result = (expression);                                                       \
    if (!result) return tl::unexpected(std::forward<decltype(result)>(result).error()); \
    ::isoextract::detail::taken(std::forward<decltype(result)>(result));                \
  })
// NOLINTEND(bugprone-macro-parentheses)
#define ISOEXTRACT_TRY_AS(expression, number) ISOEXTRACT_TRY(expression, ISOEXTRACT_JOINED(try_result_, number))

// Returns the value of a result. If the result is an error, the enclosing function returns that error.
//
//   const Mesh mesh = TRY(extract(field, context));
//   TRY(write(mesh, path));
//
// Use it as a statement of its own, or as the whole initializer or return value. In the middle of a larger expression,
// GCC does not destroy the temporaries of that expression if TRY returns.
#define TRY(expression) ISOEXTRACT_TRY_AS(expression, __COUNTER__)
