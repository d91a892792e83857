#include "convert/detail/place_report.hpp"

#include <optional>

#include <fmt/format.h>

#include "convert/field_label.hpp"

namespace isoextract::convert {

std::string unit_of_lengths(const Placement& placement, const field::ScalarField& field) {
  if (!placement.to_unit.empty()) return placement.to_unit;
  const bool as_in_file = placement.space == Space::world && placement.unit.empty() && placement.scale == 1;
  const auto unit = as_in_file ? find_length_unit(field.length_unit) : std::nullopt;
  return unit ? std::string(unit->name) : placement.unit;
}

StageReport report_of_placing(const PlacedField& placed, const field::ScalarField& field) {
  const Placement& placement = placed.placement.placement;
  StageReport report = report_on(StageName::place, field_label(field));
  report.entries.push_back(
      {{Key::output_from_index, Value(placed.output_from_index)},
       {Key::region, placed.region ? Value(*placed.region) : Value()},
       {Key::placement, Figures{{Key::unit, placement.unit.empty() ? Value() : Value(placement.unit)},
                                {Key::to_unit, placement.to_unit.empty() ? Value() : Value(placement.to_unit)},
                                {Key::scale, placement.scale},
                                {Key::moved_by, Value(placed.placement.moved_by)}}},
       Figure::of_tables(Key::unit_of_lengths, unit_of_lengths(placement, field))});
  return report;
}

void tell_other_unit(const Placement& placement, const field::ScalarField& field, const std::string& label,
                     Events& events) {
  const std::string unit = placement.unit.empty() ? unit_of_lengths(placement, field) : std::string();
  if (unit.empty() || unit == meter().name) return;
  events.note({NoteId::length_unit,
               fmt::format("{}: the coordinates are in {}, the unit of the file; glTF prescribes meters, so other "
                           "programs read them as meters",
                           label, unit)});
}

}  // namespace isoextract::convert
