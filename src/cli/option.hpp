// Declares command-line options and stores the texts given for them. Every option is a member of a command's struct:
//
//   struct RunFlags : OptionSet {
//     Value<int> threads{*this, "--threads", "N", parse_thread_count, "Threads to use (default: all)."};
//     Flag quiet{*this, "-q,--quiet", "Say nothing but errors."};
//   };
//
// The parser, help, man page, completions, --config and the refusal of options without effect read these declarations.
// A metavar with '|' lists words ("mc|mt"), which shells offer, and placeholders with capitals ("H|none"), which they
// do not. Shells complete the placeholders FILE, PATH, INPUT and MESH with paths.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/enum_words.hpp"
#include "base/error.hpp"

namespace isoextract::cli {

// Groups of options; the help lists the options of a group under its heading.
enum class OptionGroup {
  input,
  scene,
  simulation,
  particles,
  frames,
  surface,
  pieces,
  vertices,
  placement,
  output,
  run
};
constexpr auto words_of(OptionGroup /*type*/) {
  return std::array{Word{OptionGroup::input, "Input"},
                    Word{OptionGroup::scene, "Scene"},
                    Word{OptionGroup::simulation, "Simulation"},
                    Word{OptionGroup::particles, "Particles"},
                    Word{OptionGroup::frames, "Frames"},
                    Word{OptionGroup::surface, "Surface"},
                    Word{OptionGroup::pieces, "Pieces"},
                    Word{OptionGroup::vertices, "Vertices"},
                    Word{OptionGroup::placement, "Placement"},
                    Word{OptionGroup::output, "Output"},
                    Word{OptionGroup::run, "Run"}};
}

// Conditions under which an option has an effect. The checks of a command find out which conditions are not met, and
// reject the options that depend on them by OptionSet::refuse().
enum class About : std::uint32_t {
  anything = 0,
  surface = 1U << 0,        // not if the output is the field itself or the particles
  mesh_file = 1U << 1,      // not if the output is a picture
  picture = 1U << 2,        // only if the command draws pictures: as output, or for --html or --contact-sheet
  edit = 1U << 3,           // only if the command edits surfaces: the option changes a surface after its extraction
  world = 1U << 4,          // not with voxel coordinates (--space index)
  raw_file = 1U << 5,       // only with the samples of a raw file (--dims)
  gpu = 1U << 6,            // not with --backend cpu, except with --verify
  weights = 1U << 7,        // only with --particles weight
  extraction = 1U << 8,     // only if the command extracts a surface
  drawn_surface = 1U << 9,  // only if `render` draws surfaces of the volume (--iso or --labels)
  drawn_volume = 1U << 10,  // only if `render` draws the volume itself (not with --tf none, nor with --labels alone)
  voxel_faces = 1U << 11,   // only with --method voxels
};
constexpr About operator|(About a, About b) {
  return static_cast<About>(static_cast<std::uint32_t>(a) | static_cast<std::uint32_t>(b));
}
constexpr About operator&(About a, About b) {
  return static_cast<About>(static_cast<std::uint32_t>(a) & static_cast<std::uint32_t>(b));
}

// Amount of text in a command's help.
enum class HelpDetail {
  summaries,  // one line per option: --help
  all,        // the whole text of each option, and examples of the default command: --help-all
};

class Option;
class OptionSet;

// The OptionSet and the help group of an option. Without a set, the option belongs to no command and gets no value.
struct Place {
  OptionSet* set = nullptr;
  OptionGroup group = OptionGroup::run;
  bool everyday = false;  // the overview of the help shows this option
};
[[nodiscard]] inline Place everyday(Place place) {
  place.everyday = true;
  return place;
}

// Base class of the options structs. Stores each option as its byte offset from this object, so that a copied struct
// refers to its own options. Copy the whole struct, never the base alone.
class OptionSet {
 public:
  OptionSet() = default;
  // Makes a group of options inside the struct `whole`, which gets the same options.
  OptionSet(OptionSet& whole, OptionGroup group) : OptionSet(&whole, group) {}

  // Returns the Place of an option in this struct's group; in(group) returns one in another group.
  operator Place() { return {this, group_}; }  // NOLINT(google-explicit-constructor): *this registers an option
  [[nodiscard]] Place in(OptionGroup group) { return {this, group}; }

