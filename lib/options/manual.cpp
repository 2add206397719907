// Manual pages, for man(1).
#include <algorithm>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "base/nearest_name.h"
#include "options/parts.h"

namespace tessera::options {
namespace {

/// Name of a command's page: words are joined by hyphens.
std::string page_name(const std::string& program, const std::string& command) {
  return absl::StrCat(program, "-", absl::StrReplaceAll(command, {{" ", "-"}}));
}

/// A line of text: roff takes backslashes, hyphens, and a period or quote in front for its own.
std::string roff(const std::string& text) {
  const std::string line = absl::StrReplaceAll(text, {{"\\", "\\e"}, {"-", "\\-"}});
  return line.starts_with('.') || line.starts_with('\'') ? "\\&" + line : line;
}

std::string heading(const std::string& name, const std::string& version, const std::string& description) {
  return absl::StrCat(".TH ", absl::AsciiStrToUpper(name), " 1 \"\" \"", roff(version), "\"\n.SH NAME\n",
                      roff(name), " \\- ", roff(description), "\n");
}

std::string entry(const std::string& left, const std::string& right) {
  return absl::StrCat(".TP\n.B ", roff(left), "\n", right.empty() ? "\\&" : roff(right), "\n");
}

std::string options_of(const CommandSpec& command) {
  std::string text;
  for (const auto& option : command.options) {
    if (option->is_argument()) absl::StrAppend(&text, entry(left_of(*option), right_of(*option)));
  }
  std::vector<std::string> groups;
  for (const auto& option : command.options) {
    if (option->is_argument() || std::ranges::find(groups, option->group) != groups.end()) continue;
    groups.push_back(option->group);
    absl::StrAppend(&text, ".SS ", roff(option->group), "\n");
    for (const auto& other : command.options) {
      if (other->is_argument() || other->group != option->group) continue;
      const std::string left = left_of(*other);
      absl::StrAppend(&text, entry(std::string{absl::StripLeadingAsciiWhitespace(left)}, right_of(*other)));
      if (other->listed_choices.empty()) continue;
      text += ".RS\n";
      for (const Choice& choice : other->listed_choices)
        absl::StrAppend(&text, entry(choice.name, choice.meaning));
      text += ".RE\n";
    }
  }
  return text;
}

std::string page_of(const std::string& name, const std::string& version, const CommandSpec& command) {
  std::string page = heading(name, version, command.description);
  absl::StrAppend(&page, ".SH SYNOPSIS\n.B ", roff(usage_of(command)), "\n.SH OPTIONS\n",
                  options_of(command));
  if (command.examples.empty()) return page;
  page += ".SH EXAMPLES\n.nf\n";
  for (const std::string& example : command.examples) absl::StrAppend(&page, roff(example), "\n");
  return page + ".fi\n";
}

}  // namespace

absl::StatusOr<std::string> Program::manual(const std::string& command) const {
  const Parts& parts = *parts_;
  const std::string& program = parts.root.path;
  if (!command.empty()) {
    std::vector<std::string> names;
    for (const auto& [name, spec] : parts.commands) {
      names.push_back(name);
      // The words of a command may be joined as in the name of its page.
      if (page_name("", name) == page_name("", command))
        return absl::StrCat(page_of(page_name(program, name), parts.version, *spec), ".SH SEE ALSO\n.BR ",
                            roff(program), " (1)\n");
    }
    return absl::InvalidArgumentError(
        absl::StrCat("there is no command '", command, "'", base::did_you_mean(command, names)));
  }
  if (parts.commands.empty()) return page_of(program, parts.version, parts.root);
  std::string page = heading(program, parts.version, parts.root.description);
  absl::StrAppend(&page, ".SH SYNOPSIS\n.B ", roff(parts.usage()), "\n.SH COMMANDS\n");
  std::string group;
  for (const auto& [name, spec] : parts.commands) {
    if (std::exchange(group, spec->group) != spec->group)
      absl::StrAppend(&page, ".SS ", roff(spec->group), "\n");
    absl::StrAppend(&page, ".TP\n.BR ", roff(page_name(program, name)), " (1)\n", roff(spec->description),
                    "\n");
  }
  if (!parts.footer.empty()) absl::StrAppend(&page, ".SH EXIT STATUS\n", roff(parts.footer), "\n");
  return page;
}

}  // namespace tessera::options
