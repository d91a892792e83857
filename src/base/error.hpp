// Errors are values: every function that can fail below `cli` returns Result<T>; nothing there prints or exits, and all
// that it throws across a room's border is std::bad_alloc. `cli` turns an Error into a message on stderr and the exit
// code that exit_code_of() tells.
//
// Below `cli` nobody knows what an option is called: what helps is told by code (Remedy), and `cli` puts it into words.
#pragma once

#include <string>
#include <type_traits>
#include <utility>

#include <tl/expected.hpp>

namespace isoextract {

// What failed. The code is for branching; the message is for people, the hint for whoever words it.
enum class ErrorCode {
  usage,          // the options or their combination make no sense
  input,          // the input cannot be read, or does not hold what was asked for
  empty_grid,     // the input was read and is sound, but its grid has no voxels
  no_surface,     // likewise, but its values do not pass the iso value
  out_of_memory,  // the memory limit or the machine does not allow it now; it may when less runs beside it
  unavailable,    // a feature or device that was asked for is not there
  output,         // the result cannot be written
  frames,         // some of many frames failed
  verification,   // what was to be verified does not hold
  cancelled,      // somebody asked for the end
};

// The program's exit code.
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

// Whether the input was read and is sound, and there is no mesh all the same: to programs that may be no error.
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
  std::string message;  // names the file, what was expected and what was found; no trailing full stop or newline
  Hint hint;            // the step that helps; may be empty
};

template <class T>
using Result = tl::expected<T, Error>;

// return fail(ErrorCode::input, "a.nrrd: expected ..., found ...", Remedy::place_by_hand);
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

// `result` is declared there: no parentheses.
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

// The value of a result; where it is an error, the function around returns that error.
//
//   const Mesh mesh = TRY(extract(field, context));
//   TRY(write(mesh, path));
//
// Stands alone, or as all that initialises a variable or is returned: GCC forgets temporaries of the statement that
// were made before a return within it.
#define TRY(expression) ISOEXTRACT_TRY_AS(expression, __COUNTER__)
