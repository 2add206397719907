#include "import/pbrt/file/tokenizer.h"

#include <charconv>

#include "wire/scene_numbers.h"

namespace tessera::client::pbrt {
namespace {

bool is_space(char c) { return c == ' ' || c == '\n' || c == '\t' || c == '\r'; }
bool ends_word(char c) { return is_space(c) || c == '"' || c == '[' || c == ']' || c == '#'; }

/// Reads a number that a scene may hold and that begins at `p`; returns its end, or null.
const char* read_finite(const char* p, const char* end, double& value) {
  if (p < end && *p == '+') ++p;
  const auto [rest, error] = std::from_chars(p, end, value);
  if (error == std::errc::result_out_of_range) {
    // Too small for a double is zero; too large is not a number that anything can use.
    const std::string_view digits(p, static_cast<std::size_t>(rest - p));
    if (digits.find("e-") == std::string_view::npos && digits.find("E-") == std::string_view::npos)
      return nullptr;
    value = 0;
    return rest;
  }
  return error == std::errc{} && wire::is_scene_number(value) ? rest : nullptr;
}

}  // namespace

Tokenizer::Tokenizer(std::string_view text, std::uint32_t file)
    : p_(text.data()), end_(text.data() + text.size()), line_begin_(text.data()), file_(file) {
  if (text.starts_with("\xEF\xBB\xBF")) p_ += 3;  // a byte order mark of UTF-8
}

SourceLocation Tokenizer::where() const {
  return {file_, line_, static_cast<std::uint32_t>(p_ - line_begin_) + 1};
}

void Tokenizer::skip_space_and_comments() {
  while (p_ < end_) {
    if (*p_ == '\n') {
      ++line_;
      line_begin_ = ++p_;
    } else if (is_space(*p_)) {
      ++p_;
    } else if (*p_ == '#') {
      while (p_ < end_ && *p_ != '\n') ++p_;
    } else {
      return;
    }
  }
}

bool Tokenizer::read_number(double& value) {
  skip_space_and_comments();
  if (p_ == end_ || *p_ == '"' || *p_ == '[' || *p_ == ']') return false;
  const char* rest = read_finite(p_, end_, value);
  if (rest == nullptr || (rest < end_ && !ends_word(*rest))) return false;
  p_ = rest;
  return true;
}

Token Tokenizer::read_string() {
  Token token{TokenKind::kString, {}, where()};
  const char* begin = ++p_;
  while (p_ < end_ && *p_ != '"' && *p_ != '\n') {
    if (*p_ == '\\' && p_ + 1 < end_ && p_[1] != '\n') ++p_;
    ++p_;
  }
  token.text = {begin, static_cast<std::size_t>(p_ - begin)};
  if (p_ == end_ || *p_ == '\n') {
    token.kind = TokenKind::kProblem;
    token.text = "a string without a closing quote";
  } else {
    ++p_;
  }
  return token;
}

Token Tokenizer::next() {
  skip_space_and_comments();
  Token token{TokenKind::kEnd, {}, where()};
  if (p_ == end_) return token;
  if (*p_ == '"') return read_string();
  const char* begin = p_++;
  if (*begin == '[') {
    token.kind = TokenKind::kOpen;
  } else if (*begin == ']') {
    token.kind = TokenKind::kClose;
  } else {
    token.kind = TokenKind::kWord;
    while (p_ < end_ && !ends_word(*p_)) ++p_;
  }
  token.text = {begin, static_cast<std::size_t>(p_ - begin)};
  return token;
}

std::optional<double> parse_number(std::string_view text) {
  double value = 0;
  const char* end = text.data() + text.size();
  return read_finite(text.data(), end, value) == end ? std::optional(value) : std::nullopt;
}

std::optional<std::string> unescape(std::string_view text) {
  std::string result;
  result.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '\\') {
      result.push_back(text[i]);
      continue;
    }
    if (++i == text.size()) return std::nullopt;
    switch (text[i]) {
      case 'b':
        result.push_back('\b');
        break;
      case 'f':
        result.push_back('\f');
        break;
      case 'n':
        result.push_back('\n');
        break;
      case 'r':
        result.push_back('\r');
        break;
      case 't':
        result.push_back('\t');
        break;
      case '\\':
      case '\'':
      case '"':
        result.push_back(text[i]);
        break;
      default:
        return std::nullopt;
    }
  }
  return result;
}

}  // namespace tessera::client::pbrt
