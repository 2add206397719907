// Errors and warnings that name file, line and column.
#pragma once

#include <cstdint>
#include <deque>
#include <string>
#include <unordered_map>
#include <vector>

#include "absl/status/status.h"

namespace tessera::client {

/// One message about a place of a scene file. `line` and `column` count from 1; 0 means unknown.
struct Diagnostic {
  std::string file;
  std::uint32_t line = 0;
  std::uint32_t column = 0;
  std::string message;
};

/// "file:line:column: message", without the parts that are unknown.
std::string to_string(const Diagnostic& diagnostic);

/// A place in a file that `Diagnostics` knows by its number.
struct SourceLocation {
  std::uint32_t file = 0;
  std::uint32_t line = 0;
  std::uint32_t column = 0;
};

/// Collects the messages of one import. Not thread-safe.
class Diagnostics {
 public:
  /// After this many errors an import stops looking for more.
  static constexpr std::size_t kMaxErrors = 20;

  /// The number of a file for `SourceLocation::file`.
  std::uint32_t add_file(std::string name);
  const std::string& file_name(std::uint32_t file) const { return files_[file]; }

  /// Records an error; those beyond kMaxErrors are dropped.
  void error(SourceLocation where, std::string message);
  /// Records a warning. The same message again is only counted: its first place stands for all.
  void warning(SourceLocation where, std::string message);

  bool has_errors() const { return !errors_.empty(); }
  bool full() const { return errors_.size() >= kMaxErrors; }
  const std::vector<Diagnostic>& errors() const { return errors_; }

  /// InvalidArgument with all errors, one a line; OK when there are none.
  absl::Status status() const;
  /// All warnings in order of first appearance, with "(and 3 more)" where a message was repeated.
  std::vector<Diagnostic> warnings() const;

 private:
  Diagnostic locate(SourceLocation where, std::string message) const;

  struct CountedWarning {
    Diagnostic diagnostic;
    std::size_t count = 1;
  };

  std::deque<std::string> files_;
  std::vector<Diagnostic> errors_;
  std::vector<CountedWarning> warnings_;
  std::unordered_map<std::string, std::size_t> warning_of_message_;
};

}  // namespace tessera::client
