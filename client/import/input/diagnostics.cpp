#include "import/input/diagnostics.h"

#include <utility>

#include "base/printable.h"
#include "import/input/concat.h"

namespace tessera::client {

std::string to_string(const Diagnostic& diagnostic) {
  std::string text = diagnostic.file;
  if (diagnostic.line > 0) text += concat(":", diagnostic.line);
  if (diagnostic.line > 0 && diagnostic.column > 0) text += concat(":", diagnostic.column);
  if (!text.empty()) text += concat(": ");
  return base::printable(concat(text, diagnostic.message));
}

std::uint32_t Diagnostics::add_file(std::string name) {
  files_.push_back(std::move(name));
  return static_cast<std::uint32_t>(files_.size() - 1);
}

Diagnostic Diagnostics::locate(SourceLocation where, std::string message) const {
  Diagnostic diagnostic;
  if (where.file < files_.size()) diagnostic.file = files_[where.file];
  diagnostic.line = where.line;
  diagnostic.column = where.column;
  diagnostic.message = std::move(message);
  return diagnostic;
}

void Diagnostics::error(SourceLocation where, std::string message) {
  if (!full()) errors_.push_back(locate(where, std::move(message)));
}

void Diagnostics::warning(SourceLocation where, std::string message) {
  const auto [entry, is_new] = warning_of_message_.try_emplace(message, warnings_.size());
  if (is_new) {
    warnings_.push_back({locate(where, std::move(message)), 1});
  } else {
    ++warnings_[entry->second].count;
  }
}

absl::Status Diagnostics::status() const {
  if (errors_.empty()) return absl::OkStatus();
  std::string text;
  for (const Diagnostic& error : errors_) text += concat(text.empty() ? "" : "\n", to_string(error));
  if (full()) text += concat("\nstopped after ", kMaxErrors, " errors");
  return absl::InvalidArgumentError(text);
}

std::vector<Diagnostic> Diagnostics::warnings() const {
  std::vector<Diagnostic> result;
  result.reserve(warnings_.size());
  for (const CountedWarning& warning : warnings_) {
    result.push_back(warning.diagnostic);
    if (warning.count > 1) result.back().message += concat(" (and ", warning.count - 1, " more)");
  }
  return result;
}

}  // namespace tessera::client
