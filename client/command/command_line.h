// The command line of the client: subcommands, each with what is done when it is named.
#pragma once

#include <functional>
#include <string>

#include "options/program.h"

namespace tessera::client {

class Interrupt;

using options::Option;

/// Does the work of a subcommand and returns the exit code.
using Action = std::function<int(Interrupt&)>;

/// A subcommand while it is being defined. Variables of options must outlive the command line: commonly the
/// action shares their ownership.
class Command : public options::Command {
 public:
  Command(options::Command command, Interrupt& interrupt)
      : options::Command(command), interrupt_(&interrupt) {}

  /// Sets what is to be done when the command line names this subcommand.
  void does(Action action);

 private:
  Interrupt* interrupt_;
};

class CommandLine {
 public:
  /// `interrupt` must outlive the command line.
  explicit CommandLine(Interrupt& interrupt);

  /// The heading of --help under which the commands are listed that follow.
  void group(const char* heading) { program_.group(heading); }
  Command add_command(const char* name, const char* description);

  /// Parses, does what was asked for, and returns the exit code. Help and errors of usage are printed.
  int run(int argc, const char* const* argv);

 private:
  options::Program program_;
  Interrupt* interrupt_;
};

}  // namespace tessera::client
