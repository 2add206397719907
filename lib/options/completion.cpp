// Scripts with which shells complete command lines.
#include <algorithm>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_replace.h"
#include "options/parts.h"

namespace tessera::options {
namespace {

/// A command, or a program without any.
struct Row {
  std::string name;  // empty: the program itself
  const CommandSpec& command;
};

/// Puts a text in single quotes for bash and zsh.
std::string shell_quoted(const std::string& text) {
  return absl::StrCat("'", absl::StrReplaceAll(text, {{"'", "'\\''"}}), "'");
}

std::string words_of(const CommandSpec& command) {
  std::vector<std::string> words{"--help"};
  for (const auto& option : command.options) {
    if (!option->is_argument() && !option->hidden)
      words.insert(words.end(), option->names.begin(), option->names.end());
  }
  return absl::StrJoin(words, " ");
}

bool has_set(const CommandSpec& command) {
  return std::ranges::any_of(command.options, [](const auto& option) { return option->sets; });
}

std::string bash(const std::string& program, const std::vector<Row>& rows, bool has_commands) {
  std::string values, options, names;
  for (const Row& row : rows) {
    absl::StrAppend(&names, names.empty() ? "" : " ", row.name);
    absl::StrAppend(&options, "    ", has_commands ? row.name : "*",
                    ") options=", shell_quoted(words_of(row.command)), " ;;\n");
    for (const auto& option : row.command.options) {
      if (option->is_argument() || option->is_flag()) continue;
      const auto pattern = [&](std::string* out, const std::string& name) {
        absl::StrAppend(out, "'", row.name, " ", name, "'");
      };
      // Bash takes --set NAME=VALUE for four words, the third of which goes before VALUE.
      std::vector<std::string> before = option->names;
      if (has_set(row.command) && !option->sets) before.push_back(option->name().substr(2));
      absl::StrAppend(&values, "    ", absl::StrJoin(before, "|", pattern),
                      ") values=", shell_quoted(absl::StrJoin(value_words(row.command, *option), " ")),
                      " ;;\n");
    }
  }
  return absl::StrCat(
      "# bash completion of ", program, "\n_", program,
      "() {\n"
      "  local current=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} command='' options='' "
      "values=-\n",
      has_commands ? absl::StrCat("  if [ \"$COMP_CWORD\" = 1 ]; then\n    COMPREPLY=($(compgen -W ",
                                  shell_quoted(names),
                                  " -- \"$current\"))\n    return\n  fi\n  command=${COMP_WORDS[1]}\n")
                   : "",
      "  # Bash takes --name=value for three words.\n"
      "  if [ \"$current\" = = ]; then current=''; "
      "elif [ \"$before\" = = ]; then before=${COMP_WORDS[COMP_CWORD-2]}; fi\n"
      "  case \"$command $before\" in\n",
      values,
      "  esac\n"
      "  if [ \"$values\" != - ]; then\n"
      "    [ -z \"$values\" ] || COMPREPLY=($(compgen -W \"$values\" -- \"$current\"))\n"
      "    return  # of files, where there are no words\n"
      "  fi\n"
      "  case \"$command\" in\n",
      options,
      "  esac\n"
      "  case \"$current\" in -*) COMPREPLY=($(compgen -W \"$options\" -- \"$current\")) ;; esac\n"
      "}\n"
      "complete -o default -F _",
      program, " ", program, "\n");
}

/// A part of a specification of _arguments.
std::string in_zsh(const std::string& text) {
  return absl::StrReplaceAll(text,
                             {{"\\", "\\\\"}, {"[", "\\["}, {"]", "\\]"}, {":", "\\:"}, {"'", "'\\''"}});
}

std::string zsh(const std::string& program, const std::vector<Row>& rows, bool has_commands) {
  std::string commands, cases;
  for (const Row& row : rows) {
    absl::StrAppend(&commands, "    '", in_zsh(row.name), ":", in_zsh(row.command.description), "'\n");
    std::string specs = "'--help[show the help]'";
    for (const auto& option : row.command.options) {
      if (option->is_argument() || option->hidden) continue;
      const std::vector<std::string> words = value_words(row.command, *option);
      for (const std::string& name : option->names) {
        absl::StrAppend(&specs, " \\\n        '", option->list ? "*" : "", name, "[",
                        in_zsh(option->description), "]");
        if (!option->is_flag()) {
          absl::StrAppend(
              &specs, ":", in_zsh(option->value_name), ":",
              words.empty() ? "_files" : absl::StrCat("(", in_zsh(absl::StrJoin(words, " ")), ")"));
        }
        specs += "'";
      }
    }
    absl::StrAppend(&cases, "    ", has_commands ? row.name : "*", ") _arguments ", specs,
                    " \\\n        '*:file:_files' ;;\n");
  }
  return absl::StrCat("#compdef ", program, "\n_", program, "() {\n",
                      has_commands ? absl::StrCat("  local -a commands=(\n", commands,
                                                  "  )\n  if (( CURRENT == 2 )); then\n    _describe command "
                                                  "commands\n    return\n  fi\n  local command=$words[2]\n"
                                                  "  shift words\n  (( CURRENT-- ))\n")
                                   : "  local command=''\n",
                      "  case \"$command\" in\n", cases, "  esac\n}\n_", program, " \"$@\"\n");
}

std::string in_fish(const std::string& text) {
  return absl::StrCat("'", absl::StrReplaceAll(text, {{"\\", "\\\\"}, {"'", "\\'"}}), "'");
}

std::string fish(const std::string& program, const std::vector<Row>& rows, bool has_commands) {
  std::string script = absl::StrCat("# fish completion of ", program, "\n");
  for (const Row& row : rows) {
    const std::string when =
        has_commands ? absl::StrCat(" -n '__fish_seen_subcommand_from ", row.name, "'") : "";
    if (has_commands) {
      absl::StrAppend(&script, "complete -c ", program, " -f -n __fish_use_subcommand -a ", row.name, " -d ",
                      in_fish(row.command.description), "\n");
      absl::StrAppend(&script, "complete -c ", program, when, " -F\n");
    }
    for (const auto& option : row.command.options) {
      if (option->is_argument() || option->hidden) continue;
      absl::StrAppend(&script, "complete -c ", program, when);
      for (const std::string& name : option->names)
        absl::StrAppend(&script, name.starts_with("--") ? " -l " : " -s ",
                        name.substr(name.starts_with("--") ? 2 : 1));
      if (!option->is_flag()) script += " -r";
      if (const std::vector<std::string> words = value_words(row.command, *option); !words.empty())
        absl::StrAppend(&script, " -f -a ", in_fish(absl::StrJoin(words, " ")));
      absl::StrAppend(&script, " -d ", in_fish(option->description), "\n");
    }
  }
  return script;
}

/// "spp=", "sampler=sobol" ...
std::vector<std::string> words_of_settings(const CommandSpec& command) {
  std::vector<std::string> words;
  for (const auto& option : command.options) {
    if (option->is_argument() || option->sets) continue;
    const std::string name = absl::StrCat(option->name().substr(2), option->is_flag() ? "" : "=");
    const std::vector<std::string> values = value_words(command, *option);
    for (const std::string& value : values) words.push_back(name + value);
    if (values.empty()) words.push_back(name);
  }
  return words;
}

}  // namespace

std::vector<std::string> value_words(const CommandSpec& command, const OptionSpec& option) {
  if (option.sets) return words_of_settings(command);
  if (!option.completions.empty()) return option.completions;
  if (!option.choices.empty()) return option.choices;
  std::vector<std::string> words;
  for (const Choice& choice : option.listed_choices) words.push_back(choice.name);
  return words;
}

absl::StatusOr<std::string> Program::completion(const std::string& shell) const {
  std::vector<Row> rows;
  // Commands of two words complete files alone.
  for (const auto& [name, command] : parts_->commands)
    if (name.find(' ') == std::string::npos) rows.push_back({name, *command});
  const bool has_commands = !rows.empty();
  if (!has_commands) rows.push_back({"", parts_->root});
  const std::string& program = parts_->root.path;
  if (shell == "bash") return bash(program, rows, has_commands);
  if (shell == "zsh") return zsh(program, rows, has_commands);
  if (shell == "fish") return fish(program, rows, has_commands);
  return absl::InvalidArgumentError(
      absl::StrCat("there is no shell '", shell, "'; there is: bash, zsh, fish"));
}

}  // namespace tessera::options
