#include "layers/expression.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"

namespace tessera::layers {

namespace {

constexpr std::uint32_t bit(Event event) { return 1u << static_cast<int>(event); }
constexpr std::uint32_t bit(Source source) { return 1u << static_cast<int>(source); }

constexpr std::uint32_t kDiffuse = bit(Event::kDiffuseReflection) | bit(Event::kDiffuseTransmission);
constexpr std::uint32_t kGlossy = bit(Event::kGlossyReflection) | bit(Event::kGlossyTransmission);
constexpr std::uint32_t kSpecular = bit(Event::kSpecularReflection) | bit(Event::kSpecularTransmission);
constexpr std::uint32_t kReflection =
    bit(Event::kDiffuseReflection) | bit(Event::kGlossyReflection) | bit(Event::kSpecularReflection);
constexpr std::uint32_t kTransmission =
    bit(Event::kDiffuseTransmission) | bit(Event::kGlossyTransmission) | bit(Event::kSpecularTransmission);
constexpr std::uint32_t kAllEvents = (1u << kEvents) - 1;
constexpr std::uint32_t kAllSources = (1u << kSources) - 1;

/// The points that a letter stands for; nothing for other characters.
std::optional<PointSet> points_of(char letter) {
  switch (letter) {
    case 'C':
    case 'E':
      return PointSet{.eye = true};
    case 'L':
      return PointSet{.sources = kAllSources};
    case 'O':
      return PointSet{.sources = bit(Source::kSurface)};
    case 'B':
      return PointSet{.sources = bit(Source::kBackground)};
    case 'D':
      return PointSet{.events = kDiffuse};
    case 'G':
      return PointSet{.events = kGlossy};
    case 'S':
      return PointSet{.events = kSpecular};
    case 'R':
      return PointSet{.events = kReflection};
    case 'T':
      return PointSet{.events = kTransmission};
    case 'V':
      return PointSet{.events = bit(Event::kVolume)};
    case '.':
      return PointSet{.events = kAllEvents, .sources = kAllSources};
    default:
      return std::nullopt;
  }
}

/// Whether no path has a point of this set.
bool is_empty(const PointSet& points) { return !points.eye && points.events == 0 && points.sources == 0; }

class Parser {
 public:
  explicit Parser(std::string_view text) : text_(text) {}

  absl::StatusOr<Node> parse() {
    if (text_.size() > kMaxExpression)
      return absl::InvalidArgumentError(
          absl::StrCat("column ", kMaxExpression + 1, ": more than ", kMaxExpression, " characters"));
    Node root;
    if (choice(root) && !at_end()) fail(absl::StrCat("'", std::string(1, peek()), "' has nothing to close"));
    if (!error_ && camera_column_ == 0 && light_column_ == 0) {
      position_ = text_.size();
      fail("an expression begins with C, at the camera, or ends with E, at the eye");
    }
    if (error_) return absl::InvalidArgumentError(absl::StrCat("column ", error_column_, ": ", *error_));
    if (light_column_ != 0) reverse(root);
    return root;
  }

 private:
  bool fail(std::string what) {
    if (!error_) error_ = std::move(what), error_column_ = position_ + 1;
    return false;
  }
  void skip_spaces() {
    while (position_ < text_.size() && (text_[position_] == ' ' || text_[position_] == '\t')) ++position_;
  }
  bool at_end() {
    skip_spaces();
    return position_ == text_.size();
  }
  /// 0 at the end.
  char peek() { return at_end() ? '\0' : text_[position_]; }
  bool take(char c) {
    if (peek() != c || c == '\0') return false;
    ++position_;
    return true;
  }
  bool expect(char c, const char* of) {
    if (take(c)) return true;
    return fail(absl::StrCat("'", std::string(1, c), "' was expected at the end of ", of));
  }

  bool choice(Node& node) {
    if (++depth_ > kMaxNesting) return fail(absl::StrCat("nested more than ", kMaxNesting, " deep"));
    node.kind = Node::Kind::kChoice;
    do {
      if (!sequence(node.children.emplace_back())) return false;
    } while (take('|'));
    --depth_;
    return true;
  }

  bool sequence(Node& node) {
    node.kind = Node::Kind::kSequence;
    while (peek() != '\0' && peek() != '|' && peek() != ')') {
      if (!repetition(node.children)) return false;
    }
    if (!node.children.empty()) return true;
    return fail("an event, a light or the camera was expected");
  }

  bool repetition(std::vector<Node>& nodes) {
    Node node;
    if (!symbol(node)) return false;
    int signs = 0;
    for (;; ++signs) {
      if (signs > kMaxNesting) return fail("too many repetitions of one thing");
      int least = 0, most = kForEver;
      if (take('+')) {
        least = 1;
      } else if (take('?')) {
        most = 1;
      } else if (peek() == '{') {
        if (!braces(least, most)) return false;
      } else if (!take('*')) {
        break;
      }
      Node repeat{.kind = Node::Kind::kRepeat, .least = least, .most = most};
      repeat.children.push_back(std::move(node));
      node = std::move(repeat);
    }
    nodes.push_back(std::move(node));
    return true;
  }

  bool braces(int& least, int& most) {
    take('{');
    if (!number(least)) return false;
    most = least;
    if (take(',')) {
      most = kForEver;
      if (peek() != '}' && !number(most)) return false;
      if (most != kForEver && most < least) return fail(absl::StrCat(least, " is more than ", most));
    }
    if (most == 0) return fail("nothing is repeated 0 times");
    return expect('}', "a number of repetitions");
  }

