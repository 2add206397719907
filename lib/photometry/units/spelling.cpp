#include "photometry/units/spelling.h"

#include <array>
#include <charconv>
#include <cstddef>
#include <utility>

namespace tessera::photometry {
namespace {

struct Rewriting {
  std::string_view from, to;
};

/// UTF-8 of signs that have a plain spelling.
constexpr Rewriting kRewritings[] = {
    {"\u00b7", "*"}, {"\u22c5", "*"}, {"\u2219", "*"}, {"\u00d7", "*"}, {"\u2062", "*"},  // dots and crosses
    {"\u207b", "-"}, {"\u2212", "-"}, {"\u2070", "0"}, {"\u00b9", "1"}, {"\u00b2", "2"}, {"\u00b3", "3"},
    {"\u2074", "4"}, {"\u00b5", "u"}, {"\u03bc", "u"}, {"\u00a0", " "}, {"\u202f", " "}, {"**", "^"}};

std::string plain(std::string_view text) {
  std::string result;
  while (!text.empty()) {
    std::string_view to = text.substr(0, 1);
    std::size_t taken = 1;
    for (const Rewriting& rewriting : kRewritings) {
      if (!text.starts_with(rewriting.from)) continue;
      to = rewriting.to, taken = rewriting.from.size();
      break;
    }
    result += to;
    text.remove_prefix(taken);
  }
  return result;
}

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

class ProductReader {
 public:
  explicit ProductReader(std::string_view text) : left_(text) {}

  /// Whether all of it was read.
  bool read() { return product(1, 0) && left_.empty(); }
  std::vector<UnitFactor> take() { return std::move(factors_); }

 private:
  void skip_blanks() {
    while (left_.starts_with(' ')) left_.remove_prefix(1);
  }
  bool take_if(std::string_view word) {
    if (!left_.starts_with(word)) return false;
    left_.remove_prefix(word.size());
    return true;
  }

  /// Factors up to the end or a parenthesis, with powers times `outer`; behind a slash, times its opposite.
  bool product(int outer, int depth) {
    constexpr int kDeepest = 4;
    if (depth > kDeepest) return false;
    int sign = outer;
    bool expects_factor = true;
    for (;;) {
      skip_blanks();
      if (left_.empty() || left_.starts_with(')')) return !expects_factor;
      const bool divides = take_if("/") || take_if("per ");
      if (divides || take_if("*") || take_if(".")) {
        if (expects_factor) return false;
        if (divides) sign = -outer;
        expects_factor = true;
        continue;
      }
      if (take_if("(")) {
        if (!product(sign, depth + 1) || !take_if(")")) return false;
      } else if (!factor(sign)) {
        return false;
      }
      expects_factor = false;
    }
  }

  bool factor(int sign) {
    std::size_t letters = 0;
    while (letters < left_.size() && is_letter(left_[letters])) ++letters;
    if (letters == 0) return false;
    UnitFactor one{std::string(left_.substr(0, letters)), sign};
    left_.remove_prefix(letters);
    const bool raised = take_if("^");
    int sign_of_power = 1;
    if (left_.size() > 1 && (left_[0] == '-' || left_[0] == '+') && is_digit(left_[1])) {
      if (left_[0] == '-') sign_of_power = -1;
      left_.remove_prefix(1);
    }
    if (!left_.empty() && is_digit(left_[0])) {
      one.power *= sign_of_power * (left_[0] - '0');
      left_.remove_prefix(1);
      if (!left_.empty() && is_digit(left_[0])) return false;
    } else if (raised) {
      return false;
    }
    factors_.push_back(std::move(one));
    return true;
  }

  std::string_view left_;
  std::vector<UnitFactor> factors_;
};

}  // namespace

std::optional<std::vector<UnitFactor>> factors_of(std::string_view text) {
  const std::string spelled = plain(without_blanks(text));
  ProductReader reader(spelled);
  if (!reader.read()) return std::nullopt;
  return reader.take();
}

std::string lower(std::string_view text) {
  std::string result(text);
  for (char& c : result) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return result;
}

std::string_view without_blanks(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r\n";
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

std::optional<double> whole_number(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || text.empty()) return std::nullopt;
  return value;
}

std::string shortest(double value) {
  std::array<char, 32> text;
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), value);
  return {text.data(), end};
}

}  // namespace tessera::photometry
