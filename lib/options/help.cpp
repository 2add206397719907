// Text of --help.
#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "base/nearest_name.h"
#include "options/spec.h"

namespace tessera::options {
namespace {

constexpr std::size_t kColumns = 80;
constexpr std::size_t kRight = 28;  // where the right column begins
constexpr double kFarBound = 1e6;   // nobody comes near such a bound

/// An option in two columns.
std::string lines_of(const OptionSpec& option) {
  return help_line(left_of(option), right_of(option), kRight);
}

/// "spp=N": as --set takes it.
std::string as_setting(const OptionSpec& option) {
  return absl::StrCat(option.name().substr(2), option.is_flag() ? "" : "=", option.value_name);
}

/// All that there is to know of an option.
std::string page_of(const OptionSpec& option) {
  std::string page = absl::StrCat(wrapped(option.description, 0), "\n\n  --set ", as_setting(option), "\n");
  if (!option.hidden)
    absl::StrAppend(&page, "  ", option.name(), option.is_flag() ? "" : " ", option.value_name, "\n");
  for (const std::string& former : option.former)
    absl::StrAppend(&page, "  ", former, " in older versions, which is still taken\n");
  if (option.range)
    absl::StrAppendFormat(&page, "\nfrom %.15g to %.15g\n", option.range->first, option.range->second);
  if (!option.shown_default.empty()) absl::StrAppend(&page, "\ndefault: ", option.shown_default, "\n");
  if (option.listed_choices.empty() && !option.completions.empty())
    absl::StrAppend(&page, "\n", wrapped(absl::StrJoin(option.completions, ", "), 0), "\n");
  if (!option.listed_choices.empty()) page += "\n";
  for (const Choice& choice : option.listed_choices)
    absl::StrAppend(&page, help_line(choice.name, choice.meaning, kRight));
  return page;
}

}  // namespace

std::string left_of(const OptionSpec& option) {
  if (option.hidden) return as_setting(option);
  std::string left = absl::StrJoin(option.names, ", ");
  if (option.is_argument()) return option.list ? left + "..." : left;
  // Long names stand in one column.
  if (option.names.size() == 1 && left.starts_with("--")) left = "    " + left;
  return option.is_flag() ? left : absl::StrCat(left, " ", option.value_name);
}

std::string right_of(const OptionSpec& option) {
  std::vector<std::string> remarks;
  if (const auto& names = option.choices;
      !names.empty() && option.description.find(names[0]) == std::string::npos) {
    remarks.push_back(absl::StrJoin(names, ", "));
  }
  if (!option.listed_choices.empty()) {
    const auto name_of = [](std::string* out, const Choice& choice) { out->append(choice.name); };
    remarks.push_back(absl::StrJoin(option.listed_choices, ", ", name_of));
  }
  if (option.range && option.range->second < kFarBound)
    remarks.push_back(absl::StrFormat("%.15g to %.15g", option.range->first, option.range->second));
  if (!option.environment.empty()) remarks.push_back(absl::StrCat("else $", option.environment));
  if (!option.shown_default.empty()) remarks.push_back(absl::StrCat("default: ", option.shown_default));
  if (remarks.empty()) return option.description;
  return absl::StrCat(option.description, option.description.empty() ? "(" : " (",
                      absl::StrJoin(remarks, "; "), ")");
}

std::string wrapped(std::string_view text, std::size_t indent) {
  std::string result;
  std::size_t column = indent;
  for (const std::string& word :
       std::vector<std::string>(absl::StrSplit(absl::string_view{text.data(), text.size()}, ' '))) {
    if (column > indent && column + 1 + word.size() > kColumns) {
      absl::StrAppend(&result, "\n", std::string(indent, ' '));
      column = indent;
    } else if (column > indent) {
      result += ' ';
      ++column;
    }
    result += word;
    column += word.size();
  }
  return result;
}

std::string help_line(const std::string& left, const std::string& right, std::size_t column) {
  std::string line = absl::StrCat("  ", left);
  if (right.empty()) return line + "\n";
  if (line.size() + 2 > column) line += "\n";
  const std::size_t begun = line.ends_with('\n') ? 0 : line.size();
  return absl::StrCat(line, std::string(column - begun, ' '), wrapped(right, column), "\n");
}

std::string usage_of(const CommandSpec& command) {
  std::string usage = command.path;
  bool more = false;
  for (const auto& option : command.options) {
    if (option->is_argument()) {
      const std::string name = absl::StrCat(option->name(), option->list ? "..." : "");
      absl::StrAppend(&usage, " ", option->required ? name : absl::StrCat("[", name, "]"));
    }
  }
  for (const auto& option : command.options) {
    if (option->is_argument()) continue;
    more = more || !option->required;
    if (option->required) absl::StrAppend(&usage, " ", option->names.front(), " ", option->value_name);
  }
  return more ? usage + " [options]" : usage;
}

std::string help_of(const CommandSpec& command) {
  std::string help =
      absl::StrCat(wrapped(command.description, 0), "\n\n", "usage: ", wrapped(usage_of(command), 7), "\n");
  std::vector<std::string> groups;
  std::string arguments;
  for (const auto& option : command.options) {
    if (option->is_argument() && !option->description.empty()) {
      absl::StrAppend(&arguments, lines_of(*option));
    }
    if (!option->is_argument() && !option->hidden &&
        std::ranges::find(groups, option->group) == groups.end()) {
      groups.push_back(option->group);
    }
  }
  if (!arguments.empty()) absl::StrAppend(&help, "\n", arguments);
  for (const std::string& group : groups) {
    absl::StrAppend(&help, "\n", group, "\n");
    for (const auto& option : command.options) {
      if (option->is_argument() || option->hidden || option->group != group) continue;
      absl::StrAppend(&help, lines_of(*option));
    }
  }
  absl::StrAppend(&help, "\n", help_line("-h, --help", "show this help", kRight));
  if (!command.examples.empty()) absl::StrAppend(&help, "\nfor example\n");
  for (const std::string& example : command.examples) absl::StrAppend(&help, "  ", example, "\n");
  return help;
}

absl::StatusOr<std::string> settings_of(const std::function<void(Command&)>& define,
                                        const std::string& name) {
  CommandSpec spec;
  Command command{spec};
  define(command);
  if (const OptionSpec* const found = spec.find_setting(name); found != nullptr) return page_of(*found);
  std::string text, group;
  std::vector<std::string> names;
  for (const auto& option : spec.options) {
    if (option->is_argument() || option->sets) continue;
    names.push_back(option->name().substr(2));
    if (!name.empty() && !names.back().starts_with(name + ".")) continue;
    if (std::exchange(group, option->group) != option->group)
      absl::StrAppend(&text, text.empty() ? "" : "\n", group, "\n");
    absl::StrAppend(&text, help_line(as_setting(*option), right_of(*option), kRight));
  }
  if (!text.empty()) return text;
  return absl::NotFoundError(
      absl::StrCat("there is no setting '", name, "'", base::did_you_mean(name, names)));
}

}  // namespace tessera::options
