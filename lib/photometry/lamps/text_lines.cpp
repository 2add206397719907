#include "photometry/lamps/text_lines.h"

#include <algorithm>
#include <cstddef>

#include "absl/strings/str_cat.h"
#include "photometry/units/spelling.h"

namespace tessera::photometry {
namespace {

constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";

bool separates(char c) { return c == ' ' || c == '\t' || c == ',' || c == ';' || c == '\f' || c == '\v'; }

}  // namespace

std::vector<std::string_view> lines_of(std::string_view text) {
  while (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  const std::size_t end = text.find_first_of(std::string_view("\0\x1a", 2));
  if (end != std::string_view::npos) text = text.substr(0, end);
  std::vector<std::string_view> lines;
  while (!text.empty()) {
    const std::size_t length = std::min(text.find_first_of("\r\n"), text.size());
    lines.push_back(text.substr(0, length));
    text.remove_prefix(length);
    text.remove_prefix(text.starts_with("\r\n") ? 2 : text.empty() ? 0 : 1);
  }
  return lines;
}

std::optional<double> file_number(std::string_view word, bool decimal_comma) {
  if (const auto plain = whole_number(word)) return plain;
  std::string changed(word);
  for (char& c : changed) {
    if (c == 'D' || c == 'd') c = 'e';
    if (decimal_comma && c == ',') c = '.';
  }
  if (changed.ends_with('.')) changed += '0';
  return whole_number(changed);
}

absl::Status fault_at(const std::string& name, int line, int column, const std::string& what) {
  return absl::InvalidArgumentError(column > 0 ? absl::StrCat(name, ":", line, ":", column, ": ", what)
                                               : absl::StrCat(name, ":", line, ": ", what));
}

std::string note_at(const std::string& name, int line, const std::string& what) {
  return absl::StrCat(name, ":", line, ": ", what);
}

std::string label_text(std::string_view text) {
  std::string result(text);
  for (std::size_t at = result.find(kByteOrderMark); at != std::string::npos;
       at = result.find(kByteOrderMark))
    result.replace(at, kByteOrderMark.size(), " ");
  for (char& c : result) {
    if (static_cast<unsigned char>(c) < ' ' || c == 127) c = ' ';
  }
  return std::string(without_blanks(result));
}

std::string_view WordReader::next() {
  for (; line_ < lines_.size(); ++line_, offset_ = 0) {
    const std::string_view line = lines_[line_];
    while (offset_ < line.size() && separates(line[offset_])) {
      used_comma_ = used_comma_ || line[offset_] == ',' || line[offset_] == ';';
      ++offset_;
    }
    if (offset_ == line.size()) continue;
    std::size_t end = offset_;
    while (end < line.size() && !separates(line[end])) ++end;
    place_line_ = static_cast<int>(line_) + 1, place_column_ = static_cast<int>(offset_) + 1;
    const std::string_view word = line.substr(offset_, end - offset_);
    offset_ = end;
    return word;
  }
  place_line_ = std::max(1, static_cast<int>(lines_.size())), place_column_ = 0;
  return {};
}

bool WordReader::at_end_of_line() {
  if (line_ >= lines_.size()) return true;
  const std::string_view rest = lines_[line_].substr(offset_);
  return std::ranges::all_of(rest, separates);
}

void WordReader::skip_line() {
  if (line_ < lines_.size()) ++line_;
  offset_ = 0;
}

std::size_t WordReader::bytes_left() const {
  std::size_t sum = 0;
  for (std::size_t i = line_; i < lines_.size(); ++i) sum += lines_[i].size() + 1;
  return sum;
}

}  // namespace tessera::photometry
