// From words to values.
#include <algorithm>
#include <cstdlib>
#include <optional>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "options/spec.h"
#include "wire/nearest_name.h"

namespace tessera::options {
namespace {

absl::Status wrong(const std::string& text) { return absl::InvalidArgumentError(text); }

absl::Status take_one(OptionSpec& spec, const std::string& value, const std::string& called) {
  if (!spec.choices.empty() && std::ranges::find(spec.choices, value) == spec.choices.end()) {
    return wrong(absl::StrCat(called, ": there is no '", value, "'; there is: ", absl::StrJoin(spec.choices, ", ")));
  }
  for (const auto& check : spec.checks) {
    if (const std::string fault = check(value); !fault.empty()) return wrong(absl::StrCat(called, ": ", fault));
  }
  const absl::Status status = spec.take(value);
  return status.ok() ? status : wrong(absl::StrCat(called, ": ", std::string{status.message()}));
}

/// `called`: what the user named it.
absl::Status take(OptionSpec& spec, const std::string& value, const std::string& called) {
  if (++spec.times_given > 1 && !spec.list && !spec.is_flag()) return wrong(absl::StrCat(called, " is given twice"));
  if (spec.times_given == 1 && spec.list) spec.clear();
  if (!spec.commas) return take_one(spec, value, called);
  for (const std::string& part : std::vector<std::string>(absl::StrSplit(value, ','))) {
    if (absl::Status status = take_one(spec, part, called); !status.ok()) return status;
  }
  return absl::OkStatus();
}

std::vector<std::string> names_of_options(const CommandSpec& command) {
  std::vector<std::string> names{"--help"};
  for (const auto& option : command.options) {
    if (!option->is_argument()) names.push_back(option->name());
  }
  return names;
}

/// "-" is a word, and so is "-5": no option is a number.
bool looks_like_option(const std::string& word) {
  return word.size() > 1 && word[0] == '-' && !(word[1] >= '0' && word[1] <= '9');
}

/// Goes over the words of one command line.
class Parser {
 public:
  Parser(CommandSpec& command, const std::vector<std::string>& words) : command_(command), words_(words) {}

  absl::Status run() {
    bool only_arguments = false;
    while (at_ < words_.size()) {
      const std::string& word = words_[at_++];
      absl::Status status;
      if (!only_arguments && word == "--") {
        only_arguments = true;
      } else if (!only_arguments && looks_like_option(word)) {
        status = take_option(word);
      } else {
        arguments_.push_back(word);
      }
      if (!status.ok()) return status;
    }
    if (absl::Status status = take_arguments(); !status.ok()) return status;
    if (absl::Status status = take_environment(); !status.ok()) return status;
    return check_together();
  }

 private:
  absl::Status take_option(const std::string& word) {
    const bool is_long = word.starts_with("--");
    const std::size_t equals = is_long ? word.find('=') : std::string::npos;
    const std::string name = is_long ? word.substr(0, equals) : word.substr(0, 2);
    OptionSpec* const spec = command_.find(name);
    if (spec == nullptr || spec->is_argument()) {
      const std::string& whole = is_long ? name : word;
      return wrong(
          absl::StrCat("there is no option '", whole, "'", wire::did_you_mean(whole, names_of_options(command_))));
    }
    std::optional<std::string> value;
    if (equals != std::string::npos) value = word.substr(equals + 1);
    if (!is_long && word.size() > 2) value = word.substr(2);
    if (spec->is_flag()) {
      if (value) return wrong(absl::StrCat(name, " takes no value"));
      return take(*spec, "", name);
    }
    if (!value) {
      const bool none = at_ == words_.size() || words_[at_].starts_with("--");
      if (none) return wrong(absl::StrCat(name, " needs a value: ", name, " ", spec->value_name));
      value = words_[at_++];
    }
    return take(*spec, *value, name);
  }

  /// In their order; a list among them takes what the others leave.
  absl::Status take_arguments() {
    std::vector<OptionSpec*> specs;
    for (const auto& spec : command_.options) {
      if (spec->is_argument()) specs.push_back(spec.get());
    }
    const bool has_list = std::ranges::any_of(specs, [](const OptionSpec* spec) { return spec->list; });
    const std::size_t alone = specs.size() - (has_list ? 1 : 0);
    const std::size_t listed = has_list && arguments_.size() > alone ? arguments_.size() - alone : 0;
    if (!has_list && arguments_.size() > alone) {
      return wrong(absl::StrCat("'", arguments_[alone], "' is one word too many"));
    }
    auto word = arguments_.begin();
    for (OptionSpec* spec : specs) {
      for (std::size_t i = 0; i < (spec->list ? listed : 1) && word != arguments_.end(); ++i, ++word) {
        if (absl::Status status = take(*spec, *word, spec->name()); !status.ok()) return status;
      }
    }
    return absl::OkStatus();
  }

  absl::Status take_environment() {
    for (const auto& spec : command_.options) {
      if (spec->times_given > 0 || spec->environment.empty()) continue;
      const char* const value = std::getenv(spec->environment.c_str());
      if (value == nullptr || *value == '\0') continue;
      if (absl::Status status = take(*spec, value, absl::StrCat("$", spec->environment)); !status.ok()) return status;
    }
    return absl::OkStatus();
  }

  absl::Status check_together() {
    for (const auto& spec : command_.options) {
      if (spec->times_given == 0) {
        if (!spec->required) continue;
        if (spec->is_argument()) return wrong(absl::StrCat(spec->name(), " is missing"));
        return wrong(absl::StrCat(absl::StrJoin(spec->names, " or "), " ", spec->value_name, " is required"));
      }
      for (const OptionSpec* other : spec->excludes) {
        if (other->times_given > 0)
          return wrong(absl::StrCat(spec->name(), " and ", other->name(), " exclude each other"));
      }
      for (const OptionSpec* other : spec->needs) {
        if (other->times_given == 0) {
          return wrong(absl::StrCat(spec->name(), " needs ", other->name(), " ", other->value_name, " too"));
        }
      }
    }
    return absl::OkStatus();
  }

  CommandSpec& command_;
  const std::vector<std::string>& words_;
  std::size_t at_ = 0;
  std::vector<std::string> arguments_;
};

}  // namespace

bool OptionSpec::is_called(std::string_view name) const { return std::ranges::find(names, name) != names.end(); }

OptionSpec* CommandSpec::find(std::string_view name) const {
  for (const auto& option : options) {
    if (option->is_called(name)) return option.get();
  }
  return nullptr;
}

absl::Status parse_words(CommandSpec& command, const std::vector<std::string>& words) {
  for (const auto& option : command.options) option->times_given = 0;
  return Parser{command, words}.run();
}

}  // namespace tessera::options
