// The options of the commands that make plans of them.
#pragma once

#include "cli/options/convert.hpp"
#include "cli/options/measuring.hpp"
#include "cli/options/meshes.hpp"
#include "cli/options/render.hpp"
#include "cli/options/simulate.hpp"