  // Returns the options, sorted by group. Groups and the options in them are in the order of declaration, but the group
  // `run` comes last.
  [[nodiscard]] std::vector<Option*> options();
  [[nodiscard]] std::vector<const Option*> options() const;
  [[nodiscard]] std::vector<const Option*> in_group(OptionGroup group) const;
  // Returns the option with this name, such as "-o" or "--output", or nullptr. Positional options have no such name.
  [[nodiscard]] const Option* find(std::string_view name) const;
  // Returns the first positional option, or nullptr.
  [[nodiscard]] const Option* operand() const;
  [[nodiscard]] bool any_set() const;

  // Returns the options that have a value and all conditions of `what`.
  [[nodiscard]] std::vector<const Option*> set_about(About what) const;
  // Fails with ErrorCode::usage if set_about(what) has an option. The name of the first one replaces {} in both texts.
  [[nodiscard]] Result<void> refuse(About what, std::string_view why, std::string_view hint = "") const;

 protected:
  // Adds the options to `whole` as well, unless it is null.
  OptionSet(OptionSet* whole, OptionGroup group) : whole_(whole), group_(group) {}
  OptionSet(const OptionSet&) = default;
  OptionSet& operator=(const OptionSet&) = default;
  ~OptionSet() = default;

 private:
  friend class Option;
  void add(const Option& option);
  [[nodiscard]] const Option& at(std::ptrdiff_t distance) const;

  OptionSet* whole_ = nullptr;  // also gets the options; used only during construction
  OptionGroup group_ = OptionGroup::run;
  std::vector<std::ptrdiff_t> options_;
};

// A word that an option accepts as its value, and the C++ value of the word.
template <class T>
struct Choice {
  std::string name;
  T value;
};

// Value of an option that the user gives without a value, such as --draco.
struct IfLeftOut {
  std::string text;
};

// Names, value placeholder, help text and conditions of an option.
struct OptionRow {
  OptionGroup group = OptionGroup::run;
  std::vector<std::string> names;  // with their dashes, the long one last; one without dashes is positional
  std::string metavar;             // empty: takes no value
  std::string help;                // the first sentence is the summary: at most kSummaryWidth characters
  About about = About::anything;
  std::size_t most = 1;                 // largest number of values
  std::optional<std::string> left_out;  // value if the user gives the option alone; unset: a value is required
  bool everyday = false;
};

class Option {
 public:
  virtual ~Option() = default;

  [[nodiscard]] const OptionRow& row() const { return *row_; }
  [[nodiscard]] const std::string& name() const { return row_->names.back(); }  // "--output"
  [[nodiscard]] std::string key() const { return name().substr(2); }            // "output", the key in a --config file
  [[nodiscard]] std::string spelling() const;                                   // "-o, --output FILE"
  // Returns the words among the parts of a metavar with '|', without placeholders.
  [[nodiscard]] virtual std::vector<std::string> choices() const;
  [[nodiscard]] bool is_positional() const { return !row_->names.back().starts_with('-'); }
  [[nodiscard]] bool takes_file() const;
  [[nodiscard]] bool takes_value() const { return !row_->metavar.empty(); }
  [[nodiscard]] bool is_repeatable() const { return row_->most > 1; }
  [[nodiscard]] bool is_about(About what) const { return (row_->about & what) == what; }

  // Returns the unparsed texts of the command line or the --config file. take() parses them; its errors begin with the
  // option's name.
  [[nodiscard]] const std::vector<std::string>& texts() const { return texts_; }
  void add_text(std::string text) { texts_.push_back(std::move(text)); }
  [[nodiscard]] virtual Result<void> take() = 0;

  // Returns the help that the option shows if the user gives it; nullopt except for HelpFlag.
  [[nodiscard]] virtual std::optional<HelpDetail> help() const { return std::nullopt; }

  // Returns whether the option has a value, from the user or assigned by the program.
  [[nodiscard]] virtual bool is_set() const = 0;

 protected:
  Option(const Place& place, OptionRow row);
  Option(const Option&) = default;
  Option(Option&&) = default;
  Option& operator=(const Option&) = default;
  Option& operator=(Option&&) = default;

  [[nodiscard]] tl::unexpected<Error> refuse(Error why) const;

