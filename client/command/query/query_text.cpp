#include "command/query/query_text.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "absl/strings/str_cat.h"
#include "base/printable.h"

namespace tessera::client {
namespace {

constexpr std::string_view kBlanks = " \t\r\n\v\f";

/// Words of a line, with their columns.
class LineWords {
 public:
  explicit LineWords(std::string_view line) : line_(line.substr(0, line.find('#'))) {}

  /// Empty at the end.
  std::string_view next() {
    at_ = std::min(line_.find_first_not_of(kBlanks, at_), line_.size());
    const std::size_t end = std::min(line_.find_first_of(" \t\r\n\v\f,", at_), line_.size());
    start_ = at_;
    const std::string_view word = line_.substr(at_, end - at_);
    at_ = std::min(line_.find_first_not_of(kBlanks, end), line_.size());
    if (at_ < line_.size() && line_[at_] == ',') ++at_;
    return word;
  }
  bool at_end() const { return line_.find_first_not_of(kBlanks, at_) == line_.npos; }
  /// The column of the word that was read last.
  std::uint32_t column() const { return static_cast<std::uint32_t>(start_) + 1; }

 private:
  std::string_view line_;
  std::size_t at_ = 0, start_ = 0;
};

std::string in_quotes(std::string_view word) {
  return absl::StrCat("'", base::printable(std::string(word.substr(0, 40))), "'");
}

/// The fault of a number, or nothing.
std::string read_number(std::string_view word, double& value) {
  if (!word.empty() && word.front() == '+') word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error == std::errc::result_out_of_range && end == word.data() + word.size())
    return absl::StrCat(in_quotes(word), " is beyond what doubles hold");
  if (error != std::errc{} || end != word.data() + word.size())
    return absl::StrCat("expected a number instead of ", in_quotes(word));
  if (!std::isfinite(value)) return absl::StrCat(in_quotes(word), " is not a finite number");
  if (std::abs(value) > kLargestQueryNumber) return absl::StrCat(in_quotes(word), " is beyond 1e18");
  return "";
}

}  // namespace

std::optional<QueryKind> query_kind(std::string_view word) {
  if (word == "ray") return QueryKind::kRay;
  if (word == "inside") return QueryKind::kInside;
  if (word == "closest") return QueryKind::kClosest;
  return std::nullopt;
}

ParsedQuery parse_query(std::string_view line, std::optional<QueryKind> kind) {
  LineWords words(line);
  if (words.at_end()) return {};
  std::string_view word = words.next();
  const auto wrong = [&](std::string message) {
    return ParsedQuery{std::nullopt, std::move(message), words.column()};
  };
  if (const std::optional<QueryKind> named = query_kind(word)) {
    if (kind && *kind != *named)
      return wrong(absl::StrCat(in_quotes(word), " is not what the lines are said to be"));
    kind = named;
    word = words.next();
  } else if (!kind) {
    return wrong(absl::StrCat("expected ray, inside or closest instead of ", in_quotes(word)));
  }
  Query query;
  query.kind = *kind;
  const int wanted = query.kind == QueryKind::kRay ? 6 : 3;
  for (int i = 0; i < wanted; ++i) {
    if (i > 0) word = words.next();
    if (word.empty()) return wrong(absl::StrCat("expected ", wanted, " numbers; there are ", i));
    double& value = i < 3 ? query.point[i] : query.direction[i - 3];
    if (std::string error = read_number(word, value); !error.empty()) return wrong(std::move(error));
  }
  if (!words.at_end()) {
    word = words.next();
    return wrong(absl::StrCat("expected ", wanted, " numbers, and then ", in_quotes(word)));
  }
  const double* const d = query.direction;
  if (query.kind == QueryKind::kRay &&
      !(std::max({std::abs(d[0]), std::abs(d[1]), std::abs(d[2])}) >= 1 / kLargestQueryNumber))
    return wrong("the direction has no length, or one below 1e-18");
  return {query, "", 0};
}

}  // namespace tessera::client
