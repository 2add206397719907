#include "options/program.h"

#include <algorithm>
#include <iostream>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "base/nearest_name.h"
#include "options/parts.h"
#include "options/spec.h"

namespace tessera::options {
namespace {

// Where the descriptions of commands begin.
constexpr std::size_t kColumn = 18;

bool is_within(const std::string& name) { return name.find(' ') != std::string::npos; }

bool asks_for_help(const std::string& word) { return word == "--help" || word == "-h"; }

}  // namespace

std::string Program::Parts::usage() const {
  return commands.empty() ? usage_of(root) : absl::StrCat(root.path, " COMMAND [options]");
}

Outcome Program::Parts::wrong(const std::string& where, const std::string& what,
                              const std::string& usage) const {
  return {kWrongUsage, "",
          absl::StrCat(where, ": ", what, "\nusage: ", usage, "   (more: ", where, " --help)\n")};
}

absl::Status Program::Parts::take_defaults(const std::string& name, CommandSpec& command) const {
  if (!defaults) return absl::OkStatus();
  const absl::StatusOr<std::vector<FileValue>> values = defaults(name);
  if (!values.ok()) return values.status();
  for (const FileValue& value : *values) {
    if (absl::Status status = take_default(command, value); !status.ok()) return status;
  }
  return absl::OkStatus();
}

std::string Program::Parts::help() const {
  if (commands.empty()) return help_of(root);
  std::string help = absl::StrCat(wrapped(root.description, 0), "\n\nusage: ", usage(), "\n");
  std::string heading;
  for (const auto& [name, command] : commands) {
    if (is_within(name)) continue;  // --help of the first word lists it
    if (std::exchange(heading, command->group) != command->group)
      absl::StrAppend(&help, "\n", command->group, "\n");
    absl::StrAppend(&help, help_line(name, command->description, kColumn));
  }
  absl::StrAppend(
      &help, "\n", help_line("COMMAND --help", "the options of a command, with an example", kColumn),
      help_line("--completion SHELL", "a script for bash, zsh or fish that completes commands", kColumn),
      help_line("--man [COMMAND]", "the manual page, for man -l -", kColumn),
      help_line("--version", "the version", kColumn));
  if (!footer.empty()) absl::StrAppend(&help, "\n", wrapped(footer, 0), "\n");
  return help;
}

std::vector<std::pair<std::string, const CommandSpec*>> Program::Parts::within(
    const std::string& name) const {
  std::vector<std::pair<std::string, const CommandSpec*>> found;
  for (const auto& [each, command] : commands) {
    if (each.starts_with(name + " ")) found.emplace_back(each.substr(name.size() + 1), command.get());
  }
  return found;
}

std::string Program::Parts::family_help(const CommandSpec& command, const std::string& name) const {
  std::string help = absl::StrCat(wrapped(command.description, 0), "\n\nusage: ", command.path,
                                  " COMMAND [options]\n\nCommands\n");
  for (const auto& [word, each] : within(name))
    absl::StrAppend(&help, help_line(word, each->description, kColumn));
  absl::StrAppend(&help, "\n",
                  help_line("COMMAND --help", "the options of a command, with an example", kColumn));
  absl::StrAppend(&help, help_line("-h, --help", "show this help", kColumn));
  if (!command.examples.empty()) absl::StrAppend(&help, "\nfor example\n");
  for (const std::string& example : command.examples) absl::StrAppend(&help, "  ", example, "\n");
  return help;
}

Program::Program(const char* name, const char* description, const std::string& version, const char* footer)
    : parts_(std::make_unique<Parts>()) {
  parts_->version = version;
  parts_->footer = footer;
  parts_->root.path = name;
  parts_->root.description = description;
}

Program::~Program() = default;

Command Program::root() { return Command{parts_->root}; }

void Program::take_defaults_from(DefaultsReader read) { parts_->defaults = std::move(read); }

void Program::group(const char* heading) { parts_->group = heading; }

Command Program::add_command(const char* name, const char* description) {
  auto command = std::make_unique<CommandSpec>();
  command->path = absl::StrCat(parts_->root.path, " ", name);
  command->description = description;
  command->group = parts_->group;
  return Command{*parts_->commands.emplace_back(name, std::move(command)).second};
}

Outcome Program::parse_command(const std::string& name, const std::vector<std::string>& rest) {
  const Parts& parts = *parts_;
  const auto within = parts.within(name);
  if (!rest.empty() &&
      std::ranges::find(within, rest[0], [](const auto& named) { return named.first; }) != within.end()) {
    return parse_command(absl::StrCat(name, " ", rest[0]), {rest.begin() + 1, rest.end()});
  }
  const auto found = std::ranges::find(parts.commands, name, [](const auto& named) { return named.first; });
  if (found == parts.commands.end()) {
    std::vector<std::string> names;
    for (const auto& command : parts.commands)
      if (!is_within(command.first)) names.push_back(command.first);
    const std::string what = name.starts_with('-') ? "option" : "command";
    return parts.wrong(parts.root.path,
                       absl::StrCat("there is no ", what, " '", name, "'", base::did_you_mean(name, names)),
                       parts.usage());
  }
  CommandSpec& command = *found->second;
  if (!within.empty()) {
    if (!rest.empty() && asks_for_help(rest[0])) return {0, parts.family_help(command, name), ""};
    std::vector<std::string> names;
    for (const auto& each : within) names.push_back(each.first);
    const std::string what = rest.empty() ? "a command is missing"
                                          : absl::StrCat("there is no command '", rest[0], "'",
                                                         base::did_you_mean(rest[0], names));
    return parts.wrong(command.path, what, absl::StrCat(command.path, " COMMAND [options]"));
  }
  if (std::ranges::any_of(rest, asks_for_help)) return {0, help_of(command), ""};
  if (const absl::Status status = parts.take_defaults(name, command); !status.ok())
    return parts.wrong(command.path, std::string{status.message()}, usage_of(command));
  if (const absl::Status status = parse_words(command, rest); !status.ok()) {
    return parts.wrong(command.path, std::string{status.message()}, usage_of(command));
  }
  parts_->chosen = &command;
  std::string notices;
  for (const std::string& notice : command.notices) absl::StrAppend(&notices, "note: ", notice, "\n");
  return {std::nullopt, "", notices};
}

Outcome Program::parse(const std::vector<std::string>& words) {
  const Parts& parts = *parts_;
  const bool has_commands = !parts.commands.empty();
  if (!words.empty() && words[0] == "--version") return {0, parts.version + "\n", ""};
  if (!words.empty() && (words[0] == "--completion" || words[0] == "--man")) {
    const std::string about = absl::StrJoin(words.begin() + 1, words.end(), " ");
    const absl::StatusOr<std::string> text = words[0] == "--man" ? manual(about) : completion(about);
    if (!text.ok()) return parts.wrong(parts.root.path, std::string{text.status().message()}, parts.usage());
    return {0, *text, ""};
  }
  if (has_commands) {
    if (words.empty()) return parts.wrong(parts.root.path, "a command is missing", parts.usage());
    const bool help = asks_for_help(words[0]) || words[0] == "help";
    if (!help) return parse_command(words[0], {words.begin() + 1, words.end()});
    if (words.size() == 1) return {0, parts.help(), ""};
    std::vector<std::string> rest(words.begin() + 2, words.end());
    rest.emplace_back("--help");
    return parse_command(words[1], rest);
  }
  if (std::ranges::any_of(words, asks_for_help)) return {0, parts.help(), ""};
  if (const absl::Status status = parse_words(parts_->root, words); !status.ok()) {
    return parts.wrong(parts.root.path, std::string{status.message()}, parts.usage());
  }
  return {};
}

std::optional<int> Program::parse(int argc, const char* const* argv) {
  const Outcome outcome = parse({argv + std::min(argc, 1), argv + argc});
  std::cout << outcome.out << std::flush;
  std::cerr << outcome.err << std::flush;
  return outcome.exit_code;
}

int Program::run(int argc, const char* const* argv) {
  const std::optional<int> ended = parse(argc, argv);
  return ended ? *ended : parts_->chosen->action();
}

absl::Status parse_options(const std::function<void(Command&)>& define,
                           const std::vector<std::string>& words) {
  CommandSpec spec;
  Command command{spec};
  define(command);
  return parse_words(spec, words);
}

}  // namespace tessera::options
