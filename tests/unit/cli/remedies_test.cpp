#include "cli/remedies.hpp"

#include <algorithm>
#include <regex>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "cli/command.hpp"
#include "cli/commands.hpp"

namespace isoextract::cli {
namespace {

std::vector<std::string> options_of_program() {
  const auto program = make_program();
  std::vector<std::string> names;
  for (const Command* command : all_commands(*program)) {
    for (const Option* option : command->options().options()) names.push_back(option->name());
  }
  return names;
}

// Returns the names of options in a text.
std::vector<std::string> options_in(const std::string& text) {
  static const std::regex kName("--[a-z-]+");
  return {std::sregex_token_iterator(text.begin(), text.end(), kName), {}};
}

TEST(Remedies, NameExistingOptionsForEverySetting) {
  const std::vector<std::string> known = options_of_program();
  int setting = 1;
  for (; !hint_text(Hint(Remedy::use, Setting{setting})).empty(); ++setting) {
    for (int remedy = 1; remedy <= static_cast<int>(Remedy::report); ++remedy) {
      const std::string words = hint_text(Hint(Remedy{remedy}, Setting{setting}, "text"));
      EXPECT_FALSE(words.empty()) << remedy << " " << setting;
      EXPECT_EQ(words.find("  "), std::string::npos) << words;
      for (const std::string& name : options_in(words)) {
        EXPECT_NE(std::ranges::find(known, name), known.end()) << words;
      }
    }
  }
  EXPECT_EQ(setting, static_cast<int>(Setting::devices) + 1) << "a setting has no words, or the last one is new";
}

TEST(Remedies, BecomeOneClausePerStep) {
  const auto words = [](Remedy remedy, Setting setting, const char* text = "") {
    return hint_text(Hint(remedy, setting, text));
  };
  EXPECT_EQ(words(Remedy::raise, Setting::memory_limit),
            "give a larger --memory-limit SIZE if the machine has the memory");
  EXPECT_EQ(words(Remedy::lower, Setting::cell_size), "give a smaller --cell-size C");
  EXPECT_EQ(words(Remedy::give, Setting::spacing_and_origin),
            "give --spacing SX,SY,SZ and --origin X,Y,Z to place the volume");
  EXPECT_EQ(words(Remedy::give, Setting::radius, "0.5 is usual"),
            "give --radius R, in the units of the file: 0.5 is usual");
  EXPECT_EQ(words(Remedy::choose, Setting::grid, "\n  a\n  b"), "choose one of them with --grid NAME\n  a\n  b");
  EXPECT_EQ(words(Remedy::choose, Setting::volume, "from 0 to 4"), "choose one of them with --volume K, K from 0 to 4");
  EXPECT_EQ(words(Remedy::choose, Setting::volume), "choose one of them with --volume K");
  EXPECT_EQ(words(Remedy::choose, Setting::attribute_volume, "from 0 to 2"),
            "choose one of them with :volume=K behind NAME=FILE, K from 0 to 2");
  EXPECT_EQ(words(Remedy::change, Setting::output_name), "choose another name after -o");
  EXPECT_EQ(words(Remedy::leave_out, Setting::attribute_volume, "there is one"), "leave :volume= out: there is one");
  EXPECT_EQ(words(Remedy::leave_out, Setting::grid), "leave --grid out");
  EXPECT_EQ(words(Remedy::leave_out, Setting::scale), "leave out --spacing, --scale, --unit, --to-unit and --space");
  EXPECT_EQ(words(Remedy::use, Setting::position),
            "use --center, --origin X,Y,Z or --space index to place the volume nearer to the origin");
  EXPECT_EQ(words(Remedy::set, Setting::attribute_component, "length"), "use :component=length");
  EXPECT_EQ(words(Remedy::try_value, Setting::iso, "0.3 (midway)"), "try --iso 0.3 (midway)");
  EXPECT_EQ(words(Remedy::check, Setting::clip, "a reason"), "check --clip NX,NY,NZ,D: a reason");
  EXPECT_EQ(words(Remedy::check, Setting::raw_layout), "check --dims NX,NY,NZ and --dtype TYPE");
  EXPECT_EQ(words(Remedy::see, Setting::devices), "see 'isoextract devices'");
  EXPECT_EQ(words(Remedy::report, Setting::devices), "please report it and include the output of 'isoextract devices'");
  EXPECT_EQ(hint_text(Hint{"try again", {Remedy::use, Setting::cpu_backend}}),
            "try again; use --backend cpu, which needs no GPU");
  EXPECT_EQ(hint_text(Hint()), "");
  EXPECT_EQ(hint_text(Hint("")), "");
}

TEST(Remedies, OmitOptionsThatTheCommandLacks) {
  set_options_of_hints({"--origin", "--backend"});
  const Hint hint{{Remedy::use, Setting::empty_policy},
                  {Remedy::use, Setting::cpu_backend},
                  {Remedy::give, Setting::spacing_and_origin},
                  "use --words as they are"};
  EXPECT_EQ(hint_text(hint),
            "use --backend cpu, which needs no GPU; give --origin X,Y,Z to place the volume; use --words as they are");
  EXPECT_EQ(hint_text(Hint(Remedy::raise, Setting::memory_limit)), "");
  set_options_of_hints(options_of_program());
}

}  // namespace
}  // namespace isoextract::cli
