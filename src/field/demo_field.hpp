// Fields by formula, so that everything can be tried without a file: demo:sphere, demo:gyroid?size=256, ...
//
// All live on size^3 float samples over the cube [-1, 1]^3 (sample centres on the faces, spacing 2 / (size - 1)), and
// are positive inside, so that iso 0 is their surface (marschner-lobb: 0.5).
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
  std::string_view formula;  // one line for the help
  double iso;                // its natural iso value
  std::string_view motion;   // one line for the help; empty where it does not move
};

[[nodiscard]] std::span<const DemoDescription> demo_fields();

inline constexpr std::string_view kDemoPrefix = "demo:";

struct DemoSpec {
  std::string_view name;
  int size;         // samples along each axis
  double time = 0;  // from 0 to below 1; fields that move come back to where they were after a time of 1
};

// Fails with ErrorCode::usage for an unknown name or key, and for the time of a field that does not move.
[[nodiscard]] Result<DemoSpec> parse_demo_spec(std::string_view spec);

// `spec` is "demo:NAME[?key=value[&key=value...]]", keys: size (samples along each axis, 2..2048, default 64), and
// time (any number, of which whole periods of 1 are dropped; default 0). Fails
// like parse_demo_spec, and with ErrorCode::input where the samples need more memory than is left. The samples keep
// theirs reserved.
[[nodiscard]] Result<ScalarField> make_demo_field(std::string_view spec, const Context& context);

}  // namespace isoextract::field
