// From words to values: CLI11 takes the line apart, and is included here and nowhere else.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "base/nearest_name.h"
#include "options/spec.h"

namespace tessera::options {
namespace {

/// Names the option in what is said about `value`: its variable of the environment when the value is from
/// there.
std::string source_of(const OptionSpec& spec, const std::string& value) {
  const char* const variable = spec.environment.empty() ? nullptr : std::getenv(spec.environment.c_str());
  return variable != nullptr && value == variable ? "$" + spec.environment : spec.shown_name();
}

std::string needs_value(const OptionSpec& spec, const std::string& called) {
  return absl::StrCat(called, " needs a value: ", called, " ", spec.value_name);
}

/// Converts one value. The message is without the option's name.
absl::Status take_one(OptionSpec& spec, const std::string& value) {
  if (!spec.choices.empty() && std::ranges::find(spec.choices, value) == spec.choices.end()) {
    return absl::InvalidArgumentError(
        absl::StrCat("there is no '", value, "'; there is: ", absl::StrJoin(spec.choices, ", ")));
  }
  for (const auto& check : spec.checks) {
    if (const std::string fault = check(value); !fault.empty()) return absl::InvalidArgumentError(fault);
  }
  return spec.take(value);
}

/// Converts all values of an option or an argument. Throws ValidationError, as CLI11 expects of what it calls
/// back.
void take(OptionSpec& spec, const std::vector<std::string>& values) {
  if (!spec.list && (values.size() > 1 || !spec.given.empty()))
    throw CLI::ValidationError(spec.shown_name() + " is given twice");
  if (spec.list && spec.given.empty()) spec.clear();
  spec.given.insert(spec.given.end(), values.begin(), values.end());
  for (const std::string& value : values) {
    // CLI11 takes the option that follows for the value.
    if (!spec.is_argument() && value.starts_with("--"))
      throw CLI::ValidationError(needs_value(spec, spec.name()));
    const std::vector<std::string> parts =
        spec.commas ? std::vector<std::string>(absl::StrSplit(value, ',')) : std::vector{value};
    for (const std::string& part : parts) {
      if (absl::Status status = take_one(spec, part); !status.ok()) {
        throw CLI::ValidationError(source_of(spec, value), std::string{status.message()});
      }
    }
  }
}

std::string name_of(const std::string& word) { return word.substr(0, word.find('=')); }

std::vector<std::string> names_of_settings(const CommandSpec& command) {
  std::vector<std::string> names;
  for (const auto& spec : command.options) {
    if (!spec->is_argument() && !spec->sets) names.push_back(spec->name().substr(2));
  }
  return names;
}

/// Gives the option that `text`, "NAME=VALUE", names its value; a flag has none, or "on" or "off".
void take_setting(CommandSpec& command, const std::string& text) {
  const std::string name = name_of(text);
  OptionSpec* const spec = command.find_setting(name);
  if (spec == nullptr) {
    throw CLI::ValidationError(absl::StrCat("there is no setting '", name, "'",
                                            base::did_you_mean(name, names_of_settings(command))));
  }
  const bool has_value = name.size() < text.size();
  const std::string value = has_value ? text.substr(name.size() + 1) : "";
  if (!spec->is_flag() && !has_value)
    throw CLI::ValidationError(
        absl::StrCat("--set ", name, " needs a value: --set ", name, "=", spec->value_name));
  if (!spec->is_flag()) return take(*spec, {value});
  if (has_value && value != "on" && value != "off")
    throw CLI::ValidationError(absl::StrCat(spec->shown_name(), " is on or off, not '", value, "'"));
  take(*spec, {value});
}

/// A command line as CLI11 knows it: the options, and all arguments as one list, which it could not share out
/// among arguments that follow a list.
class Parser {
 public:
  Parser(CommandSpec& command, const std::vector<std::string>& words) : command_(command), words_(words) {
    app_.set_help_flag();
    app_.allow_extras();
    const auto share_out = [this](const std::vector<std::string>& arguments) { take_arguments(arguments); };
    arguments_ = app_.add_option_function<std::vector<std::string>>("ARGUMENTS", share_out);
    for (const auto& spec : command.options) {
      spec->given.clear();
      if (!spec->is_argument()) add(*spec);
    }
    command.notices.clear();
  }