  bool number(int& value) {
    if (peek() < '0' || peek() > '9') return fail("a number was expected");
    for (value = 0; peek() >= '0' && peek() <= '9'; ++position_) {
      value = value * 10 + (text_[position_] - '0');
      if (value > kMaxRepetitions) return fail(absl::StrCat("more than ", kMaxRepetitions, " repetitions"));
    }
    return true;
  }

  bool symbol(Node& node) {
    if (take('(')) return choice(node) && expect(')', "a group");
    if (take('[')) {
      node.negated = take('^');
      do {
        if (!one_point(node.points.emplace_back())) return false;
      } while (peek() != ']' && peek() != '\0');
      if (node.negated && std::ranges::any_of(node.points, &PointSet::eye))
        return fail("the camera stands in no such set");
      return expect(']', "a set");
    }
    return one_point(node.points.emplace_back());
  }

  bool one_point(PointSet& points) {
    if (peek() == '<') return bracket(points);
    const auto found = points_of(peek());
    if (!found) return unknown("an event (D G S R T V .), a light (L O B), the camera (C or E)");
    points = *found;
    if (points.eye && !note_eye(peek())) return false;
    ++position_;
    return true;
  }

  bool unknown(const char* expected) {
    if (peek() == '\0') return fail(absl::StrCat("the expression ends where ", expected, " was expected"));
    return fail(absl::StrCat("'", std::string(1, peek()), "' is unknown here; ", expected, " was expected"));
  }

  /// C and E say in which order the expression is written.
  bool note_eye(char letter) {
    std::size_t& column = letter == 'C' ? camera_column_ : light_column_;
    if (column == 0) column = position_ + 1;
    if (camera_column_ == 0 || light_column_ == 0) return true;
    return fail("C (from the camera) and E (from the light) do not go together");
  }

  /// "<RD'name'>": a kind of event, a lobe, names.
  bool bracket(PointSet& points) {
    const std::size_t begin = position_;
    take('<');
    if (!letters(points, "RTVLOB", "a kind of event (R T V .) or of light (L O B)")) return false;
    PointSet lobe{.events = kAllEvents, .sources = kAllSources};
    if (peek() != '>' && !names_follow() && !letters(lobe, "DGS", "a lobe (D G S .), names or '>'"))
      return false;
    points.events &= lobe.events;
    points.sources &= lobe.sources;
    while (peek() != '>' && peek() != '\0') {
      if (!names(points.tests.emplace_back())) return false;
    }
    if (!expect('>', "an event")) return false;
    if (!is_empty(points)) return true;
    position_ = begin;
    return fail("there is no such event: lobes are of reflection and transmission");
  }

  /// One of `allowed`, a point, or a set of them.
  bool letters(PointSet& points, std::string_view allowed, const char* expected) {
    points = {};
    const auto one = [&] {
      if (peek() == '\0' || (peek() != '.' && allowed.find(peek()) == std::string_view::npos))
        return unknown(expected);
      const PointSet more = *points_of(peek());
      points.events |= more.events;
      points.sources |= more.sources;
      ++position_;
      return true;
    };
    if (!take('[')) return one();
    const bool negated = take('^');
    do {
      if (!one()) return false;
    } while (peek() != ']' && peek() != '\0');
    if (negated) points.events = kAllEvents & ~points.events, points.sources = kAllSources & ~points.sources;
    return expect(']', "a set");
  }

  static bool is_quote(char c) { return c == '\'' || c == '"'; }
  /// Names, or a set of them, and not a set of lobes.
  bool names_follow() {
    const char c = peek();
    if (is_quote(c) || c == 'o' || c == 'm') return true;
    if (c != '[') return false;
    const std::size_t inside = text_.find_first_not_of(" \t^", position_ + 1);
    return inside != std::string_view::npos && is_quote(text_[inside]);
  }

  bool names(NameTest& test) {
    if (take('o')) {
      test.scope = Scope::kObject;
    } else if (take('m')) {
      test.scope = Scope::kMaterial;
    }
    if (!take('[')) return name(test);
    test.negated = take('^');
    do {
      if (!name(test)) return false;
    } while (peek() != ']' && peek() != '\0');
    std::ranges::sort(test.names);
    test.names.erase(std::unique(test.names.begin(), test.names.end()), test.names.end());
    return expect(']', "a set of names");
  }

  bool name(NameTest& test) {
    const char quote = peek();
    if (!is_quote(quote)) return unknown("a name in quotes");
    const std::size_t end = text_.find(quote, position_ + 1);
    if (end == std::string_view::npos) return fail("the name has no end");
    if (end == position_ + 1) return fail("the name is empty");
    test.names.emplace_back(text_.substr(position_ + 1, end - position_ - 1));
    position_ = end + 1;
    return true;
  }

  static void reverse(Node& node) {
    if (node.kind == Node::Kind::kSequence) std::ranges::reverse(node.children);
    for (Node& child : node.children) reverse(child);
  }

  const std::string_view text_;
  std::size_t position_ = 0;
  int depth_ = 0;
  std::size_t camera_column_ = 0, light_column_ = 0;  // columns of the first C and E; 0: none
  std::optional<std::string> error_;
  std::size_t error_column_ = 0;
};

}  // namespace

absl::StatusOr<Node> parse_expression(std::string_view text) { return Parser(text).parse(); }

void collect_names(const Node& node, std::vector<std::string>& names) {
  for (const PointSet& points : node.points) {
    for (const NameTest& test : points.tests) names.insert(names.end(), test.names.begin(), test.names.end());
  }
  for (const Node& child : node.children) collect_names(child, names);
}

}  // namespace tessera::layers
