// The parts of a program's command line. For the sources of this folder only.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "options/program.h"
#include "options/spec.h"

namespace tessera::options {

struct Program::Parts {
  std::string version, footer;
  std::string group = "Commands";
  CommandSpec root;  // its options are used where there are no commands
  std::vector<std::pair<std::string, std::unique_ptr<CommandSpec>>> commands;  // name, command
  CommandSpec* chosen = nullptr;
  DefaultsReader defaults;

  std::string usage() const;
  std::string help() const;
  /// The commands of two words whose first is this one: the second words, with what they are.
  std::vector<std::pair<std::string, const CommandSpec*>> within(const std::string& name) const;
  /// Help of a command that has commands within it.
  std::string family_help(const CommandSpec& command, const std::string& name) const;
  Outcome wrong(const std::string& where, const std::string& what, const std::string& usage) const;
  absl::Status take_defaults(const std::string& name, CommandSpec& command) const;
};

}  // namespace tessera::options
