// Volumes made by formulas, or of random numbers, instead of read from a file: demo:sphere, demo:gyroid?size=256, ...
//
// Each has size^3 float samples over the cube [-1, 1]^3: the outer samples lie on its faces, the spacing is 2 / (size -
// 1). Inside is above the iso value, which is 0 (marschner-lobb: 0.5).
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "base/context.hpp"
#include "base/error.hpp"
#include "field/scalar_field.hpp"

namespace isoextract::field {

struct DemoDescription {
  std::string_view name;     // as in demo:NAME
  std::string_view formula;  // one line of the help
  double iso;                // the recommended iso value
  std::string_view motion;   // one line of the help; empty if the field does not move
};

[[nodiscard]] std::span<const DemoDescription> demo_fields();

inline constexpr std::string_view kDemoPrefix = "demo:";

struct DemoSpec {
  std::string_view name;  // a part of the text that parse_demo_spec() got; the caller keeps that text alive
  int size;               // samples along each axis
  double time = 0;        // in [0, 1): the phase of the motion, whose period is 1
};

// Parses "NAME[?key=value[&key=value...]]", with or without "demo:" before it. Fails with ErrorCode::usage for an
// unknown name or key, for a value out of range, and for the time of a field that does not move.
[[nodiscard]] Result<DemoSpec> parse_demo_spec(std::string_view spec);

// Makes the field `spec`: "demo:NAME[?key=value[&key=value...]]". Keys: size (samples along each axis, 2 to 2048,
// default 64) and time (any finite number, taken modulo 1; default 0). The samples hold the reservation of their
// memory. Fails like parse_demo_spec, with ErrorCode::out_of_memory, and if the context is cancelled.
[[nodiscard]] Result<ScalarField> make_demo_field(std::string_view spec, const Context& context);

}  // namespace isoextract::field
