// Includes all headers in cli/options: the options of the commands that check a plan before they work
// (planned_command.hpp).
#pragma once

#include "cli/options/convert.hpp"
#include "cli/options/measuring.hpp"
#include "cli/options/meshes.hpp"
#include "cli/options/render.hpp"
#include "cli/options/simulate.hpp"
