// The words of a pbrt-v4 file, without copying them.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "import/input/diagnostics.h"

namespace tessera::client::pbrt {

enum class TokenKind : unsigned char {
  kWord,     // a directive, a number, true, false
  kString,   // quoted; `text` is what stands between the quotes, escapes not resolved
  kOpen,     // [
  kClose,    // ]
  kProblem,  // not a token; `text` says why
  kEnd
};

struct Token {
  TokenKind kind = TokenKind::kEnd;
  std::string_view text;
  SourceLocation where;
};

/// Splits text into tokens; comments are skipped. The text must outlive the tokens.
class Tokenizer {
 public:
  /// `file` is the number of the text in the import's Diagnostics.
  Tokenizer(std::string_view text, std::uint32_t file);

  Token next();

  /// Reads numbers as long as there are any and calls `take(double)` for each: the fast way through long
  /// arrays. Stops before the first token that is not a finite number in full.
  template <typename Take>
  void read_numbers(const Take& take) {
    double value = 0;
    while (read_number(value)) take(value);
  }

 private:
  void skip_space_and_comments();
  bool read_number(double& value);
  SourceLocation where() const;
  Token read_string();

  const char* p_;
  const char* end_;
  const char* line_begin_;
  std::uint32_t line_ = 1;
  std::uint32_t file_;
};

/// A finite number, or nothing when `text` is not one.
std::optional<double> parse_number(std::string_view text);

/// The string with its escapes (\n, \t, \", \\ ...) resolved; nothing when there is an unknown escape.
std::optional<std::string> unescape(std::string_view text);

}  // namespace tessera::client::pbrt
