// Finds, in the field that was read, the iso values that a job asks for.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/context.hpp"
#include "base/error.hpp"
#include "convert/iso_choice.hpp"
#include "field/scalar_field.hpp"
#include "points/method.hpp"

namespace isoextract::convert {

struct ResolvedIso {
  IsoChoice asked;
  SurfaceId id;          // a set of labels (IsoChoice::is_label_set()) has iso 0 here, which identifies no surface
  std::string found_by;  // "Otsu's threshold (1979) of the histogram"; empty for given iso values and labels
};

// Returns "0.3", or for a value found in the field "p99 (0.3)"; the default value has no word.
[[nodiscard]] std::string text_of(const ResolvedIso& iso);
// Returns "iso 0.3", "label 5", "mesh".
[[nodiscard]] std::string surface_text(const IsoChoice& asked);
// Continues a sentence about the surface: " at iso p99", " of mesh 2"; empty for a whole mesh file.
[[nodiscard]] std::string place_text(const ResolvedIso& asked);

// Returns whether all iso values are known without the field: IsoChoice::is_found() is false for each.
[[nodiscard]] bool all_known(std::span<const IsoChoice> choices);

// Returns one iso value for each choice, in order. Examines all samples for percentiles, and for suggestions that
// field::default_iso() does not settle. If no sample is finite, percentiles are 0, and no suggestion fails.
//
// Fails with ErrorCode::usage if IsoChoice::zero() is asked of a field that is not a level set; looks at some samples
// then, to tell whether they are labels. Fails with ErrorCode::no_surface if a suggestion is asked for and no value
// separates the finite samples; with `empty_is_fine` it returns a value that gives no surface instead. Fails as
// Context::reserve() and Context::check() do, and with ErrorCode::input if the field's mapped file was truncated.
[[nodiscard]] Result<std::vector<ResolvedIso>> resolve_isos(std::span<const IsoChoice> choices,
                                                            const field::ScalarField& field, bool empty_is_fine,
                                                            const Context& context);

// Returns one iso value for each choice, for particles: the default of `method` if the choice is no number. Fails with
// ErrorCode::usage for percentiles (they depend on how far the field's bricks reach, not on the surface), for labels,
// and for IsoChoice::zero() if the method makes no level set.
[[nodiscard]] Result<std::vector<ResolvedIso>> resolve_isos(std::span<const IsoChoice> choices, points::Method method,
                                                            const std::string& label);

// Returns whether `iso` has the same value as `before`, and at least one of the two was not given as a number.
[[nodiscard]] bool repeats_value(const ResolvedIso& before, const ResolvedIso& iso);
// Returns the iso values without those that repeat an earlier one.
[[nodiscard]] std::vector<ResolvedIso> without_repeats(std::span<const ResolvedIso> isos);

// Returns one iso value for each label, without duplicates; `all` replaces a set of labels
// (IsoChoice::is_label_set()).
[[nodiscard]] std::vector<ResolvedIso> expand_labels(std::span<const ResolvedIso> asked,
                                                     const std::vector<std::int64_t>& all);

}  // namespace isoextract::convert
