// Lines and numbers of photometric files, and where they stand.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"

namespace tessera::photometry {

/// Lines that end in LF, CR LF or CR, without their ends; nothing of a final empty one. From Ctrl-Z or a NUL
/// on there is nothing. The text must outlive them.
std::vector<std::string_view> lines_of(std::string_view text);

/// A number of a file: Fortran's exponents (1.5D+3) are read, too, and a comma in place of a point.
std::optional<double> file_number(std::string_view word, bool decimal_comma = false);

/// InvalidArgument at a place of a file, from 1; column 0: the line alone.
absl::Status fault_at(const std::string& name, int line, int column, const std::string& what);
std::string note_at(const std::string& name, int line, const std::string& what);

/// The text without blanks at its ends; control characters and marks of byte order become blanks.
std::string label_text(std::string_view text);

/// Words between blanks, commas and semicolons, from line to line.
class WordReader {
 public:
  WordReader(const std::vector<std::string_view>& lines, std::size_t first_line)
      : lines_(lines), line_(first_line) {}

  /// The next word; empty at the end of the file.
  std::string_view next();
  /// Place of the latest word, from 1; at the end of the file, of the last line.
  int line() const { return place_line_; }
  int column() const { return place_column_; }
  bool used_comma() const { return used_comma_; }
  /// Whether all words of the latest one's line were read.
  bool at_end_of_line();
  /// Goes to the line after the latest word's.
  void skip_line();
  /// Bytes that are left: words are at most half as many.
  std::size_t bytes_left() const;

 private:
  const std::vector<std::string_view>& lines_;
  std::size_t line_ = 0, offset_ = 0;
  int place_line_ = 1, place_column_ = 0;
  bool used_comma_ = false;
};

}  // namespace tessera::photometry
