#include "layers/layer_rule.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <string>

#include "absl/strings/str_cat.h"

namespace tessera::layers {

namespace {

constexpr int kMostVertices = 65'536;
constexpr std::string_view kAllPaths = "L.*E";

bool is_space(char c) { return c == ' ' || c == '\t'; }

class RuleParser {
 public:
  explicit RuleParser(std::string_view text) : text_(text) {}

  absl::StatusOr<LayerRule> parse() {
    LayerRule rule;
    skip_spaces();
    // Expressions have no small letters but in names.
    if (position_ < text_.size() && text_[position_] >= 'a' && text_[position_] <= 'z') {
      if (!part(rule))
        return absl::InvalidArgumentError(absl::StrCat("column ", position_ + 1, ": ", error_));
      skip_spaces();
      if (position_ == text_.size()) return with_paths(rule, std::string(kAllPaths));
      if (!take(":")) {
        return absl::InvalidArgumentError(
            absl::StrCat("column ", position_ + 1, ": ':' was expected, and an expression behind it"));
      }
    }
    // Spaces in place of what was read, so that columns are those of the whole text.
    return with_paths(rule, std::string(position_, ' ').append(text_.substr(position_)));
  }

 private:
  static absl::StatusOr<LayerRule> with_paths(LayerRule& rule, const std::string& expression) {
    absl::StatusOr<Node> paths = parse_expression(expression);
    if (!paths.ok()) return paths.status();
    rule.paths = *std::move(paths);
    return std::move(rule);
  }
  bool fail(std::string what) {
    error_ = std::move(what);
    return false;
  }
  void skip_spaces() {
    while (position_ < text_.size() && is_space(text_[position_])) ++position_;
  }
  bool take(std::string_view word) {
    if (!text_.substr(position_).starts_with(word)) return false;
    position_ += word.size();
    return true;
  }

  bool part(LayerRule& rule) {
    if (take("shadow")) {
      rule.part = Part::kShadow;
      return true;
    }
    rule.part = Part::kOfStrategies;
    if (take("unweighted")) {
      rule.part = Part::kUnweighted;
      skip_spaces();
    }
    return strategies(rule.strategies);
  }

  bool strategies(Strategies& strategies) {
    if (take("d")) return number(strategies.least_events) && expect("+");
    if (!take("s")) return fail("shadow, unweighted, a strategy such as s1t2, or an expression was expected");
    return number_or_any(strategies.s) && expect("t") && number_or_any(strategies.t);
  }
  bool expect(const char* word) { return take(word) || fail(absl::StrCat("'", word, "' was expected")); }
  bool number_or_any(int& number_or) { return take("*") || number(number_or); }
  bool number(int& result) {
    const char* const begin = text_.data() + position_;
    const auto [end, error] = std::from_chars(begin, text_.data() + text_.size(), result);
    if (error != std::errc{} || result < 0 || result > kMostVertices)
      return fail(absl::StrCat("a number from 0 to ", kMostVertices, " was expected"));
    position_ += static_cast<std::size_t>(end - begin);
    return true;
  }

  const std::string_view text_;
  std::size_t position_ = 0;
  std::string error_;
};

}  // namespace

absl::StatusOr<LayerRule> parse_rule(std::string_view text) { return RuleParser(text).parse(); }

}  // namespace tessera::layers