  absl::Status run() {
    std::string fault;
    try {
      app_.parse(reversed_words());
      if (arguments_->empty()) take_arguments({});
      fault = mismatch_of_options();
    } catch (const CLI::RequiredError& error) {
      // A missing argument is told before a missing option.
      const OptionSpec* const argument = arguments_->empty() ? required_argument() : nullptr;
      fault = argument != nullptr ? argument->name() + " is required" : error.what();
    } catch (const CLI::ArgumentMismatch& error) {
      fault = mismatch(error.what());
    } catch (const CLI::ParseError& error) {
      fault = error.what();
    }
    // A misspelt option comes first: others may be missing because of it.
    if (app_.remaining_size() > 0) {
      const std::string name = name_of(app_.remaining().front());
      fault = absl::StrCat("there is no option '", name, "'", base::did_you_mean(name, names_of_options()));
    }
    if (fault.empty()) note_former_names();
    return fault.empty() ? absl::OkStatus() : absl::InvalidArgumentError(fault);
  }

 private:
  void add(OptionSpec& spec) {
    std::vector<std::string> all = spec.names;
    all.insert(all.end(), spec.former.begin(), spec.former.end());
    const std::string names = absl::StrJoin(all, ",");
    if (spec.is_flag()) {
      app_.add_flag_function(names, [&spec](std::int64_t) { take(spec, {""}); })->disable_flag_override();
      return;
    }
    const auto take_all = [this, &spec](const std::vector<std::string>& values) {
      if (!spec.sets) return take(spec, values);
      for (const std::string& value : values) take_setting(command_, value);
    };
    app_.add_option_function<std::vector<std::string>>(names, take_all)
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
        ->allow_extra_args(false)
        ->required(spec.required)
        ->envname(spec.environment);
  }

  /// Options of which one is given without one that it needs, or with one that it excludes; empty: none.
  std::string mismatch_of_options() const {
    for (const auto& spec : command_.options) {
      if (spec->given.empty()) continue;
      for (const OptionSpec* other : spec->excludes) {
        if (!other->given.empty()) return absl::StrCat(spec->shown_name(), " excludes ", other->shown_name());
      }
      for (const OptionSpec* other : spec->needs) {
        if (other->given.empty()) return absl::StrCat(spec->shown_name(), " requires ", other->shown_name());
      }
    }
    return "";
  }

  void note_former_names() {
    for (const std::string& word : words_) {
      const std::string name = name_of(word);
      const OptionSpec* const spec = command_.find(name);
      if (spec == nullptr || std::ranges::find(spec->former, name) == spec->former.end()) continue;
      const std::string value = spec->is_flag() ? "" : "=" + spec->value_name;
      command_.notices.push_back(
          absl::StrCat(name, " is --set ", spec->name().substr(2), value, " from now on"));
    }
  }

  /// CLI11 reads from the end. An empty value, "--name=", is a word of its own, or CLI11 would take the next
  /// one.
  std::vector<std::string> reversed_words() const {
    std::vector<std::string> reversed;
    for (const std::string& word : words_) {
      const OptionSpec* const spec = word.ends_with('=') ? command_.find(name_of(word)) : nullptr;
      const bool is_empty = spec != nullptr && !spec->is_flag();
      reversed.push_back(is_empty ? name_of(word) : word);
      if (is_empty) reversed.emplace_back();
    }
    std::ranges::reverse(reversed);
    return reversed;
  }

