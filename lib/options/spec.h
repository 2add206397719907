// Descriptions of the commands and options of a program. For the sources of this folder only.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "options/program.h"

namespace tessera::options {

struct OptionSpec {
  std::vector<std::string> names;  // "-o", "--output"; of an argument its only one: "SCENE"
  std::string value_name;          // empty: a flag
  std::string description;
  std::string group;
  std::string shown_default;
  std::string environment;          // a variable
  std::vector<std::string> former;  // names of older versions
  bool hidden = false;              // a setting, which --help leaves out
  bool sets = false;                // --set itself
  bool required = false;
  bool list = false;
  bool commas = false;
  std::optional<std::pair<double, double>> range;
  std::vector<std::string> choices;
  std::vector<Choice> listed_choices;  // --help lists them below the description
  std::vector<std::string> completions;
  std::vector<const OptionSpec*> excludes, needs;
  std::vector<std::function<std::string(const std::string&)>> checks;
  std::function<absl::Status(const std::string&)> take;  // one value
  std::function<void()> clear;                           // lists only: drops the default
  std::function<std::string()> show;                     // the value as text
  std::vector<std::string> given = {};                   // values as the command line has them; "" for a flag

  bool is_argument() const { return !names.front().starts_with('-'); }
  bool is_flag() const { return value_name.empty(); }
  /// Name for people: the longest of its names.
  const std::string& name() const { return names.back(); }
  bool is_called(std::string_view name) const;
  /// "--spp", and "mlt.step" of a setting.
  std::string shown_name() const;
};

struct CommandSpec {
  std::string path;  // "tessera render"
  std::string description;
  std::string group;
  std::vector<std::string> examples;
  std::vector<std::unique_ptr<OptionSpec>> options;
  std::string current_group = "Options";
  std::function<int()> action;
  std::vector<std::string> notices;  // one for each name that is given and was replaced

  OptionSpec* find(std::string_view name) const;
  /// The option that --set gives by this name; null where there is none.
  OptionSpec* find_setting(std::string name) const;
};

/// Puts what `words` say into the variables. InvalidArgument says what is wrong with them.
absl::Status parse_words(CommandSpec& command, const std::vector<std::string>& words);

/// Puts the value of a file into its variable. InvalidArgument, with its place, says what is wrong with it.
absl::Status take_default(CommandSpec& command, const FileValue& value);

/// Words that an option's value is commonly one of; empty: any text, or a file's name.
std::vector<std::string> value_words(const CommandSpec& command, const OptionSpec& option);

/// "-o, --output FILE", and "mlt.step=X" of a setting.
std::string left_of(const OptionSpec& option);
/// The words of --help on it, its words, range and default among that.
std::string right_of(const OptionSpec& option);

/// "tessera render SCENE -o FILE [options]".
std::string usage_of(const CommandSpec& command);

/// Text of --help, at most 80 columns wide.
std::string help_of(const CommandSpec& command);

/// `text` in lines of at most 80 columns; each but the first begins with `indent` spaces, and the first has
/// room for what stands before it.
std::string wrapped(std::string_view text, std::size_t indent);

/// Two columns, the second wrapped and from that column on.
std::string help_line(const std::string& left, const std::string& right, std::size_t column);

}  // namespace tessera::options
