// The iso values that were asked for, found in the field that was read.
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
  SurfaceId id;          // of all labels iso 0, which stands for none
  std::string found_by;  // "Otsu's threshold (1979) of the histogram"; empty of numbers and labels
};

// "0.3", and of what is no number "p99 (0.3)".
[[nodiscard]] std::string text_of(const ResolvedIso& iso);
// "iso 0.3", "label 5".
[[nodiscard]] std::string surface_text(const IsoChoice& asked);

// None is found in the samples.
[[nodiscard]] bool all_known(std::span<const IsoChoice> choices);

// One a choice, in their order. The samples are looked at only for choices that are no
// numbers and that the kind of the field does not settle. Where no sample is finite, values that need one are 0. Fails
// with ErrorCode::usage where IsoChoice::zero() is asked of a field that is no level set, and with ErrorCode::input,
// ErrorCode::no_surface where a value is to be suggested and none separates the samples; with
// `empty_is_fine` it is then one that gives no surface. As Context::reserve() does, and where the context is cancelled
// or the field is lost.
[[nodiscard]] Result<std::vector<ResolvedIso>> resolve_isos(std::span<const IsoChoice> choices,
                                                            const field::ScalarField& field, bool empty_is_fine,
                                                            const Context& context);

// Of particles, by the method that makes them a field. Percentiles of that would tell how far its bricks reach.
[[nodiscard]] Result<std::vector<ResolvedIso>> resolve_isos(std::span<const IsoChoice> choices, points::Method method,
                                                            const std::string& label);

// Whether the second happens to have the first one's value: one of the two is no number. And all without such ones.
[[nodiscard]] bool is_repeated(const ResolvedIso& before, const ResolvedIso& iso);
[[nodiscard]] std::vector<ResolvedIso> each_once(std::span<const ResolvedIso> isos);

// One a label, each once: `all` of them in place of IsoChoice::all_labels().
[[nodiscard]] std::vector<ResolvedIso> each_label(std::span<const ResolvedIso> asked,
                                                  const std::vector<std::int64_t>& all);

}  // namespace isoextract::convert
