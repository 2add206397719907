#include "stress/input/number_sites.h"

#include <algorithm>
#include <cctype>

namespace tessera::stress {
namespace {

bool is_of_word(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '-' || c == '+' || c == '.';
}

/// Digits with a sign, a point and an exponent, and nothing else.
bool is_number(std::string_view word) {
  bool digits = false;
  for (std::size_t i = 0; i < word.size(); ++i) {
    const char c = word[i];
    const bool exponent = (c == 'e' || c == 'E') && digits && i + 1 < word.size();
    const bool sign = (c == '-' || c == '+') && (i == 0 || word[i - 1] == 'e' || word[i - 1] == 'E');
    const bool digit = std::isdigit(static_cast<unsigned char>(c));
    if (!digit && c != '.' && !exponent && !sign) return false;
    digits = digits || digit;
  }
  return digits;
}

}  // namespace

std::vector<NumberSite> number_sites(std::string_view text, TextKind kind) {
  std::vector<NumberSite> sites;
  char quote = 0;
  for (std::size_t i = 0; i < text.size();) {
    const char c = text[i];
    if (kind != TextKind::kPlain && (quote != 0 ? c == quote : c == '"' || c == '\'')) {
      quote = quote != 0 ? 0 : c;
      ++i;
    } else if (quote == 0 && kind == TextKind::kXml && text.substr(i).starts_with("<!--")) {
      i = std::min(text.find("-->", i), text.size());
    } else if (quote == 0 && kind != TextKind::kXml && c == '#') {
      i = std::min(text.find('\n', i), text.size());
    } else if (is_of_word(c)) {
      std::size_t end = i;
      while (end < text.size() && is_of_word(text[end])) ++end;
      const bool here = kind == TextKind::kPlain || (kind == TextKind::kXml) == (quote != 0);
      if (here && is_number(text.substr(i, end - i))) sites.push_back({i, end - i});
      i = end;
    } else {
      ++i;
    }
  }
  return sites;
}

std::string with_number(std::string_view text, NumberSite site, std::string_view replacement) {
  std::string result(text.substr(0, site.begin));
  result += replacement;
  result += text.substr(site.begin + site.length);
  return result;
}

}  // namespace tessera::stress
