#include "command/report/table.h"

#include <unistd.h>

#include <algorithm>
#include <utility>

#include "base/printable.h"
#include "command/report/progress.h"

namespace tessera::client {
namespace {

constexpr std::size_t kGap = 2;
constexpr std::size_t kNarrowestColumn = 8;  // columns that shrink keep this width
constexpr char kCut[] = "...";

bool continues_character(char c) { return (static_cast<unsigned char>(c) & 0xc0) == 0x80; }

/// Width in characters, where each takes one column.
std::size_t width_of(const std::string& text) {
  return static_cast<std::size_t>(
      std::ranges::count_if(text, [](char c) { return !continues_character(c); }));
}

std::string cut(const std::string& text, std::size_t width) {
  if (width_of(text) <= width) return text;
  std::size_t end = 0;
  for (std::size_t characters = 0; end < text.size(); ++end) {
    if (!continues_character(text[end]) && characters++ == width - (sizeof kCut - 1)) break;
  }
  return text.substr(0, end) + kCut;
}

}  // namespace

void Table::add(std::vector<std::string> cells) {
  for (std::string& cell : cells) cell = base::printable(cell);
  rows_.push_back(std::move(cells));
}

std::vector<std::size_t> Table::widths(std::size_t width) const {
  std::vector<std::size_t> widths(columns_.size(), 0);
  std::size_t sum = 0;
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    for (const auto& row : rows_) widths[c] = std::max(widths[c], width_of(row[c]));
    if (widths[c] == 0) continue;
    widths[c] = std::max(widths[c], width_of(columns_[c].heading));
    sum += widths[c] + kGap;
  }
  sum -= std::min(sum, kGap);
  // The widest gives first.
  while (width > 0 && sum > width) {
    std::size_t widest = columns_.size();
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      if (!columns_[c].shrinks || widths[c] <= kNarrowestColumn) continue;
      if (widest == columns_.size() || widths[c] > widths[widest]) widest = c;
    }
    if (widest == columns_.size()) break;
    --widths[widest];
    --sum;
  }
  return widths;
}

std::string Table::text(std::size_t width) const {
  const std::vector<std::size_t> widths = this->widths(width);
  std::string text;
  const auto add_line = [&](const auto& cell_of) {
    std::string line;
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      if (widths[c] == 0) continue;
      const std::string cell = cut(cell_of(c), widths[c]);
      const std::string blank(widths[c] - width_of(cell), ' ');
      if (!line.empty()) line.append(kGap, ' ');
      line += columns_[c].right ? blank + cell : cell + blank;
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + '\n';
  };
  add_line([&](std::size_t c) { return std::string{columns_[c].heading}; });
  for (const auto& row : rows_) add_line([&](std::size_t c) { return row[c]; });
  return text;
}

std::size_t table_width(int file_descriptor) {
  return ::isatty(file_descriptor) ? static_cast<std::size_t>(terminal_columns(file_descriptor)) : 0;
}

}  // namespace tessera::client
