// Commands that turn their options into a plan and check it completely before any work.
#pragma once

#include <string>
#include <type_traits>
#include <vector>

#include "cli/command.hpp"
#include "cli/messages.hpp"
#include "cli/options/convert.hpp"
#include "cli/plan.hpp"
#include "cli/threads.hpp"
#include "plugin_host/plugin_reader.hpp"

namespace isoextract::cli {

inline void apply_in_process(const InputFlags& input) {
  if (input.in_process) plugin_host::read_in_process();
}

// A command in two steps. plan_of(flags) returns the plan as a Result. run_plan(plan, messages) returns Result<int>
// with the exit code, or Result<void>, which stands for kDone. Threads are limited between the two steps.
template <class Flags, auto plan_of, auto run_plan>
class PlannedCommand : public CommandOf<Flags> {
 public:
  using CommandOf<Flags>::CommandOf;

  Result<int> run(const std::vector<std::string>& /*arguments*/) override {
    const Flags& flags = this->flags();
    if constexpr (requires { flags.conversion; }) {
      apply_in_process(flags.conversion.input);
      return run_as_planned(flags, flags.conversion.run);
    } else {
      if constexpr (requires { flags.input; }) apply_in_process(flags.input);
      return run_as_planned(flags, flags.run);
    }
  }

 private:
  static Result<int> run_as_planned(const Flags& flags, const RunFlags& asked) {
    const MessageChoice shown = TRY(plan_messages(asked));
    const auto plan = TRY(plan_of(flags));
    TRY(limit_threads(asked.threads));
    if constexpr (std::is_same_v<decltype(run_plan(plan, Messages(shown))), Result<int>>) {
      return run_plan(plan, Messages(shown));
    } else {
      TRY(run_plan(plan, Messages(shown)));
      return kDone;
    }
  }
};

}  // namespace isoextract::cli