 private:
  std::shared_ptr<const OptionRow> row_;
  std::vector<std::string> texts_;
};

// Returns {"a", "b"} for "a,b".
[[nodiscard]] std::vector<std::string> split_names(std::string_view names);
// Returns "mc|mt" for {"mc", "mt"}.
[[nodiscard]] std::string metavar_of(const std::vector<std::string>& words);
// Returns the index of `text` in `words`. Otherwise fails with ErrorCode::usage; the hint names a similar word, if any.
[[nodiscard]] Result<std::size_t> index_among(const std::vector<std::string>& words, std::string_view text);

template <class T>
std::vector<std::string> words_of_choices(const std::vector<Choice<T>>& choices) {
  std::vector<std::string> words;
  for (const Choice<T>& choice : choices) words.push_back(choice.name);
  return words;
}

template <class E>
std::vector<Choice<E>> choices_of_words() {
  std::vector<Choice<E>> choices;
  for (const Word<E>& entry : words_of(E{})) choices.push_back({std::string(entry.word), entry.value});
  return choices;
}

template <class E>
concept HasWords = requires {
  words_of(E{});
};

template <class T>
using Parse = std::function<Result<T>(std::string_view)>;

// Fails with ErrorCode::usage if both are set: "--scale and --unit exclude each other: WHY".
[[nodiscard]] Result<void> refuse_both(const Option& a, const Option& b, std::string_view why = "", Hint hint = {});

// An option with one value.
template <class T>
class Value : public Option, public std::optional<T> {
 public:
  Value(const Place& place, std::string_view names, std::string metavar, Parse<T> parse, std::string help,
        About about = About::anything, std::optional<IfLeftOut> left_out = std::nullopt)
      : Option(place, {place.group, split_names(names), std::move(metavar), std::move(help), about, 1,
                       left_out ? std::optional(left_out->text) : std::nullopt}),
        parse_(std::move(parse)) {}

  // Takes the words of an enum as values.
  Value(const Place& place, std::string_view names, std::string help,
        About about = About::anything) requires HasWords<T>
      : Value(place, names, choices_of_words<T>(), std::move(help), about) {}

  Value(const Place& place, std::string_view names, const std::vector<Choice<T>>& choices, std::string help,
        About about = About::anything, std::optional<IfLeftOut> left_out = std::nullopt)
      : Value(
            place, names, metavar_of(words_of_choices(choices)),
            [choices](std::string_view text) -> Result<T> {
              const std::size_t at = TRY(index_among(words_of_choices(choices), text));
              return choices[at].value;
            },
            std::move(help), about, std::move(left_out)) {}

  using std::optional<T>::operator=;

  [[nodiscard]] bool is_set() const override { return this->has_value(); }

  [[nodiscard]] Result<void> take() override {
    for (const std::string& text : texts()) {
      auto value = parse_(text);
      if (!value) return refuse(std::move(value.error()));
      *this = std::move(*value);
    }
    return {};
  }

 private:
  Parse<T> parse_;
};

// An option that the user may give several times.
template <class T>
class Values : public Option, public std::vector<T> {
 public:
  Values(const Place& place, std::string_view names, std::string metavar, Parse<T> parse, std::string help,
         About about = About::anything, std::size_t most = SIZE_MAX)
      : Option(place, {place.group, split_names(names), std::move(metavar), std::move(help), about, most, {}}),
        parse_(std::move(parse)) {}

  using std::vector<T>::operator=;

  [[nodiscard]] bool is_set() const override { return !this->empty(); }

  [[nodiscard]] Result<void> take() override {
    this->clear();
    for (const std::string& text : texts()) {
      auto value = parse_(text);
      if (!value) return refuse(std::move(value.error()));
      this->push_back(std::move(*value));
    }
    return {};
  }

 private:
  Parse<T> parse_;
};

// An option without a value.
class Flag : public Option {
 public:
  Flag(const Place& place, std::string_view names, std::string help, About about = About::anything)
      : Option(place, {place.group, split_names(names), "", std::move(help), about, 1, {}}) {}

  Flag& operator=(bool on) {
    on_ = on;
    return *this;
  }
  operator bool() const { return on_; }  // NOLINT(google-explicit-constructor): reads as a bool

  [[nodiscard]] bool is_set() const override { return on_; }
  [[nodiscard]] Result<void> take() override {
    on_ = on_ || !texts().empty();
    return {};
  }

 private:
  bool on_ = false;
};

// A flag that prints help instead of running the command.
class HelpFlag : public Flag {
 public:
  HelpFlag(const Place& place, std::string_view names, HelpDetail detail, std::string help)
      : Flag(place, names, std::move(help)), detail_(detail) {}

  [[nodiscard]] std::optional<HelpDetail> help() const override { return detail_; }

 private:
  HelpDetail detail_;
};

}  // namespace isoextract::cli
