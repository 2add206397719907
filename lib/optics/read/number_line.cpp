#include "optics/read/number_line.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "absl/strings/ascii.h"

namespace tessera::optics {

namespace {

std::vector<Word> words_of(std::string_view line) {
  std::vector<Word> words;
  for (std::size_t i = 0; i < line.size();) {
    if (absl::ascii_isspace(static_cast<unsigned char>(line[i]))) {
      ++i;
      continue;
    }
    const std::size_t first = i;
    if (line[i] == '"') {
      const std::size_t end = std::min(line.find('"', i + 1), line.size());
      words.push_back({line.substr(first + 1, end - first - 1), static_cast<int>(first) + 1});
      i = end + 1;
      continue;
    }
    while (i < line.size() && !absl::ascii_isspace(static_cast<unsigned char>(line[i]))) ++i;
    words.push_back({line.substr(first, i - first), static_cast<int>(first) + 1});
  }
  return words;
}

}  // namespace

std::string plain_text(std::string_view bytes) {
  const bool little = bytes.starts_with("\xff\xfe"), big = bytes.starts_with("\xfe\xff");
  if (!little && !big) return std::string(bytes.starts_with("\xef\xbb\xbf") ? bytes.substr(3) : bytes);
  std::string text;
  for (std::size_t i = 2; i + 1 < bytes.size(); i += 2) {
    const char low = bytes[little ? i : i + 1], high = bytes[little ? i + 1 : i];
    text += high == 0 ? low : '?';
  }
  return text;
}

std::vector<TextLine> lines_of(std::string_view text, char comment) {
  std::vector<TextLine> lines;
  int number = 0;
  while (!text.empty()) {
    ++number;
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (comment != 0) line = line.substr(0, line.find(comment));
    TextLine found{words_of(line), number, !line.empty() && (line[0] == ' ' || line[0] == '\t')};
    if (!found.words.empty()) lines.push_back(std::move(found));
  }
  return lines;
}

std::optional<double> number_of(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

}  // namespace tessera::optics
