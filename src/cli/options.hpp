// Includes the options of all commands that have plans.
#pragma once

#include "cli/options/convert.hpp"
#include "cli/options/measuring.hpp"
#include "cli/options/meshes.hpp"
#include "cli/options/render.hpp"
#include "cli/options/simulate.hpp"
