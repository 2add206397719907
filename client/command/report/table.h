// Text in columns.
#pragma once

#include <string>
#include <vector>

namespace tessera::client {

/// Cells may hold anything: what a terminal would act upon is escaped. A column without any content is left
/// out.
class Table {
 public:
  struct Column {
    const char* heading;
    bool right = false;    // numbers
    bool shrinks = false;  // is cut, "name...", where a line would be too long
  };

  explicit Table(std::vector<Column> columns) : columns_(std::move(columns)) {}

  /// One cell a column.
  void add(std::vector<std::string> cells);

  /// A heading and one line a row, each at most `width` characters where columns that shrink can make it so.
  /// 0: any.
  std::string text(std::size_t width) const;

 private:
  std::vector<std::size_t> widths(std::size_t width) const;

  std::vector<Column> columns_;
  std::vector<std::vector<std::string>> rows_;
};

/// Width for tables on this output: that of its terminal; 0, as wide as it takes, for a file or a pipe.
std::size_t table_width(int file_descriptor);

}  // namespace tessera::client
