#include "convert/iso_values.hpp"

#include <algorithm>
#include <optional>
#include <string_view>
#include <unordered_set>
#include <utility>

#include <fmt/format.h>

#include "convert/field_label.hpp"
#include "field/label_map.hpp"
#include "field/percentiles.hpp"
#include "field/statistics.hpp"
#include "volume_io/volume_reader.hpp"

namespace isoextract::convert {
namespace {

constexpr std::string_view kNoSample = "the field has no finite sample";

Result<ResolvedIso> suggested_iso(const IsoChoice& choice, const field::ScalarField& field, bool empty_is_fine,
                                  const Context& context) {
  if (const auto known = field::default_iso(field)) return ResolvedIso{choice, known->iso, known->method};
  const field::FieldStatistics statistics =
      field::measure_statistics(field, &context.progress(), field::WithPercentiles::no);
  field::IsoSuggestion suggestion = field::suggest_iso(field, statistics);
  // Leaves a field without finite samples to the extraction, which reports best why there is no surface.
  if (suggestion.separates || empty_is_fine || statistics.samples == 0) {
    return ResolvedIso{choice, suggestion.iso, std::move(suggestion.method)};
  }
  return tl::unexpected(
      Error{ErrorCode::no_surface,
            fmt::format("{}: expected two groups of sample values, to choose an iso value between them; found {}",
                        field_label(field),
                        statistics.min == statistics.max
                            ? fmt::format("{:.6g} everywhere", statistics.min)
                            : fmt::format("values from {:.6g} to {:.6g}", statistics.min, statistics.max)),
            {"try another input: no iso value separates these samples into two groups",
             {Remedy::use, Setting::empty_policy}}});
}

Hint suggested_by_info() {
  return {Remedy::try_value, Setting::iso, "auto, the value that 'isoextract info' suggests"};
}

Result<ResolvedIso> zero_of(const IsoChoice& choice, const field::ScalarField& field) {
  if (field.kind == field::FieldKind::level_set) return ResolvedIso{choice, 0, "the surface of the level set"};
  const auto kind = field::guess_label_map(field);
  if (!choice.by_default) {
    return fail(ErrorCode::usage,
                fmt::format("{}: the iso value '{}' is for level sets: expected a level set, found a {}",
                            field_label(field), text_of(choice), kind ? word_of(*kind) : "density"),
                kind ? Hint("'isoextract info' prints the command that converts it") : suggested_by_info());
  }
  if (kind) {
    return fail(ErrorCode::usage,
                fmt::format("{}: expected labels or an iso value, found neither; the samples look like a {}",
                            field_label(field), word_of(*kind)),
                *kind == field::LabelMapKind::label_map
                    ? Hint{{Remedy::set, Setting::labels, "all for a surface of each label, or list the labels"},
                           "'isoextract info' prints the command that converts it"}
                    : Hint("'isoextract info' prints the command that converts it"));
  }
  return fail(
      ErrorCode::usage,
      fmt::format("{}: expected an iso value, found none; a density has no default iso value", field_label(field)),
      suggested_by_info());
}

}  // namespace

std::string text_of(const ResolvedIso& iso) {
  if (iso.id.is_file_mesh() || iso.asked.by_default) return iso.id.text();
  return !iso.asked.is_found() ? text_of(iso.asked) : fmt::format("{} ({})", text_of(iso.asked), iso.id.text());
}

std::string surface_text(const IsoChoice& asked) {
  return asked.is_label() || asked.kind == IsoChoice::Kind::file_meshes ? text_of(asked) : "iso " + text_of(asked);
}

std::string place_text(const ResolvedIso& asked) {
  const bool is_stated = !asked.id.is_file_mesh() && !asked.id.is_only_surface() && !asked.asked.by_default;
  return is_stated ? " at " + surface_text(asked.asked) : asked.id.at_text();
}

bool all_known(std::span<const IsoChoice> choices) { return std::ranges::none_of(choices, &IsoChoice::is_found); }

Result<std::vector<ResolvedIso>> resolve_isos(std::span<const IsoChoice> choices, const field::ScalarField& field,
                                              bool empty_is_fine, const Context& context) {
  std::vector<ResolvedIso> isos;
  std::vector<field::Percent> percents;
  for (const IsoChoice& choice : choices) {
    isos.push_back({choice, choice.id, {}});
    if (choice.kind == IsoChoice::Kind::percentile) percents.push_back(choice.percent);
  }
  if (all_known(choices)) return isos;
  auto memory = TRY(context.reserve(field::statistics_bytes(percents.size()), "statistics of the samples"));
  std::optional<std::vector<double>> percentiles;
  if (!percents.empty()) percentiles = field::measure_percentiles(field, percents, &context.progress());
  std::size_t next = 0;
  for (ResolvedIso& iso : isos) {
    if (iso.asked.kind == IsoChoice::Kind::percentile) {
      if (percentiles) iso.id = (*percentiles)[next++];
      iso.found_by =
          percentiles ? fmt::format("percentile {} of the samples", iso.asked.percent.text()) : std::string(kNoSample);
    } else if (iso.asked.kind == IsoChoice::Kind::suggested) {
      iso = TRY(suggested_iso(iso.asked, field, empty_is_fine, context));
    } else if (iso.asked.kind == IsoChoice::Kind::zero) {
      iso = TRY(zero_of(iso.asked, field));
    }
  }
  TRY(context.check());
  TRY(volume_io::check_mapping_intact(field));
  return isos;
}

Result<std::vector<ResolvedIso>> resolve_isos(std::span<const IsoChoice> choices, points::Method method,
                                              const std::string& label) {
  const points::MethodInfo& info = points::method_info(method);
  std::vector<ResolvedIso> isos;
  for (const IsoChoice& choice : choices) {
    if (choice.kind == IsoChoice::Kind::percentile) {
      return fail(
          ErrorCode::usage,
          fmt::format("{}: expected a number or '{}' as the iso value of particles, found '{}': percentiles count the "
                      "samples around the particles, and so depend on the size of the sampled region",
                      label, text_of(IsoChoice::suggested()), text_of(choice)),
          fmt::format("the default iso value of {} is {}", info.title, info.iso));
    }
    if (choice.is_label()) {
      return fail(ErrorCode::usage,
                  fmt::format("{}: expected a label map (a volume of integers), found particles", label));
    }
    if (choice.kind == IsoChoice::Kind::zero && info.kind != field::FieldKind::level_set) {
      if (choice.by_default) {
        return fail(ErrorCode::usage, fmt::format("{}: expected an iso value, found none", label), suggested_by_info());
      }
      return fail(ErrorCode::usage,
                  fmt::format("{}: the iso value '{}' is for level sets: expected a level set, found a density ({})",
                              label, text_of(choice), info.title),
                  suggested_by_info());
    }
    if (choice.is_number()) {
      isos.push_back({choice, choice.id, {}});
    } else {
      isos.push_back({choice, info.iso, fmt::format("the default of {}", info.title)});
    }
  }
  return isos;
}

bool repeats_value(const ResolvedIso& before, const ResolvedIso& iso) {
  return before.id == iso.id && !(before.asked.is_number() && iso.asked.is_number());
}

std::vector<ResolvedIso> expand_labels(std::span<const ResolvedIso> asked, const std::vector<std::int64_t>& all) {
  std::vector<ResolvedIso> labels;
  std::unordered_set<std::int64_t> found;
  const auto add = [&](std::int64_t label) {
    if (found.insert(label).second) labels.push_back({IsoChoice::label(label), Label{label}, {}});
  };
  for (const ResolvedIso& iso : asked) {
    if (iso.id.is_label()) add(iso.id.label());
    if (iso.asked.is_label_set()) std::ranges::for_each(all, add);
  }
  return labels;
}

std::vector<ResolvedIso> without_repeats(std::span<const ResolvedIso> isos) {
  std::vector<ResolvedIso> once;
  for (const ResolvedIso& iso : isos) {
    const auto repeats = [&](const ResolvedIso& before) { return repeats_value(before, iso); };
    if (std::ranges::none_of(once, repeats)) once.push_back(iso);
  }
  return once;
}

}  // namespace isoextract::convert
