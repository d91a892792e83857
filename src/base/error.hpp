// Errors are values: every function below `cli` that can fail returns Result<T>. Those rooms neither print nor exit,
// and the only exception that crosses a room's border is std::bad_alloc. `cli` prints the Error on stderr and exits
// with exit_code_of().
//
// No room below `cli` knows the name of an option: an error suggests a Remedy, and `cli` words it.
#pragma once

#include <string>
#include <type_traits>
#include <utility>

#include <tl/expected.hpp>

namespace isoextract {

// The cause of a failure. Programs branch on the code; people read the message and the hint.
enum class ErrorCode {
  usage,          // the options or their combination are invalid
  input,          // the input cannot be read, or does not contain the requested data
  empty_grid,     // the input is valid, but its grid has no voxels
  no_surface,     // the input is valid, but no value crosses the iso value
  out_of_memory,  // the memory limit or the machine does not allow it now; it may with fewer conversions at a time
  unavailable,    // a requested feature or device is missing
  output,         // the output cannot be written
  frames,         // some of many frames failed
  verification,   // a verification failed
  cancelled,      // cancelled by the user or the calling program
};

// Returns the program's exit code.
[[nodiscard]] constexpr int exit_code_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::usage: return 1;
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

// What helps. A code with a list behind it expects that in Hint::text, as a clause of its own.
enum class Remedy {
  none,
  raise_memory_limit,    // the machine may have more memory than the limit
  extract_part,          // a region needs less memory
  widen_region,          // the region asked for holds no cell
  choose_grid,           // text: the grids there are
  choose_grid_number,    // likewise, where names repeat
  leave_out_grid,        // the format has one volume a file
  describe_raw,          // a raw file needs dims and a type
  check_raw,             // what was said of a raw file does not go with its size
  retype_raw,            // text: the types of sample with which it would
  skip_in_raw,           // text: how many bytes to skip, with which it would
  read_as_raw,           // the bytes of any file can be read
  place_by_hand,         // spacing and origin in place of the file's frame
  rescale,               // another spacing, scale, unit or space
  place_nearer,          // a place nearer to the origin; text: the formats that keep the mesh where it is, if any
  choose_nan_policy,     // NaN outside, or as holes
  use_cpu,               // the CPU backend needs no GPU; text: what else helps, before it
  less_gpu_memory,       // the GPU takes less at a time
  more_gpu_memory,       // the GPU may take more
  other_gpu,             // that one is not there; one can be chosen by itself
  choose_mesh_format,    // text: the formats' names
  ascii_formats,         // text: the formats that can be text
  one_file_per_surface,  // text: the formats that hold several; or a file each
  region_is_in_voxels,   // the region was asked for in voxel coordinates
  region_is_in_world,    // in the input's world, before scales and turns
  choose_scale,          // another scale or unit
  name_unit,             // the file does not say which unit its world is in
  other_output_name,     // for a file that is written
  move_cut,              // cutting planes leave nothing of the surface; or an empty one is no error
  widen_region_or_skip,  // the region hides the surface; or an empty one is no error
  try_iso,               // text: another value and what it was found by; or an empty surface is no error
  other_iso,             // text: another value
  leave_out_coarsest,    // of several resolutions, or another value
  no_surface_or_skip,    // no value has a surface worth suggesting; or an empty surface is no error
  allow_empty,           // an empty surface is no error, or is written
  list_demo_fields,      // their names and keys
  list_gpus,             // their numbers and names
  name_frames,           // which frames are meant
  number_outputs,        // the frame's number, and what else tells the files apart, in the names of outputs
  report_gpu,            // what the GPU did is a fault of it or of ours; the CPU backend needs none
  choose_volume,         // text: the numbers that the file's volumes have
  leave_out_volume,      // there is one volume in the file
  read_as_particles,     // rows of an array that is no volume may be particles
  leave_out_particles,   // options of particles do nothing for a volume
  choose_frame,          // of several in a file of particles
  leave_out_volumes,     // options of volumes do nothing for particles
  choose_radius,         // the particles do not tell how large they are
  skip_particles,        // those at places that are no numbers can be left out
  fewer_attributes,      // of particles, for vertices
  smaller_cells,         // samples nearer to each other, of particles
  leave_out_filters,     // they are for level sets
  store_floats,          // half floats do not reach so far
  read_in_process,       // a file that is trusted needs no process of its own for its plug-in
};

struct Hint {
  Remedy remedy = Remedy::none;
  std::string text;  // a sentence without a full stop that names no option; may be empty

  // Implicit, so that fail(code, message, "...") and fail(code, message, Remedy::...) read as they are meant.
  // NOLINTBEGIN(google-explicit-constructor)
  Hint() = default;
  Hint(std::string words) : text(std::move(words)) {}
  Hint(const char* words) : text(words) {}
  Hint(Remedy code, std::string words = {}) : remedy(code), text(std::move(words)) {}
  // NOLINTEND(google-explicit-constructor)

  [[nodiscard]] bool empty() const { return remedy == Remedy::none && text.empty(); }
  friend bool operator==(const Hint&, const Hint&) = default;
};

struct Error {
  ErrorCode code;
  std::string message;  // names the file, the expected and the found value; no trailing full stop or newline
  Hint hint;            // what the user can do; may be empty
};

template <class T>
using Result = tl::expected<T, Error>;

// Example: return fail(ErrorCode::input, "a.nrrd: expected ..., found ...", Remedy::place_by_hand);
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

// The macro declares a variable called `result`, so it cannot be in parentheses.
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
// Use it as a statement of its own, or as the whole initializer or return value. Elsewhere GCC does not destroy the
// temporaries that the statement made before TRY returned.
#define TRY(expression) ISOEXTRACT_TRY_AS(expression, __COUNTER__)
