// Includes the options of all commands that make a plan before they work (planned_command.hpp), and so all headers in
// cli/options.
#pragma once

#include "cli/options/convert.hpp"
#include "cli/options/measuring.hpp"
#include "cli/options/meshes.hpp"
#include "cli/options/render.hpp"
#include "cli/options/simulate.hpp"
