// The options of `simulate` and of its sub-commands.
#pragma once

#include "cli/option_group.hpp"
#include "cli/options.hpp"

namespace isoextract::cli {

// Declares the sub-commands of line.simulate, which is there.
void declare_simulate(CommandLine& line);

// What sub-commands that write a sequence have in common. `number` is an example of -o for messages and help:
// "water_{:04}.nrrd".
void declare_steps(const Group& group, SequenceFlags& flags, std::uint64_t steps, std::uint64_t every);
void declare_sequence_output(const Group& group, SequenceFlags& flags, const std::string& example,
                             const std::string& what);

}  // namespace isoextract::cli