  /// Says where values and options do not match: CLI11 stopped at the last word, which has none, or at a flag
  /// with one.
  std::string mismatch(const std::string& otherwise) const {
    const OptionSpec* const last = command_.find(words_.back());
    if (last != nullptr && !last->is_flag()) return needs_value(*last, words_.back());
    for (const std::string& word : words_) {
      const OptionSpec* const spec = command_.find(name_of(word));
      if (spec != nullptr && spec->is_flag() && word != name_of(word))
        return name_of(word) + " takes no value";
    }
    return otherwise;
  }

  /// Gives every argument its words in the order of definition; a list among them takes what the others
  /// leave.
  void take_arguments(const std::vector<std::string>& arguments) {
    std::vector<OptionSpec*> specs;
    for (const auto& spec : command_.options) {
      if (spec->is_argument()) specs.push_back(spec.get());
    }
    const bool has_list = std::ranges::any_of(specs, [](const OptionSpec* spec) { return spec->list; });
    const std::size_t alone = specs.size() - (has_list ? 1 : 0);
    const std::size_t listed = has_list && arguments.size() > alone ? arguments.size() - alone : 0;
    if (!has_list && arguments.size() > alone) {
      throw CLI::ValidationError(absl::StrCat("'", arguments[alone], "' is one word too many"));
    }
    auto word = arguments.begin();
    for (OptionSpec* spec : specs) {
      const auto end = word + std::min<std::ptrdiff_t>(arguments.end() - word, spec->list ? listed : 1);
      if (word == end && spec->required) throw CLI::ValidationError(spec->name() + " is required");
      if (word != end) take(*spec, {word, end});
      word = end;
    }
  }

  /// The first; null where there is none.
  const OptionSpec* required_argument() const {
    const auto is_one = [](const auto& spec) { return spec->is_argument() && spec->required; };
    const auto found = std::ranges::find_if(command_.options, is_one);
    return found == command_.options.end() ? nullptr : found->get();
  }

  std::vector<std::string> names_of_options() const {
    std::vector<std::string> names{"--help"};
    for (const auto& spec : command_.options) {
      if (!spec->is_argument()) names.push_back(spec->name());
    }
    return names;
  }

  CommandSpec& command_;
  const std::vector<std::string>& words_;
  CLI::App app_;
  CLI::Option* arguments_ = nullptr;
};

}  // namespace

bool OptionSpec::is_called(std::string_view name) const {
  return std::ranges::find(names, name) != names.end() || std::ranges::find(former, name) != former.end();
}

std::string OptionSpec::shown_name() const { return hidden ? name().substr(2) : name(); }

OptionSpec* CommandSpec::find(std::string_view name) const {
  for (const auto& option : options) {
    if (option->is_called(name)) return option.get();
  }
  return nullptr;
}

OptionSpec* CommandSpec::find_setting(std::string name) const {
  std::ranges::replace(name, '_', '-');
  OptionSpec* const spec = find("--" + name);
  return spec == nullptr || spec->sets ? nullptr : spec;
}

absl::Status take_default(CommandSpec& command, const FileValue& value) {
  const auto fault = [&](const std::string& what) {
    return absl::InvalidArgumentError(absl::StrCat(value.place, ": ", what));
  };
  OptionSpec* const spec = command.find(value.option);
  if (spec == nullptr || spec->is_argument()) {
    if (!value.expected) return absl::OkStatus();
    std::vector<std::string> names;
    for (const auto& option : command.options) names.push_back(option->name());
    return fault(absl::StrCat(command.path, " has no option '", value.option, "'",
                              base::did_you_mean(value.option, names)));
  }
  if (spec->is_flag() && value.text != "true" && value.text != "false")
    return fault(absl::StrCat(spec->name(), " is true or false"));
  if (spec->is_flag() && value.text == "false") return absl::OkStatus();
  try {
    take(*spec, {spec->is_flag() ? "" : value.text});
  } catch (const CLI::ParseError& error) {
    return fault(error.what());
  }
  spec->given.clear();  // not by the command line
  return absl::OkStatus();
}

absl::Status parse_words(CommandSpec& command, const std::vector<std::string>& words) {
  return Parser{command, words}.run();
}

}  // namespace tessera::options
