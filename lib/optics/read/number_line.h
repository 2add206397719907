// Lines of text with words and numbers, and where they stand: what readers of lens files share.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tessera::optics {

struct Word {
  std::string_view text;
  int column = 1;
};
struct TextLine {
  std::vector<Word> words;
  int number = 1;
  bool indented = false;
};

/// UTF-8 without its mark, and UTF-16 of either order, as their ASCII part with "?" for the rest; other text
/// as it is. Half a character at the end is left out.
std::string plain_text(std::string_view bytes);

/// All lines that have words, in order; from `comment` on (0: never) a line has none. Quoted words may have
/// blanks, and lose their quotes. The text must outlive them.
std::vector<TextLine> lines_of(std::string_view text, char comment);

/// The whole word as a finite number.
std::optional<double> number_of(std::string_view word);

}  // namespace tessera::optics
