// Reports the placement of an input.
#pragma once

#include <string>

#include "convert/events.hpp"
#include "convert/placement.hpp"
#include "convert/stage_report.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::convert {

// Returns the unit of the written lengths: the requested one, else the input's if the mesh has unscaled world
// coordinates; "" if the unit is unknown.
[[nodiscard]] std::string unit_of_lengths(const Placement& placement, const field::ScalarField& field);

[[nodiscard]] StageReport report_of_placing(const PlacedField& placed, const field::ScalarField& field);

// Notes that the lengths of a glTF file are in the input file's unit, if that is not the meter. Adds no note if the job
// requests a unit.
void tell_other_unit(const Placement& placement, const field::ScalarField& field, const std::string& label,
                     Events& events);

}  // namespace isoextract::convert
